//! The contact path on the pad, as a map of characters.

use crate::measure::length_us;
use crate::trace::{PlaceUm, Trace, event};

/// Columns and rows of the map: a character is about twice as high as wide.
const SIZE: (usize, usize) = (57, 25);
/// Rim around the taxels, in parts of the larger side.
const RIM: i64 = 8;

struct Map {
    low: (i64, i64),
    span: i64,
    cells: Vec<Vec<u8>>,
}

impl Map {
    fn new(taxels: &[PlaceUm]) -> Option<Self> {
        let x = |p: &PlaceUm| i64::from(p.x);
        let y = |p: &PlaceUm| i64::from(p.y);
        let (left, right) = (taxels.iter().map(x).min()?, taxels.iter().map(x).max()?);
        let (bottom, top) = (taxels.iter().map(y).min()?, taxels.iter().map(y).max()?);
        let side = (right - left).max(top - bottom).max(1000);
        let span = side + 2 * side / RIM;
        Some(Self {
            low: ((left + right - span) / 2, (bottom + top - span) / 2),
            span,
            cells: vec![vec![b' '; SIZE.0]; SIZE.1],
        })
    }

    fn mark(&mut self, p: PlaceUm, mark: u8) {
        let scale = |v: i64, low: i64, cells: usize| {
            let steps = cells as i64 - 1;
            let cell = (2 * (v - low) * steps).div_euclid(self.span) + 1;
            usize::try_from(cell.div_euclid(2)).ok()
        };
        let column = scale(i64::from(p.x), self.low.0, SIZE.0);
        let row = scale(i64::from(p.y), self.low.1, SIZE.1);
        let (Some(column), Some(row)) = (column, row) else {
            return;
        };
        let Some(row) = (SIZE.1 - 1).checked_sub(row) else {
            return;
        };
        if let Some(cell) = self.cells.get_mut(row).and_then(|r| r.get_mut(column)) {
            *cell = mark;
        }
    }
}

/// Draws truth, path and taxels; a run without a layout has no map.
pub(super) fn draw(trace: &Trace) -> Vec<String> {
    let Some(mut map) = Map::new(&trace.header.taxels) else {
        return vec!["no taxel layout".to_owned()];
    };
    let length = u128::from(length_us(trace).max(1));
    for truth in trace.each::<event::Truth>() {
        map.mark(truth.place, b':');
    }
    for contact in trace.each::<event::Contact>() {
        let tenth = (u128::from(contact.t_us) * 10 / length).min(9) as u8;
        map.mark(contact.place, b'0' + tenth);
    }
    for taxel in &trace.header.taxels {
        map.mark(*taxel, b'+');
    }
    let edge = format!("  +{}+", "-".repeat(SIZE.0));
    let row = |row: &Vec<u8>| {
        let text: String = row.iter().map(|c| char::from(*c)).collect();
        format!("  |{text}|")
    };
    let mut out = vec![
        "pad: + taxel, : true path, 0..9 contact in that tenth of the run".to_owned(),
        edge.clone(),
    ];
    out.extend(map.cells.iter().map(row));
    out.push(format!("{edge} {} mm", map.span / 1000));
    out
}
