//! State of a module as a whole: its common drift, its touch, and doubts about its board and its reference.

use core::ops::Range;

use super::reference::Part;
use super::relative::RelativeFrame;

/// Share of its strength at which a touch has ended.
pub(super) const ENDED: f32 = 0.5;
/// Widest drift of a taxel beyond its module's, as a share of that.
pub(super) const WIDEST: f32 = 0.7;
/// Time for which what is left of a touch stands still, s, and the largest share of the touch that a remainder is.
const STILL_S: f32 = 0.15;
const REMAINDER: f32 = 0.1;
/// Time constant with which a touch's strength is forgotten, s.
const LATELY_S: f32 = 1.0;

/// State of one module.
#[derive(Clone, Debug)]
pub(super) struct Together {
    pub(super) range: Range<usize>,
    /// Common drift, counts per second.
    pub(super) rate: [f32; 3],
    /// True while the module is touched.
    pub(super) open: bool,
    /// Corrections of its reference so far.
    pub(super) corrections: u32,
    /// The only taxel that the newest frame brought into contact, with a leap.
    pub(super) pending: Option<u32>,
    /// True once a lone leap was gone with the next frame: from then on a leap counts when it stays.
    pub(super) wary: bool,
    /// True while a lone leap of the newest frame waits for the next one.
    pub(super) waits: bool,
    /// Time without untouched taxels, s; negative after a common step.
    pub(super) unknown_s: f32,
    /// Strength of the touch, counts: the largest, and the last one that differed; time since, s.
    pub(super) peak: f32,
    pub(super) strength: f32,
    pub(super) still_s: f32,
    /// Strength that the touch had lately, counts, and drift of the module under it, counts.
    pub(super) recent: f32,
    pub(super) drifted: f32,
    /// True if the module may have another board than before.
    pub(super) doubt: bool,
    /// Corrections in a row in which a taxel was below its reference without a touch.
    pub(super) below: u32,
    /// Time for which the touch and readings below the reference contradicted each other, s.
    pub(super) wrong_s: f32,
}

impl Together {
    /// A module of these taxels, untouched.
    pub(super) const fn new(range: Range<usize>) -> Self {
        Self {
            range,
            rate: [0.0; 3],
            open: false,
            corrections: 0,
            pending: None,
            wary: false,
            waits: false,
            unknown_s: 0.0,
            peak: 0.0,
            strength: 0.0,
            still_s: 0.0,
            recent: 0.0,
            drifted: 0.0,
            doubt: false,
            below: 0,
            wrong_s: 0.0,
        }
    }

    /// Takes note of a correction, by so many counts after `dt` seconds.
    pub(super) fn note_drift(&mut self, counts: f32, dt: f32) {
        self.still_s += dt;
        self.drifted += counts;
        self.recent = self.strength.max(self.recent * (1.0 - dt / LATELY_S));
    }

    /// Tells whether a touch has ended though taxels are beyond their limits, by `beyond` counts each: what they show stands still
    /// and is a remainder, or the touch fell at once and drift under it can have moved them as far.
    pub(super) fn has_ended(&self, beyond: impl Fn(usize) -> f32, touched: &[bool]) -> bool {
        let fell = self.strength < ENDED * self.recent;
        let drifted = |i: usize| beyond(i) <= WIDEST * self.drifted;
        self.open
            && self.still_s > STILL_S
            && (self.strength < REMAINDER * self.peak
                || fell && (0..touched.len()).all(|i| !touched[i] || drifted(i)))
    }

    /// Tells whether a module's readings are another board's: most are far from the reference, and too many of those below it
    /// for a touch.
    pub(super) fn has_another_board(
        &self,
        reference: &Part<'_>,
        frame: &RelativeFrame,
        base: &[f32],
    ) -> bool {
        let (mut all, mut far, mut below) = (0, 0, 0);
        for (own, i) in self.range.clone().enumerate() {
            if frame.usable()[i] {
                all += 1;
                far += usize::from(frame.magnitude()[i] > base[i]);
                let down = -reference.along(2, own, frame.counts()[i]);
                below += usize::from(down > base[i]);
            }
        }
        far > 0 && 2 * far >= all && 4 * below >= far
    }
}
