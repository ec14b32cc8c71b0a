//! Taxels of a module as letters on a terminal.

/// Letters from no change to the largest.
const LETTERS: &[u8] = b".:-=+*#%@";
/// Largest picture, letters across and down.
const MOST: [usize; 2] = [36, 18];
/// Width of a terminal, less an indent.
const WIDTH: usize = 78;

/// The cells of a module's taxels.
pub(super) struct Picture {
    columns: usize,
    rows: usize,
    cells: Vec<usize>,
}

impl Picture {
    /// Cells for places in millimetres, x right and y up: one per distinct coordinate, as far as there is room.
    pub(super) fn new(points: &[[f64; 2]]) -> Self {
        let along = |axis: usize, sign: f64| {
            let um = |p: &[f64; 2]| (p[axis] * sign * 1e3).round() as i64;
            let mut distinct: Vec<i64> = points.iter().map(um).collect();
            distinct.sort_unstable();
            distinct.dedup();
            let count = distinct.len().clamp(1, MOST[axis]);
            let (least, most) = (distinct.first().copied(), distinct.last().copied());
            let span = (most.unwrap_or(0) - least.unwrap_or(0)).max(1);
            let is_each = distinct.len() == count;
            let cell = move |p: &[f64; 2]| match is_each {
                true => distinct.binary_search(&um(p)).unwrap_or(0),
                false => ((um(p) - least.unwrap_or(0)) * (count as i64 - 1) / span) as usize,
            };
            (count, points.iter().map(cell).collect::<Vec<usize>>())
        };
        let (columns, x) = along(0, 1.0);
        let (rows, y) = along(1, -1.0);
        Self {
            columns,
            rows,
            cells: x.iter().zip(&y).map(|(x, y)| y * columns + x).collect(),
        }
    }

    /// The picture line by line; where taxels share a cell, the largest value counts.
    pub(super) fn lines(&self, values: &[f64], most: f64) -> Vec<String> {
        let mut cells = vec![b' '; self.columns * self.rows];
        for (cell, value) in self.cells.iter().zip(values) {
            let share = if most > 0.0 { value / most } else { 0.0 };
            let level = ((share * LETTERS.len() as f64) as usize).min(LETTERS.len() - 1);
            let known = LETTERS.iter().position(|letter| *letter == cells[*cell]);
            cells[*cell] = LETTERS[known.map_or(level, |known| known.max(level))];
        }
        let line = |row: &[u8]| {
            let letters: Vec<String> = row.iter().map(|l| char::from(*l).to_string()).collect();
            letters.join(" ")
        };
        cells.chunks(self.columns).map(line).collect()
    }
}

/// Frames beside one another, evenly many of them as there is room, each under its time.
pub(super) fn strip(picture: &Picture, frames: &[(u64, &[f64])], most: f64) -> Vec<String> {
    let wide = (2 * picture.columns - 1).max(7) + 2;
    let room = (WIDTH / wide).max(1).min(frames.len());
    let chosen: Vec<usize> = (0..room).map(|n| n * frames.len() / room.max(1)).collect();
    let mut lines = vec![String::new(); picture.rows + 1];
    for frame in chosen {
        let (us, values) = frames[frame];
        let time = format!("{:.2}", us as f64 * 1e-6);
        lines[0] += &format!("{time:<wide$}");
        for (line, text) in lines[1..].iter_mut().zip(picture.lines(values, most)) {
            *line += &format!("{text:<wide$}");
        }
    }
    lines
        .into_iter()
        .map(|line| line.trim_end().to_owned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_module_is_shown_with_its_top_left_first() {
        let points = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
        let picture = Picture::new(&points);
        assert_eq!(picture.lines(&[0.0, 9.0, 5.0, 0.0], 9.0), [". @", "* ."]);
        assert_eq!(picture.lines(&[0.0; 4], 0.0), [". .", ". ."]);
        let frames: Vec<(u64, &[f64])> = vec![(0, &[0.0; 4]), (250_000, &[9.0; 4])];
        let expected = ["0.00     0.25", ". .      @ @", ". .      @ @"];
        assert_eq!(strip(&picture, &frames, 9.0), expected);
    }

    #[test]
    fn a_strip_keeps_to_the_terminal() {
        let points: Vec<[f64; 2]> = (0..2000)
            .map(|n| [f64::from(n % 100), f64::from(n / 100)])
            .collect();
        let picture = Picture::new(&points);
        let values = vec![1.0; 2000];
        let frames: Vec<(u64, &[f64])> = (0..40).map(|n| (n * 1000, values.as_slice())).collect();
        let lines = strip(&picture, &frames, 1.0);
        assert!(
            lines.len() == 19 && lines.iter().all(|line| line.len() <= 78),
            "{lines:#?}"
        );
    }
}
