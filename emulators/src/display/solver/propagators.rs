//! Propagators of recurring intervals.

use super::modal::{Mode, Propagator};
use crate::display::finger::NODES;
use crate::time::Nanos;

/// Number kept per wire: a pulse train needs two, its bursts and pauses a few more.
const MOST: usize = 16;

/// The propagators of one wire that were used last.
#[derive(Clone, Debug, Default)]
pub(super) struct Propagators {
    /// Propagators with their keys, the last used first.
    kept: Vec<Kept>,
}

#[derive(Clone, Debug)]
struct Kept {
    /// Place of the mode it belongs to.
    mode: usize,
    nanos: u64,
    whole: Box<Whole>,
}

/// All that a whole interval needs.
#[derive(Clone, Debug)]
pub(super) struct Whole {
    pub(super) propagator: Propagator,
    pub(super) ramp: [f64; NODES],
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
        let propagator = Propagator::new(mode, span);
        self.kept.truncate(MOST - 1);
        let new = Kept {
            mode: place,
            nanos,
            whole: Box::new(Whole {
                ramp: propagator.ramp(mode),
                propagator,
            }),
        };
        self.kept.insert(0, new);
    }

    /// The propagator that was prepared last.
    pub(super) fn first(&self) -> &Whole {
        &self.kept[0].whole
    }

    /// Drops the propagators of the mode at `place`, where another mode will stand.
    pub(super) fn forget(&mut self, place: usize) {
        self.kept.retain(|kept| kept.mode != place);
    }
}
