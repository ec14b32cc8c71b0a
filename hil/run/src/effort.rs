//! Work of a run and work that it left out, in counts and in time.

use core::time::Duration;

use palpate_core::contact::Work;
use palpate_core::driver::Traffic;
use palpate_core::projector::Projector;
use palpate_core::statistics::quantile;

use crate::recorder::Recorder;

/// Work that a frame gave the compression, the cheapest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameKind {
    /// Every taxel is as in the frame before: nothing to do.
    Repeated,
    /// No taxel is in contact.
    Untouched,
    /// Contacts passed through, or one weighted mean a module.
    Direct,
    /// K-means.
    Solved,
}

impl FrameKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Repeated, Self::Untouched, Self::Direct, Self::Solved];

    /// Kind of the frames between two counts.
    fn between(before: &Work, after: &Work) -> Self {
        if after.solves > before.solves {
            Self::Solved
        } else if after.passed + after.means > before.passed + before.means {
            Self::Direct
        } else if after.frames > before.frames && after.repeated == before.repeated {
            Self::Untouched
        } else {
            Self::Repeated
        }
    }
}

/// Reads a clock that counts from some moment: a session has none of its own.
pub type Stopwatch = fn() -> Duration;

/// Computing time of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameCost {
    /// Kind of the frame's work.
    pub kind: FrameKind,
    /// Computing time, microseconds: everything from the bus to the contacts and the work that was due then.
    pub us: f32,
}

/// Computing time of frames.
#[derive(Debug)]
pub struct FrameTimes {
    stopwatch: Option<Stopwatch>,
    /// Computing time since the last complete frame.
    spent: Duration,
    /// Compression work at the last complete frame.
    work: Work,
    costs: Vec<FrameCost>,
    /// `true` to thin the costs of a long run: beyond a bound, every second, fourth and so on is kept.
    pub thin: bool,
    /// Frames from one whose cost is kept to the next, and frames since the last kept one.
    every: u64,
    passed: u64,
}

/// Costs at which a run that thins drops every second one.
const TELLING: usize = 1 << 16;

impl FrameTimes {
    /// Times by a stopwatch, or not at all.
    pub fn new(stopwatch: Option<Stopwatch>) -> Self {
        Self {
            stopwatch,
            spent: Duration::ZERO,
            work: Work::default(),
            costs: Vec::new(),
            thin: false,
            every: 1,
            passed: 0,
        }
    }

    /// Reads the stopwatch before a call of the loop.
    pub fn begin(&self) -> Duration {
        self.stopwatch.map_or(Duration::ZERO, |read| read())
    }

    /// Adds a call of the loop that began at `begun` and completed so many frames: they share the time since the last
    /// one.
    pub fn add(&mut self, begun: Duration, frames: u32, work: &Work) {
        let Some(read) = self.stopwatch else {
            return;
        };
        self.spent += read().saturating_sub(begun);
        if frames > 0 {
            let us = self.spent.as_secs_f32() * 1e6 / frames as f32;
            let kind = FrameKind::between(&self.work, work);
            let cost = FrameCost { kind, us };
            for _ in 0..frames {
                self.passed += 1;
                if self.passed >= self.every {
                    self.passed = 0;
                    self.costs.push(cost);
                }
            }
            if self.thin && self.costs.len() >= TELLING {
                let mut odd = false;
                self.costs.retain(|_| {
                    odd = !odd;
                    odd
                });
                self.every *= 2;
            }
            (self.work, self.spent) = (*work, Duration::ZERO);
        }
    }

    /// The frames since the last time.
    pub fn take(&mut self) -> Vec<FrameCost> {
        std::mem::take(&mut self.costs)
    }
}

/// The work of a run.
#[derive(Clone, Debug, Default)]
pub struct Effort {
    /// Work of the compression.
    pub compression: Work,
    /// Traffic of the display's driver.
    pub traffic: Traffic,
    /// Onsets, and how many of them had no contact to project.
    pub onsets: u64,
    /// Onsets without a contact.
    pub silent_onsets: u64,
    /// Stimuli with a pulse.
    pub driven: u64,
    /// Wires of the display.
    pub wires: usize,
    /// Wires of which no stimulus was ever asked.
    pub cold_wires: usize,
    /// `true` where a first pass looked for intensity levels.
    pub calibrated: bool,
    /// Time of frames by kind, microseconds each, everything from the bus to the contacts and the work that was due
    /// then.
    times: [Vec<f32>; 4],
}

impl Effort {
    /// Takes in the loop's totals.
    pub fn finish(&mut self, projector: &Projector, recorder: &Recorder) {
        self.compression = projector.work();
        self.wires = projector.display().wires().len();
        self.driven = recorder.driven.stimuli;
        (self.onsets, self.silent_onsets) = recorder.onsets;
        self.cold_wires = self.wires.saturating_sub(recorder.warmed.len());
    }

    /// Sums the effort of several loops.
    pub(crate) fn sum<'a>(parts: impl Iterator<Item = &'a Self>) -> Self {
        let mut sum = Self::default();
        for part in parts {
            sum.compression.add(&part.compression);
            sum.traffic.add(&part.traffic);
            sum.onsets += part.onsets;
            sum.silent_onsets += part.silent_onsets;
            sum.driven += part.driven;
            sum.wires += part.wires;
            sum.cold_wires += part.cold_wires;
            sum.calibrated |= part.calibrated;
            for (all, own) in sum.times.iter_mut().zip(&part.times) {
                all.extend(own);
            }
        }
        sum
    }

    /// Effort of a run from its frames' costs and its driver's traffic.
    pub fn new(costs: &[FrameCost], traffic: Traffic) -> Self {
        let mut effort = Self {
            traffic,
            ..Self::default()
        };
        for cost in costs {
            effort.times[cost.kind as usize].push(cost.us);
        }
        effort
    }

    /// Frames of a kind, their median time and their time together, microseconds; NaN for the median of none.
    pub fn frames(&self, kind: FrameKind) -> (usize, f64, f64) {
        let mut sorted = self.times[kind as usize].clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let median = quantile(&sorted, 0.5).map_or(f64::NAN, |middle| f64::from(middle.above));
        let sum = sorted.iter().map(|t| f64::from(*t)).sum();
        (sorted.len(), median, sum)
    }
}
