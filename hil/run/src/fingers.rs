//! Fingers that a person moves while a session runs: a log that the emulated skin reads, and that can be saved.
//!
//! A sample holds from its own time on, so a session that reads the log as it grows and a run of the saved scene see
//! the same touches at every instant. A full log has 8.6 MB: [`MOST_SAMPLES`] of 40 bytes.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use palpate_files::{HandSample, MOST_SAMPLES, Touch, check_sample};

use crate::failure::Failure;

/// Fingers on a skin. Clones are the same fingers.
#[derive(Clone, Debug, Default)]
pub struct Fingers(Arc<Mutex<Log>>);

#[derive(Debug, Default)]
struct Log {
    touches: Vec<Finger>,
    samples: usize,
}

/// Path of a finger on one module.
#[derive(Debug)]
struct Finger {
    number: usize,
    touch: Touch,
}

impl Fingers {
    /// Finger `finger` is like this on a module from the sample's time on; a force of zero lifts it. It leaves any
    /// other module that it was on.
    ///
    /// # Errors
    /// [`Failure::Input`] for numbers that no finger has, a time before the newest, and a full log.
    pub fn add(&self, finger: usize, module: usize, sample: HandSample) -> Result<(), Failure> {
        let name = format!("finger {finger}");
        let input = |text: String| Err(Failure::Input(format!("{name}: {text}")));
        if let Err((column, expected)) = check_sample(&sample) {
            return input(format!("expected {expected}, found {}", sample[column]));
        }
        let log = &mut *self.log();
        if log.samples >= MOST_SAMPLES {
            return input(format!(
                "expected at most {MOST_SAMPLES} samples per session; begin a new one"
            ));
        }
        let own = log.touches.iter().filter(|own| own.number == finger);
        let newest = own.filter_map(|own| Some(own.touch.path.samples.last()?[0]));
        if let Some(before) = newest.max().filter(|before| sample[0] < *before) {
            return input(format!(
                "expected a time from {before} us on, found {} us",
                sample[0]
            ));
        }
        let Log { touches, samples } = log;
        let mut known = false;
        for own in touches.iter_mut().filter(|own| own.number == finger) {
            if own.touch.module == module {
                known = true;
                *samples += own.put(sample);
                continue;
            }
            let last = own.touch.path.samples.last().copied();
            if let Some([_, x, y, _, d]) = last.filter(|last| last[3] > 0) {
                *samples += own.put([sample[0], x, y, 0, d]);
            }
        }
        if !known {
            *samples += 1;
            touches.push(Finger {
                number: finger,
                touch: Touch::by_hand(module, sample),
            });
        }
        Ok(())
    }

    /// Touches until `now_us`, for a scene of `length_s` seconds, which is no shorter. Fingers that press at `now_us`
    /// are lifted.
    #[must_use]
    pub fn touches(&self, now_us: i64, length_s: f64) -> Vec<Touch> {
        let log = self.log();
        let mut touches: Vec<Touch> = log.touches.iter().map(|own| own.touch.clone()).collect();
        for touch in &mut touches {
            touch.end_s = length_s;
            let samples = &mut touch.path.samples;
            samples.retain(|sample| sample[0] < now_us);
            let last = samples.last().copied().filter(|s| s[3] > 0);
            samples.extend(last.map(|[_, x, y, _, d]| [now_us, x, y, 0, d]));
        }
        touches.retain(|touch| !touch.path.samples.is_empty());
        touches
    }

    /// Calls `work` with every touch, in the order in which they began.
    pub(crate) fn each(&self, mut work: impl FnMut(&Touch)) {
        let log = self.log();
        log.touches.iter().for_each(|finger| work(&finger.touch));
    }

    fn log(&self) -> MutexGuard<'_, Log> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Finger {
    /// Adds a sample, or replaces one of the same time. Returns the number of samples that are new.
    fn put(&mut self, sample: HandSample) -> usize {
        let samples = &mut self.touch.path.samples;
        match samples.last_mut() {
            Some(last) if last[0] == sample[0] => {
                *last = sample;
                0
            }
            Some(last) if last[1..] == sample[1..] => 0,
            _ => {
                samples.push(sample);
                1
            }
        }
    }
}
