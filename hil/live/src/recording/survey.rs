//! Figures of a whole recording, which tell people how it was understood.

use std::path::Path;

use palpate_files::{Input, REFERENCE_ROWS, RecipePlan, Rows, SensorLayout, Take, Timing};
use palpate_run::Failure;

/// Rows from which the rest of the skin is told, at most: those that `hil contacts` takes for its reference.
const FIRST: usize = REFERENCE_ROWS as usize;
/// Frames that are kept for a strip, at least; twice as many at most.
const KEPT: usize = 16;
/// A change that is more than noise, counts at least.
const LEAST: f64 = 8.0;
/// A change that is more than noise, in deviations of the first rows.
const SIGMAS: f64 = 6.0;

/// Figures of a whole recording.
#[derive(Debug)]
pub struct Survey {
    /// Remarks on the file.
    pub notes: Vec<String>,
    /// Number of rows.
    pub rows: usize,
    /// Time from the first row to the last, microseconds.
    pub span_us: u64,
    /// Rows at the beginning in which nothing changes.
    pub at_rest: usize,
    /// Smallest reading, counts.
    pub least: u16,
    /// Largest reading, counts.
    pub most: u16,
    /// Largest change of each taxel, in counts.
    pub largest: Vec<f64>,
    /// Some frames, evenly spread: time in microseconds and the change of each taxel.
    pub frames: Vec<(u64, Vec<f64>)>,
}

/// Mean and deviation of each reading over the first rows.
struct Rest {
    mean: Vec<f64>,
    threshold: f64,
}

impl Survey {
    /// Reads a recording twice: its beginning for the rest, and all of it.
    ///
    /// # Errors
    /// [`Failure::Input`] for a file that the recipe cannot read.
    pub fn read(
        path: &Path,
        plan: &RecipePlan,
        timing: &Timing,
        sensor: &SensorLayout,
    ) -> Result<Self, Failure> {
        let axes = usize::from(sensor.axes);
        let open = || Rows::open(path, Take::Recipe(plan), Some(timing));
        let rest = Rest::read(&mut open()?, axes)?;
        let mut survey = Self {
            notes: Vec::new(),
            rows: 0,
            span_us: 0,
            at_rest: 0,
            least: u16::MAX,
            most: 0,
            largest: vec![0.0; sensor.readings()],
            frames: Vec::new(),
        };
        let (mut rows, mut row): (_, Vec<u16>) = (open()?, Vec::new());
        let (mut every, mut first, mut is_at_rest) = (1, None, true);
        while let Some(at) = rows.advance(&mut row)? {
            let change = rest.change(&row, axes);
            survey.least = row.iter().copied().fold(survey.least, u16::min);
            survey.most = row.iter().copied().fold(survey.most, u16::max);
            is_at_rest &= change.iter().all(|c| *c <= rest.threshold);
            survey.at_rest += usize::from(is_at_rest);
            for (largest, change) in survey.largest.iter_mut().zip(&change) {
                *largest = largest.max(*change);
            }
            let begin = *first.get_or_insert(at.time_us);
            survey.span_us = at.time_us - begin;
            if survey.rows.is_multiple_of(every) {
                survey.frames.push((survey.span_us, change));
                if survey.frames.len() > 2 * KEPT {
                    let mut odd = true;
                    survey.frames.retain(|_| {
                        odd = !odd;
                        !odd
                    });
                    every *= 2;
                }
            }
            survey.rows += 1;
        }
        survey.notes = rows.notes();
        Ok(survey)
    }
}

impl Rest {
    fn read(rows: &mut Rows<Input>, axes: usize) -> Result<Self, Failure> {
        let (mut first, mut row): (Vec<Vec<u16>>, Vec<u16>) = (Vec::new(), Vec::new());
        while first.len() < FIRST && rows.advance(&mut row)?.is_some() {
            first.push(row.clone());
        }
        let columns = first.first().map_or(0, Vec::len);
        // The median of the first rows bears a touch in fewer than half of them.
        let mean = (0..columns)
            .map(|c| {
                let mut values: Vec<u16> = first.iter().map(|row| row[c]).collect();
                values.sort_unstable();
                f64::from(values[values.len() / 2])
            })
            .collect();
        let mut rest = Self {
            mean,
            threshold: 0.0,
        };
        let mut changes: Vec<f64> = first
            .iter()
            .flat_map(|row| rest.change(row, axes))
            .collect();
        changes.sort_unstable_by(f64::total_cmp);
        let usual = changes.get(changes.len() / 2).copied().unwrap_or(0.0);
        rest.threshold = (usual * SIGMAS).max(LEAST);
        Ok(rest)
    }

    /// Distance of each taxel from rest, counts.
    fn change(&self, row: &[u16], axes: usize) -> Vec<f64> {
        let of = |(values, mean): (&[u16], &[f64])| {
            let squares = values
                .iter()
                .zip(mean)
                .map(|(v, m)| (f64::from(*v) - m).powi(2));
            squares.sum::<f64>().sqrt()
        };
        row.chunks(axes)
            .zip(self.mean.chunks(axes))
            .map(of)
            .collect()
    }
}
