//! The clock, samples and the table they are printed in.

use std::io::{self, Write};
use std::time::Instant;

/// The wall clock: measuring it is what this program is for.
#[allow(clippy::disallowed_methods)]
fn clock() -> Instant {
    Instant::now()
}

/// How long `f` took, microseconds; two readings of the clock are in it.
pub fn time<T>(f: impl FnOnce() -> T) -> (f64, T) {
    let started = clock();
    let value = std::hint::black_box(f());
    (started.elapsed().as_secs_f64() * 1e6, value)
}

/// Many measured times of one thing, microseconds.
#[derive(Debug, Default)]
pub struct Samples(Vec<f64>);

impl Samples {
    /// One more.
    pub fn push(&mut self, us: f64) {
        self.0.push(us);
    }

    /// How many there are.
    pub const fn len(&self) -> usize {
        self.0.len()
    }

    /// The value that `part` of the samples do not exceed; NaN without samples.
    pub fn quantile(&self, part: f64) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        let rank = (part * sorted.len() as f64).ceil().max(1.0) as usize - 1;
        sorted.get(rank).copied().unwrap_or(f64::NAN)
    }

    /// Half are not longer.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }
}

/// Calls `f` with 0, 1, 2, ...: `warm` times unmeasured, then `count` times measured one by one.
pub fn measure<T>(warm: usize, count: usize, mut f: impl FnMut(usize) -> T) -> Samples {
    let mut samples = Samples::default();
    for i in 0..warm + count {
        let (us, _) = time(|| f(i));
        if i >= warm {
            samples.push(us);
        }
    }
    samples
}

/// Prints the head of the table.
///
/// # Errors
/// A closed standard output.
pub fn head() -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(
        out,
        "| case | median, us | p99, us | target, us | samples |\n|---|---:|---:|---:|---:|"
    )
}

/// Prints one line: median and p99 beside the target of the median, if it has one.
///
/// # Errors
/// A closed standard output.
pub fn row(case: &str, samples: &Samples, target: Option<f64>) -> io::Result<()> {
    let median = samples.median();
    let verdict = match target {
        Some(most) if median <= most => format!("{most} met"),
        Some(most) => format!("{most} MISSED"),
        None => String::new(),
    };
    writeln!(
        io::stdout().lock(),
        "| {case} | {median:.2} | {:.2} | {verdict} | {} |",
        samples.quantile(0.99),
        samples.len()
    )
}

/// Prints a sentence below a table.
///
/// # Errors
/// A closed standard output.
pub fn note(text: &str) -> io::Result<()> {
    writeln!(io::stdout().lock(), "\n{text}")
}
