//! Whether the times of frames on buses can be: one rule for logs and MCAP; [`super::Times`] has that of rows.
//!
//! Clocks are coarse and adapters hand frames on in bursts, so what is refused is far beyond either.

use palpate_core::statistics::quantile;

/// Bits per second of a bus whose layout states none.
pub const USUAL_BITRATE: u32 = 1_000_000;
/// Bits around the data of a classic frame with a short identifier, before any is stuffed.
const AROUND: u32 = 47;
/// Time for which frames may come faster than the bus carries them: bursts of an adapter, s.
const BURST_S: f64 = 0.05;
/// Most rows of one instant: clocks of milliseconds have a few.
pub(super) const SAME: u32 = 10;
/// Between two readings of a taxel, microseconds: a skin that is this slow is none.
const SLOWEST_US: u64 = 2_000_000;
/// Steps that the usual distance is taken of.
const STEPS: usize = 256;

/// Follows the times of what a recording has one after another.
#[derive(Clone, Debug)]
pub struct Pace {
    /// Bits per second that each bus carries.
    bitrate: u32,
    newest_us: Option<u64>,
    oldest_us: u64,
    count: u64,
    /// Bits that each bus has yet to carry.
    waiting: Vec<(f64, u64)>,
    /// The first identifier of each bus that was seen, and when last.
    first: Option<(u8, u16, u64)>,
    steps: Vec<u64>,
}

impl Pace {
    /// A recording of buses that carry `bitrate` bits per second, before its first frame.
    #[must_use]
    pub const fn new(bitrate: u32) -> Self {
        Self {
            bitrate,
            newest_us: None,
            oldest_us: 0,
            count: 0,
            waiting: Vec::new(),
            first: None,
            steps: Vec::new(),
        }
    }

    /// Takes a frame of a bus.
    ///
    /// # Errors
    /// What is wrong with its time, as messages have it after `found`.
    pub fn frame(&mut self, (bus, id, length): (u8, u16, usize), us: u64) -> Result<(), String> {
        self.newer(us);
        if let Some((first_bus, first_id, before)) = &mut self.first {
            if (*first_bus, *first_id) == (bus, id) {
                if self.steps.len() < STEPS {
                    self.steps.push(us.saturating_sub(*before));
                }
                *before = us;
            }
        } else {
            self.first = Some((bus, id, us));
        }
        let bus = usize::from(bus);
        if self.waiting.len() <= bus {
            self.waiting.resize(bus + 1, (0.0, us));
        }
        let (bits, before) = &mut self.waiting[bus];
        let carried = us.saturating_sub(*before) as f64 * 1e-6 * f64::from(self.bitrate);
        let own = AROUND + 8 * u32::try_from(length).unwrap_or(8);
        *bits = (*bits - carried).max(0.0) + f64::from(own);
        *before = us.max(*before);
        if *bits <= f64::from(self.bitrate) * BURST_S {
            return Ok(());
        }
        let span = self.newest_us.unwrap_or(us) - self.oldest_us;
        Err(match span {
            0 => format!("{} frames of one instant, {us} us", self.count),
            span => format!(
                "{} frames in {:.6} s, which a bus of {} kbit/s (`bitrate` of the layout, or 1000) does not carry: times are differences, or of another unit",
                self.count,
                span as f64 * 1e-6,
                self.bitrate / 1000
            ),
        })
    }

    fn newer(&mut self, us: u64) {
        self.oldest_us = match self.newest_us {
            Some(_) => self.oldest_us.min(us),
            None => us,
        };
        self.newest_us = self.newest_us.max(Some(us));
        self.count += 1;
    }

    /// Says at the end of a recording of buses what is wrong with all of it: times that stand still, or that are too slow
    /// for any skin.
    ///
    /// # Errors
    /// As [`Pace::frame`].
    pub fn end(&self) -> Result<(), String> {
        let span = self.newest_us.unwrap_or(0) - self.oldest_us;
        if self.count > u64::from(SAME) && span == 0 {
            let us = self.oldest_us;
            return Err(format!("{} frames of one instant, {us} us", self.count));
        }
        let mut steps = self.steps.clone();
        steps.sort_unstable();
        let usual = quantile(&steps, 0.5).map_or(0, |middle| middle.above);
        if steps.len() > 2 && usual > SLOWEST_US {
            return Err(format!(
                "each taxel every {:.1} s: times are of another unit, perhaps a thousandfold",
                usual as f64 * 1e-6
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "pace_tests.rs"]
mod tests;
