//! What a run did and what it could leave out, in counts and in time.

use palpate_core::contact::Work;
use palpate_core::driver::Traffic;

/// What a frame asked of the compression, the cheapest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Every taxel as in the frame before: nothing to do.
    Repeated,
    /// No taxel in contact.
    Untouched,
    /// Contacts passed through, or one weighted mean a module.
    Direct,
    /// K-means.
    Solved,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Repeated, Self::Untouched, Self::Direct, Self::Solved];

    /// What frames between two counts asked for.
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

/// Computing time of a run's frames.
#[derive(Debug, Default)]
pub(super) struct FrameTimes {
    /// Since the last frame that was complete.
    spent: std::time::Duration,
    /// Of each frame, microseconds.
    pub us: Vec<f32>,
}

impl FrameTimes {
    /// A call of the loop that began then and completed so many frames: they share the time since the last one.
    pub fn add(
        &mut self,
        begun: std::time::Instant,
        frames: u32,
        work: &Work,
        effort: &mut Effort,
    ) {
        self.spent += begun.elapsed();
        if frames > 0 {
            let each = self.spent.as_secs_f32() * 1e6 / frames as f32;
            self.us.extend(std::iter::repeat_n(each, frames as usize));
            effort.note(work, frames, each);
            self.spent = std::time::Duration::ZERO;
        }
    }
}

/// The work of a run.
#[derive(Clone, Debug, Default)]
pub struct Effort {
    /// Of the compression.
    pub compression: Work,
    /// Of the display's driver.
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
    /// Whether a first pass looked for intensity levels.
    pub calibrated: bool,
    /// Time of frames by kind, microseconds each, everything from the bus to the contacts and what was due then.
    times: [Vec<f32>; 4],
}

impl Effort {
    /// Notes the time of `frames` frames since the work stood at the last call's.
    fn note(&mut self, work: &Work, frames: u32, each_us: f32) {
        let kind = Kind::between(&self.compression, work);
        self.times[kind as usize].extend(std::iter::repeat_n(each_us, frames as usize));
        self.compression = *work;
    }

    /// Frames of a kind, their median time and their time together, microseconds; NaN for the median of none.
    pub fn frames(&self, kind: Kind) -> (usize, f64, f64) {
        let mut sorted = self.times[kind as usize].clone();
        sorted.sort_by(f32::total_cmp);
        let median = sorted
            .get(sorted.len() / 2)
            .map_or(f64::NAN, |t| f64::from(*t));
        let sum = sorted.iter().map(|t| f64::from(*t)).sum();
        (sorted.len(), median, sum)
    }
}
