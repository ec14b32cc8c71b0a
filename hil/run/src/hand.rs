//! Touches that come while a session runs: a hand on an emulated skin.

use std::sync::{Arc, Mutex, PoisonError};

use palpate_core::units::Point;
use palpate_emulators::sensor::{Press, Touches};
use palpate_emulators::time::Nanos;

/// Presses on one module from now on, until they are changed. Clones are the same hand.
#[derive(Clone, Debug, Default)]
pub struct Hand(Arc<Mutex<Vec<Press>>>);

impl Hand {
    /// Presses like this from now on: places on the module in mm, forces in N, diameters in mm.
    pub fn press(&self, presses: &[Press]) {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        held.clear();
        held.extend_from_slice(presses);
    }

    /// Every place that the hand presses.
    pub(crate) fn places(&self) -> Vec<Point> {
        let held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let pressing = held.iter().filter(|p| p.force_n > 0.0);
        pressing.map(|p| p.at).collect()
    }

    /// Place and force (N) of the only finger that presses; `None` for no finger or several.
    pub(crate) fn only(&self) -> Option<(Point, f64)> {
        let held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut pressing = held.iter().filter(|p| p.force_n > 0.0);
        let only = pressing.next()?;
        pressing.next().is_none().then_some((only.at, only.force_n))
    }
}

impl Touches for Hand {
    fn touches(&self, _now: Nanos, out: &mut Vec<Press>) {
        let held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        out.extend_from_slice(&held);
    }
}
