//! Tests of `strip.rs`.

use super::*;

#[test]
fn quantum_follows_the_length() {
    assert_eq!(Grid::new(1_000_000, 10).quantum_us, 10_000);
    assert_eq!(Grid::new(10_000_000, 10).quantum_us, 20_000);
    assert_eq!(Grid::new(60_000_000, 10).quantum_us, 100_000);
    assert!(Grid::new(u64::MAX, 10).cells <= WIDTH * 64);
    assert_eq!(Grid::new(0, 10).cells, 1);
}

#[test]
fn no_burst_is_lost_and_gaps_show() {
    let grid = Grid {
        quantum_us: 20_000,
        cells: 10,
    };
    let cells: Vec<_> = grid.cells_of(0, 35_000).collect();
    assert_eq!(cells, [0, 1, 0]);
    let cells: Vec<_> = grid.cells_of(58_500, 93_500).collect();
    assert_eq!(cells, [3, 4, 3]);
    let cells: Vec<_> = grid.cells_of(41_000, 42_000).collect();
    assert_eq!(cells, [2]);
    let cells: Vec<_> = grid.cells_of(190_000, 900_000).collect();
    assert_eq!(cells.first(), Some(&9));
}
