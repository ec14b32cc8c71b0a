//! A felt path against the true one.

use serde::Serialize;

use crate::session::Sample;

/// Points that paths are compared at.
const POINTS: usize = 120;
/// Farthest that a drawing may lead or trail, as a part of its length.
const MOST_LAG: f64 = 0.25;
/// Lags that are tried, each way.
const LAGS: i32 = 25;

/// A place, mm.
type Place = [f64; 2];

/// Difference of a drawing from the played path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathError {
    /// Root of the mean squared distance at equal times, mm: the drawing's time is stretched to the path's, and shifted by the
    /// lag that makes it least.
    pub rmse_mm: f64,
    /// The lag of that distance, as a part of the path's length in time; positive where the drawing trails.
    pub lag: f64,
    /// Discrete Frechet distance (Eiter and Mannila 1994), mm: in order, at whatever speed.
    pub frechet_mm: f64,
    /// Breaks that the person marked.
    pub breaks: usize,
}

fn distance(a: Place, b: Place) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Place on a path at a part of its time, between its points.
fn at(path: &[(f64, Place)], part: f64) -> Place {
    let (first, last) = (path[0], path[path.len() - 1]);
    let t = first.0 + part.clamp(0.0, 1.0) * (last.0 - first.0);
    let next = path
        .partition_point(|(time, _)| *time < t)
        .clamp(1, path.len() - 1);
    let (before, after) = (path[next - 1], path[next]);
    let span = after.0 - before.0;
    let way = if span > 0.0 {
        (t - before.0) / span
    } else {
        1.0
    };
    let between = |axis: usize| before.1[axis] + way * (after.1[axis] - before.1[axis]);
    [between(0), between(1)]
}

fn resampled(path: &[(f64, Place)]) -> Vec<Place> {
    let parts = (0..POINTS).map(|n| n as f64 / (POINTS - 1) as f64);
    parts.map(|part| at(path, part)).collect()
}

/// Root of the mean squared distance where the drawing trails by `lag`, over the time that both have.
fn rmse(truth: &[(f64, Place)], drawn: &[(f64, Place)], lag: f64) -> f64 {
    let parts = (0..POINTS).map(|n| n as f64 / (POINTS - 1) as f64);
    let both = parts.filter(|part| (0.0..=1.0).contains(&(part + lag)));
    let squares: Vec<f64> = both
        .map(|part| distance(at(truth, part), at(drawn, part + lag)))
        .map(|d| d * d)
        .collect();
    libm::sqrt(squares.iter().sum::<f64>() / squares.len().max(1) as f64)
}

/// Discrete Frechet distance: the shortest leash of two that walk their points in order.
fn frechet(a: &[Place], b: &[Place]) -> f64 {
    let mut row: Vec<f64> = Vec::new();
    for (i, from) in a.iter().enumerate() {
        let mut next: Vec<f64> = Vec::with_capacity(b.len());
        for (j, to) in b.iter().enumerate() {
            let before = match (i, j) {
                (0, 0) => 0.0,
                (0, _) => next[j - 1],
                (_, 0) => row[0],
                _ => row[j].min(row[j - 1]).min(next[j - 1]),
            };
            next.push(before.max(distance(*from, *to)));
        }
        row = next;
    }
    row.last().copied().unwrap_or_default()
}

/// Compares a drawing with the played path: seconds and mm. `None` where either has fewer than two points.
#[must_use]
pub fn compare_paths(truth: &[[f64; 3]], strokes: &[Vec<Sample>]) -> Option<PathError> {
    let truth: Vec<_> = truth.iter().map(|[t, x, y]| (*t, [*x, *y])).collect();
    let drawn = strokes.iter().flatten();
    let drawn: Vec<_> = drawn.map(|s| (s.t_ms, [s.x_mm, s.y_mm])).collect();
    if truth.len() < 2 || drawn.len() < 2 {
        return None;
    }
    let lags = (-LAGS..=LAGS).map(|n| MOST_LAG * f64::from(n) / f64::from(LAGS));
    let errors = lags.map(|lag| (rmse(&truth, &drawn, lag), lag));
    // Of equal errors, the one with the shortest lag counts.
    let (rmse_mm, lag) = errors.min_by(|a, b| {
        let error = a.0.total_cmp(&b.0);
        error.then(a.1.abs().total_cmp(&b.1.abs()))
    })?;
    Some(PathError {
        rmse_mm,
        lag,
        frechet_mm: frechet(&resampled(&truth), &resampled(&drawn)),
        breaks: strokes.len() - 1,
    })
}

#[cfg(test)]
#[path = "paths_tests.rs"]
mod tests;
