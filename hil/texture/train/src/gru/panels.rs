//! A small matrix that many products share, kept in panels of sixteen columns: a step's product with a dozen rows
//! spends its time on sums. General products pack their matrices again at every step.

use palpate_core::vector::Vectors;

/// Columns of a panel: two AVX2 registers.
const WIDE: usize = 16;
/// Rows summed at once: as many accumulators as stay in registers.
const ROWS: usize = 4;

/// A matrix [depth, columns] in panels; the last one is filled up with zeros.
#[derive(Clone, Debug)]
pub struct Panels {
    values: Vec<[f32; WIDE]>,
    depth: usize,
    columns: usize,
}

impl Panels {
    /// Panels of a row-major matrix [depth, columns].
    pub fn new(matrix: &[f32], columns: usize) -> Self {
        Self::filled(matrix.len() / columns, columns, |k, c| {
            matrix[k * columns + c]
        })
    }

    /// Panels of the transpose of a row-major matrix [columns, depth].
    pub fn transposed(matrix: &[f32], depth: usize) -> Self {
        Self::filled(depth, matrix.len() / depth, |k, c| matrix[c * depth + k])
    }

    fn filled(depth: usize, columns: usize, at: impl Fn(usize, usize) -> f32) -> Self {
        let mut values = Vec::with_capacity(columns.div_ceil(WIDE) * depth);
        for first in (0..columns).step_by(WIDE) {
            values.extend((0..depth).map(|k| {
                core::array::from_fn(|c| {
                    if first + c < columns {
                        at(k, first + c)
                    } else {
                        0.0
                    }
                })
            }));
        }
        Self {
            values,
            depth,
            columns,
        }
    }

    /// Adds `left` [rows, depth] times the matrix to `out` [rows, columns].
    pub fn add(&self, left: &[f32], out: &mut [f32], vectors: Vectors) {
        vectors.run(
            #[inline(always)]
            || self.add_all(left, out),
        );
    }

    #[inline(always)]
    fn add_all(&self, left: &[f32], out: &mut [f32]) {
        let whole = left.len() / self.depth / ROWS * ROWS;
        let (fours, ones) = left.split_at(whole * self.depth);
        let (to_fours, to_ones) = out.split_at_mut(whole * self.columns);
        let panels = self.values.chunks_exact(self.depth);
        for (panel, first) in panels.zip((0..self.columns).step_by(WIDE)) {
            let width = WIDE.min(self.columns - first);
            let rows = fours.chunks_exact(ROWS * self.depth);
            for (rows, to) in rows.zip(to_fours.chunks_exact_mut(ROWS * self.columns)) {
                let row = |r: usize| &rows[r * self.depth..][..self.depth];
                let sums = sums_of_rows([row(0), row(1), row(2), row(3)], panel);
                for (row, sums) in to.chunks_exact_mut(self.columns).zip(&sums) {
                    let row = &mut row[first..first + width];
                    row.iter_mut().zip(sums).for_each(|(to, sum)| *to += sum);
                }
            }
        }
        // The remaining rows go one by one, through as many panels at once.
        let rows = ones.chunks_exact(self.depth);
        for (row, to) in rows.zip(to_ones.chunks_exact_mut(self.columns)) {
            let panels = self.values.chunks(ROWS * self.depth);
            for (panels, to) in panels.zip(to.chunks_mut(ROWS * WIDE)) {
                let last = panels.len() / self.depth - 1;
                let panel = |p: usize| &panels[p.min(last) * self.depth..][..self.depth];
                let sums = sums_of_row(row, [panel(0), panel(1), panel(2), panel(3)]);
                let sums = sums.as_flattened();
                to.iter_mut().zip(sums).for_each(|(to, sum)| *to += sum);
            }
        }
    }
}

#[inline(always)]
fn sums_of_rows(rows: [&[f32]; ROWS], panel: &[[f32; WIDE]]) -> [[f32; WIDE]; ROWS] {
    let mut sums = [[0.0f32; WIDE]; ROWS];
    let [a, b, c, d] = rows;
    for ((((w, a), b), c), d) in panel.iter().zip(a).zip(b).zip(c).zip(d) {
        for i in 0..WIDE {
            sums[0][i] += a * w[i];
            sums[1][i] += b * w[i];
            sums[2][i] += c * w[i];
            sums[3][i] += d * w[i];
        }
    }
    sums
}

#[inline(always)]
fn sums_of_row(row: &[f32], panels: [&[[f32; WIDE]]; ROWS]) -> [[f32; WIDE]; ROWS] {
    let mut sums = [[0.0f32; WIDE]; ROWS];
    let [a, b, c, d] = panels;
    for ((((x, a), b), c), d) in row.iter().zip(a).zip(b).zip(c).zip(d) {
        for i in 0..WIDE {
            sums[0][i] += x * a[i];
            sums[1][i] += x * b[i];
            sums[2][i] += x * c[i];
            sums[3][i] += x * d[i];
        }
    }
    sums
}

#[cfg(test)]
#[path = "panels_tests.rs"]
mod tests;
