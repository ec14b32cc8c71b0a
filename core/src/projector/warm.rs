//! A warm face under the wires, as the loop is told of it.

use crate::units::Instant;

use super::{Output, Projector};

impl Output {
    /// Tells the guard of a warm face, as [`Guard::warm`](crate::guard::Guard::warm) does.
    pub fn warm(&mut self, at: Instant, face_c: f64, wanted_c: f64) -> f64 {
        self.guard.warm(at, face_c, wanted_c)
    }
}

impl Projector {
    /// Tells the guard of a warm face, as [`Guard::warm`](crate::guard::Guard::warm) does.
    pub fn warm(&mut self, at: Instant, face_c: f64, wanted_c: f64) -> f64 {
        self.output.warm(at, face_c, wanted_c)
    }
}
