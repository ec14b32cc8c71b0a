//! Intensity at a centroid: interpolation of the relative frame there (4.9).

use crate::skin::{Grid, Module};
use crate::units::Point;

/// How a module's readings are interpolated.
#[derive(Clone, Copy, Debug)]
pub(super) enum Interpolation {
    /// Bilinear in the cell of the grid; beyond the outer taxels the edge value.
    Bilinear(Grid),
    /// Inverse squared distance over all taxels (Shepard 1968).
    InverseDistance,
}

impl Interpolation {
    pub(super) fn of(module: &Module) -> Self {
        module
            .as_grid()
            .map_or(Self::InverseDistance, Self::Bilinear)
    }

    /// The reading at `at`, of `norms` at `taxels`; faulty taxels take no part.
    pub(super) fn at(&self, at: Point, taxels: &[Point], norms: &[f32], faulty: &[bool]) -> f32 {
        match self {
            Self::Bilinear(grid) => bilinear(grid, at, norms, faulty)
                .unwrap_or_else(|| inverse_distance(at, taxels, norms, faulty)),
            Self::InverseDistance => inverse_distance(at, taxels, norms, faulty),
        }
    }
}

/// `None` when a corner of the cell is faulty.
fn bilinear(grid: &Grid, at: Point, norms: &[f32], faulty: &[bool]) -> Option<f32> {
    let axis = |offset: f32, n: u16| {
        let last = f32::from(n - 1);
        let position = (offset / grid.pitch + last / 2.0).clamp(0.0, last);
        // The cell's lower index, and how far into the cell; the last taxel ends the last cell.
        let cell = libm::floorf(position).min((last - 1.0).max(0.0));
        (cell as usize, position - cell)
    };
    let (column, right) = axis(at.x - grid.centre.x, grid.columns);
    let (row, down) = axis(grid.centre.y - at.y, grid.rows);
    let columns = usize::from(grid.columns);
    let next_column = (column + 1).min(columns - 1);
    let next_row = (row + 1).min(usize::from(grid.rows) - 1);
    let corner = |row: usize, column: usize| {
        let i = row * columns + column;
        if *faulty.get(i)? {
            None
        } else {
            norms.get(i).copied()
        }
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let top = mix(corner(row, column)?, corner(row, next_column)?, right);
    let bottom = mix(
        corner(next_row, column)?,
        corner(next_row, next_column)?,
        right,
    );
    Some(mix(top, bottom, down))
}

fn inverse_distance(at: Point, taxels: &[Point], norms: &[f32], faulty: &[bool]) -> f32 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for ((taxel, &norm), _) in taxels.iter().zip(norms).zip(faulty).filter(|(_, f)| !**f) {
        let d2 = taxel.distance2(at);
        if d2 < 1e-9 {
            return norm;
        }
        sum += norm / d2;
        weights += 1.0 / d2;
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_interpolated_exactly_and_edges_hold() {
        let grid = Grid {
            rows: 4,
            columns: 4,
            pitch: 4.7,
            centre: Point::new(1.0, -2.0),
        };
        let module = Module::grid(grid).unwrap();
        let plane = |p: Point| 100.0 + 3.0 * p.x - 5.0 * p.y;
        let norms: alloc::vec::Vec<f32> = module.taxels().iter().map(|&p| plane(p)).collect();
        let how = Interpolation::of(&module);
        let value = |p: Point| how.at(p, module.taxels(), &norms, &[false; 16]);
        for i in 0..50 {
            let p = Point::new(1.0 - 7.0 + 0.28 * i as f32, -2.0 + 7.0 - 0.2 * i as f32);
            assert!((value(p) - plane(p)).abs() < 1e-3, "{p:?}");
        }
        assert!((value(Point::new(99.0, 99.0)) - norms[3]).abs() < 1e-3);
        for (p, &norm) in module.taxels().iter().zip(&norms) {
            assert!((value(*p) - norm).abs() < 1e-3);
        }
    }

    #[test]
    fn a_faulty_corner_falls_back_on_its_neighbours() {
        let grid = Grid {
            rows: 4,
            columns: 4,
            pitch: 4.7,
            centre: Point::default(),
        };
        let module = Module::grid(grid).unwrap();
        let mut norms = [50.0; 16];
        norms[5] = 0.0;
        let mut faulty = [false; 16];
        faulty[5] = true;
        let value =
            Interpolation::of(&module).at(module.taxels()[5], module.taxels(), &norms, &faulty);
        assert!((value - 50.0).abs() < 1e-4);
        let none =
            Interpolation::of(&module).at(Point::default(), module.taxels(), &norms, &[true; 16]);
        assert_eq!(none, 0.0);
    }

    #[test]
    fn scattered_taxels_and_single_rows() {
        let places = [Point::new(0.0, 0.0), Point::new(2.0, 0.0)];
        let module = Module::scattered(&places).unwrap();
        let how = Interpolation::of(&module);
        let value = |x| how.at(Point::new(x, 0.0), &places, &[10.0, 20.0], &[false; 2]);
        assert_eq!((value(0.0), value(1.0), value(2.0)), (10.0, 15.0, 20.0));
        let row = Module::grid(Grid {
            rows: 1,
            columns: 2,
            pitch: 2.0,
            centre: Point::default(),
        })
        .unwrap();
        let at = Interpolation::of(&row).at(
            Point::new(0.5, 3.0),
            row.taxels(),
            &[10.0, 20.0],
            &[false; 2],
        );
        assert_eq!(at, 17.5);
        let one = Module::grid(Grid {
            rows: 1,
            columns: 1,
            pitch: 2.0,
            centre: Point::default(),
        })
        .unwrap();
        let at = Interpolation::of(&one).at(Point::new(0.5, 3.0), one.taxels(), &[10.0], &[false]);
        assert_eq!(at, 10.0);
    }
}
