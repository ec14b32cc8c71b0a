//! Alignment of two sequences of bursts by time: it pairs each burst of one run with the same burst of another.

use crate::bursts::Burst;

/// Cells of the table beyond which sequences are paired from the left in one pass.
const CELLS: usize = 1 << 22;

/// Two sequences side by side, as indices into each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Alignment {
    /// Bursts that are in both.
    pub pairs: Vec<(usize, usize)>,
    /// Bursts only in the first.
    pub gone: Vec<usize>,
    /// Bursts only in the second.
    pub new: Vec<usize>,
}

/// Distance of two bursts: the moves of both edges, microseconds; a tick of width counts as one.
fn distance(a: &Burst, b: &Burst) -> u64 {
    let edges = a.from_us.abs_diff(b.from_us);
    let edges = edges.saturating_add(a.to_us.abs_diff(b.to_us));
    edges.saturating_add(u64::from(a.width.abs_diff(b.width)))
}

/// Aligns two sequences sorted by their starts so that what they differ by is least: the distances of the
/// pairs, and `gap_us` for every burst that has none. A burst that moved by less than `gap_us` stays a pair
/// (Needleman and Wunsch 1970, doi:10.1016/0022-2836(70)90057-4).
pub fn align(a: &[Burst], b: &[Burst], gap_us: u64) -> Alignment {
    let same = |(x, y): &(&Burst, &Burst)| x == y;
    let front = a.iter().zip(b).take_while(same).count();
    let (rest_a, rest_b) = (&a[front..], &b[front..]);
    let back = rest_a.iter().rev().zip(rest_b.iter().rev());
    let back = back.take_while(same).count();
    let middle_a = &rest_a[..rest_a.len() - back];
    let middle_b = &rest_b[..rest_b.len() - back];

    let mut found = Alignment {
        pairs: (0..front).map(|i| (i, i)).collect(),
        ..Alignment::default()
    };
    let part = if (middle_a.len() + 1).saturating_mul(middle_b.len() + 1) <= CELLS {
        table(middle_a, middle_b, gap_us.max(1))
    } else {
        sweep(middle_a, middle_b, gap_us.max(1))
    };
    let shifted = part.pairs.iter().map(|(i, j)| (i + front, j + front));
    found.pairs.extend(shifted);
    found.gone.extend(part.gone.iter().map(|i| i + front));
    found.new.extend(part.new.iter().map(|j| j + front));
    let tail = (0..back).rev();
    found
        .pairs
        .extend(tail.map(|k| (a.len() - 1 - k, b.len() - 1 - k)));
    found
}

#[derive(Clone, Copy)]
enum Step {
    Pair,
    Gone,
    New,
}

/// Exact alignment, by a table of all pairs.
fn table(a: &[Burst], b: &[Burst], gap: u64) -> Alignment {
    let width = b.len() + 1;
    let mut steps = vec![Step::New; (a.len() + 1) * width];
    // Costs of the row above and of this one.
    let mut above: Vec<u64> = (0..width as u64).map(|j| j.saturating_mul(gap)).collect();
    let mut row = above.clone();
    for (i, x) in a.iter().enumerate() {
        row[0] = above[0].saturating_add(gap);
        steps[(i + 1) * width] = Step::Gone;
        for (j, y) in b.iter().enumerate() {
            let pair = above[j].saturating_add(distance(x, y));
            let gone = above[j + 1].saturating_add(gap);
            let new = row[j].saturating_add(gap);
            let (cost, step) = if pair < gone.min(new) {
                (pair, Step::Pair)
            } else if gone <= new {
                (gone, Step::Gone)
            } else {
                (new, Step::New)
            };
            row[j + 1] = cost;
            steps[(i + 1) * width + j + 1] = step;
        }
        std::mem::swap(&mut above, &mut row);
    }
    let mut found = Alignment::default();
    let (mut i, mut j) = (a.len(), b.len());
    while i > 0 || j > 0 {
        match steps[i * width + j] {
            Step::Pair => {
                (i, j) = (i - 1, j - 1);
                found.pairs.push((i, j));
            }
            Step::Gone => {
                i -= 1;
                found.gone.push(i);
            }
            Step::New => {
                j -= 1;
                found.new.push(j);
            }
        }
    }
    found.pairs.reverse();
    found.gone.reverse();
    found.new.reverse();
    found
}

/// Alignment of long sequences, from left to right: bursts that are near are a pair, else the earlier one stands alone.
fn sweep(a: &[Burst], b: &[Burst], gap: u64) -> Alignment {
    let mut found = Alignment::default();
    let (mut i, mut j) = (0, 0);
    while let (Some(x), Some(y)) = (a.get(i), b.get(j)) {
        if distance(x, y) < gap.saturating_mul(2) {
            found.pairs.push((i, j));
            (i, j) = (i + 1, j + 1);
        } else if x.from_us <= y.from_us {
            found.gone.push(i);
            i += 1;
        } else {
            found.new.push(j);
            j += 1;
        }
    }
    found.gone.extend(i..a.len());
    found.new.extend(j..b.len());
    found
}

#[cfg(test)]
#[path = "align_tests.rs"]
mod tests;
