//! Propagators of recurring intervals.

use super::modal::{Mode, Propagator};
use crate::time::Nanos;

/// Kept per wire: a pulse train needs two, its bursts and pauses a few more.
const MOST: usize = 16;

/// The propagators of one wire that were used last.
#[derive(Clone, Debug, Default)]
pub(super) struct Propagators {
    /// The last used first.
    kept: Vec<Kept>,
}

#[derive(Clone, Debug)]
struct Kept {
    /// Place of the mode it belongs to.
    mode: usize,
    nanos: u64,
    propagator: Box<Propagator>,
}

impl Propagators {
    /// Puts the propagator over `nanos` first, computed unless it is there; `mode` stands at `place`.
    pub(super) fn prepare(&mut self, place: usize, mode: &Mode, nanos: u64) {
        let wanted = |kept: &Kept| kept.mode == place && kept.nanos == nanos;
        if let Some(found) = self.kept.iter().position(wanted) {
            self.kept[..=found].rotate_right(1);
            return;
        }
        let span = Nanos(nanos).as_secs_f64();
        self.kept.truncate(MOST - 1);
        let new = Kept {
            mode: place,
            nanos,
            propagator: Box::new(Propagator::new(mode, span)),
        };
        self.kept.insert(0, new);
    }

    /// The one that was prepared last.
    pub(super) fn first(&self) -> &Propagator {
        &self.kept[0].propagator
    }

    /// Drops those of the mode at `place`, where another will stand.
    pub(super) fn forget(&mut self, place: usize) {
        self.kept.retain(|kept| kept.mode != place);
    }
}
