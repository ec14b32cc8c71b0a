//! Planned strokes in the loop: while one runs, its stimuli take the place of the live contacts.

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::illusion::{Dab, Planned};
use crate::units::Instant;

/// The strokes of a run and how far they are.
#[derive(Debug, Default)]
pub(super) struct Strokes {
    dabs: Box<[(Instant, Dab)]>,
    /// Start and end of each stroke.
    spans: Box<[(Instant, Instant)]>,
    next: usize,
}

impl Strokes {
    pub(super) fn new(strokes: &[Planned]) -> Self {
        let of = |s: &Planned| -> Vec<(Instant, Dab)> {
            s.dabs.iter().map(|d| (s.start + d.at, *d)).collect()
        };
        let mut dabs: Vec<(Instant, Dab)> = strokes.iter().flat_map(of).collect();
        dabs.sort_by_key(|(at, _)| *at);
        Self {
            dabs: dabs.into(),
            spans: strokes.iter().map(|s| (s.start, s.end)).collect(),
            next: 0,
        }
    }

    /// When the next stimulus begins.
    pub(super) fn next(&self) -> Instant {
        self.dabs
            .get(self.next)
            .map_or(Instant::FAR_FUTURE, |(at, _)| *at)
    }

    /// The newest stimulus that is due; older ones that were missed are left out.
    pub(super) fn due(&mut self, now: Instant) -> Option<(Instant, Dab)> {
        let mut newest = None;
        while let Some(dab) = self.dabs.get(self.next).filter(|(at, _)| *at <= now) {
            newest = Some(*dab);
            self.next += 1;
        }
        newest
    }

    /// Whether a stroke has the display at that time.
    pub(super) fn hold(&self, at: Instant) -> bool {
        self.spans
            .iter()
            .any(|(start, end)| *start <= at && at < *end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::{Duration, Point};

    #[test]
    fn stimuli_come_in_their_turn_and_missed_ones_are_left_out() {
        let at = |ms: u64| Instant::from_micros(1000 * ms);
        let dab = |ms: u64| Dab {
            at: Duration::from_millis(ms),
            duration: Duration::from_millis(30),
            place: Point::new(ms as f32, 0.0),
        };
        let planned = Planned {
            start: at(100),
            end: at(400),
            dabs: [dab(0), dab(60), dab(120)].into(),
        };
        let mut strokes = Strokes::new(&[planned]);
        assert_eq!(strokes.next(), at(100));
        assert_eq!(strokes.due(at(99)), None);
        assert_eq!(strokes.due(at(100)), Some((at(100), dab(0))));
        assert_eq!(strokes.due(at(300)), Some((at(220), dab(120))));
        assert_eq!(strokes.next(), Instant::FAR_FUTURE);
        assert!(!strokes.hold(at(99)) && strokes.hold(at(100)) && !strokes.hold(at(400)));
    }
}
