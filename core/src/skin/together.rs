//! State of a module as a whole: its common drift, its touch, and doubts about its board and its reference.

use core::ops::Range;

use super::reference::Part;
use super::relative::RelativeFrame;

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
            doubt: false,
            below: 0,
            wrong_s: 0.0,
        }
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
