//! Texts on a grid.

use super::*;

fn row(grid: &Grid) -> String {
    grid.cells.iter().filter_map(|cell| cell.symbol).collect()
}

#[test]
fn a_text_ends_at_the_edge_and_loses_its_controls() {
    let mut grid = Grid::new((5, 1));
    grid.put(2, 0, "\x1b[1ab", Style::default());
    assert_eq!(row(&grid), "  [1a");
    grid.put(5, 0, "beyond", Style::default());
    grid.put(0, 1, "below", Style::default());
    assert_eq!(row(&grid), "  [1a");
    Grid::default().put(0, 0, "nowhere", Style::default());
}

#[test]
fn a_wide_character_takes_two_cells_or_none() {
    let mut grid = Grid::new((3, 1));
    grid.put(0, 0, "コココ", Style::default());
    let symbols: Vec<_> = grid.cells.iter().map(|cell| cell.symbol).collect();
    assert_eq!(symbols, [Some('コ'), None, Some(' ')]);
}

#[test]
fn changes_are_cells_of_another_symbol_or_look() {
    let mut shown = Grid::new((4, 2));
    shown.put(0, 1, "コab", Style::default());
    let mut next = Grid::new((4, 2));
    next.put(0, 1, "a", Style::default());
    next.put(2, 1, "a", Style::default());
    next.put(3, 1, "b", Style::of_color(Color::Yellow));
    let changes: Vec<_> = shown.changes(&next).map(|(x, y, _)| (x, y)).collect();
    assert_eq!(changes, [(0, 1), (1, 1), (3, 1)]);
    assert_eq!(next.changes(&next).count(), 0);
}
