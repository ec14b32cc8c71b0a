//! Run times: methods in turn, medians of many calls.

use std::hint::black_box;
use std::time::Duration;

use palpate_core::statistics::quantile;
use palpate_live::clock;

/// A sample lasts at least this long, several calls of a short method, so that the clock's own cost does not count.
const SHORT: Duration = Duration::from_millis(1);

/// One contestant: what it does, and the calls that make one sample.
struct Runner<'a> {
    work: Box<dyn FnMut() + 'a>,
    samples: Samples,
    spent: Duration,
}

/// Methods timed against each other: one sample of each, again and again, in one run.
pub struct Race<'a> {
    runners: Vec<Runner<'a>>,
    shortest: Duration,
}

impl Default for Race<'_> {
    fn default() -> Self {
        Self::of_samples(SHORT)
    }
}

impl<'a> Race<'a> {
    /// With samples that last at least `shortest`. Where the others take many milliseconds a call, a method of microseconds
    /// would alone pay in every sample for filling the caches after them.
    pub const fn of_samples(shortest: Duration) -> Self {
        Self {
            runners: Vec::new(),
            shortest,
        }
    }

    /// Enters a method; the results come back in the order of entry.
    pub fn enter<T>(&mut self, mut work: impl FnMut() -> T + 'a) {
        self.runners.push(Runner {
            work: Box::new(move || {
                black_box(work());
            }),
            samples: Samples::default(),
            spent: Duration::ZERO,
        });
    }

    /// Calls every method once to warm up, then in turn until each has `count` samples or has used
    /// `budget`; a slow one has at least one.
    pub fn run(mut self, count: usize, budget: Duration) -> Vec<Samples> {
        let mut calls = Vec::new();
        for runner in &mut self.runners {
            let once = time(1, &mut runner.work);
            calls.push((self.shortest.as_secs_f64() / once.as_secs_f64().max(1e-9)).ceil() as u32);
        }
        let mut going = true;
        while going {
            going = false;
            for (runner, calls) in self.runners.iter_mut().zip(&calls) {
                if runner.samples.len() < count && runner.spent < budget {
                    let spent = time(*calls, &mut runner.work);
                    runner.spent += spent;
                    let each = spent.as_secs_f64() * 1e6 / f64::from(*calls);
                    runner.samples.push(each);
                    going = true;
                }
            }
        }
        self.runners.into_iter().map(|r| r.samples).collect()
    }
}

fn time(calls: u32, work: &mut dyn FnMut()) -> Duration {
    let begun = clock::now();
    for _ in 0..calls {
        work();
    }
    begun.elapsed()
}

/// Many measured times of one thing, microseconds.
#[derive(Clone, Debug, Default)]
pub struct Samples(Vec<f64>);

impl Samples {
    /// One more.
    pub fn push(&mut self, us: f64) {
        self.0.push(us);
    }

    /// Number of samples.
    pub const fn len(&self) -> usize {
        self.0.len()
    }

    /// The sample below which `part` of them lies; NaN without samples.
    pub fn quantile(&self, part: f64) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        quantile(&sorted, part).map_or(f64::NAN, |at| at.below)
    }

    /// Half are not longer.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }
}
