//! Strip charts: time to the right in quanta of a fixed length, one row a quantity.

use crate::bursts::{bursts, shown_wires};
use crate::fixed::{milli_u, seconds};
use crate::measure::length_us;
use crate::trace::{Event, PlaceUm, Trace, event};
use crate::words::{HappeningKind, happenings};

/// Quanta on one line.
const WIDTH: usize = 80;
/// Most lines of one chart.
const LINES: u64 = 105;
/// Most wires with a row of their own.
const ROWS: usize = 24;

struct Grid {
    quantum_us: u64,
    cells: usize,
}

impl Grid {
    /// The shortest of 10, 20, 50, 100, .. ms with which a chart of `rows` rows stays in its lines.
    fn new(length: u64, rows: usize) -> Self {
        let block = rows as u64 + 2;
        let mut quantum_us = 10_000u64;
        for step in [2, 5, 2].iter().cycle().take(60) {
            let blocks = length.div_ceil(quantum_us).div_ceil(WIDTH as u64);
            if blocks.saturating_mul(block) <= LINES {
                break;
            }
            // 1, 2, 5, 10: the middle step is 2.5.
            quantum_us = if *step == 5 {
                (quantum_us / 2).saturating_mul(5)
            } else {
                quantum_us.saturating_mul(*step)
            };
        }
        let cells = length.div_ceil(quantum_us).max(1);
        Self {
            quantum_us,
            cells: usize::try_from(cells).unwrap_or(WIDTH).min(WIDTH * 64),
        }
    }

    fn cell(&self, t_us: u64) -> usize {
        let cell = t_us / self.quantum_us;
        usize::try_from(cell)
            .unwrap_or(usize::MAX)
            .min(self.cells - 1)
    }

    /// Cells whose middle lies in the span, and the one the span's middle lies in: no burst is lost.
    fn cells_of(&self, from_us: u64, to_us: u64) -> impl Iterator<Item = usize> {
        let half = self.quantum_us / 2;
        let first = self.cell(from_us.saturating_add(half));
        let last = self.cell(to_us.saturating_add(half)).max(first);
        let middle = self.cell(from_us + (to_us.saturating_sub(from_us)) / 2);
        let begin = from_us.saturating_add(half) / self.quantum_us;
        // A span that ends past the chart also covers the last cell.
        let past = to_us.saturating_add(half) / self.quantum_us;
        let end = if past > last as u64 && begin <= last as u64 {
            last + 1
        } else {
            last
        };
        (first..end).chain(std::iter::once(middle))
    }
}

struct Row {
    label: String,
    cells: Vec<u8>,
}

impl Row {
    fn new(label: impl Into<String>, grid: &Grid, blank: u8) -> Self {
        Self {
            label: label.into(),
            cells: vec![blank; grid.cells],
        }
    }

    fn set(&mut self, cell: usize, mark: u8) {
        if let Some(place) = self.cells.get_mut(cell) {
            *place = mark;
        }
    }

    fn raise(&mut self, cell: usize, mark: u8) {
        if let Some(place) = self.cells.get_mut(cell)
            && rank(mark) > rank(*place)
        {
            *place = mark;
        }
    }
}

/// Rank of a mark that is to win a cell: the rarer and the graver wins.
fn rank(mark: u8) -> u16 {
    match mark {
        b' ' | b'.' => 0,
        b'P' => 500,
        b'n' => 501,
        b'B' => 502,
        b'!' => 503,
        b'x' | b'X' => 504,
        other => u16::from(other),
    }
}

/// Every row in stretches of [`WIDTH`], each below its ruler and above an empty line.
fn print(out: &mut Vec<String>, grid: &Grid, rows: &[Row]) {
    let mut put = |line: &str| out.push(line.trim_end().to_owned());
    let mut from = 0;
    while from < grid.cells {
        let to = (from + WIDTH).min(grid.cells);
        let mut ruler = format!("{:>12} ", seconds(from as u64 * grid.quantum_us));
        for cell in from..to {
            ruler.push(if cell % 10 == 0 { '|' } else { ' ' });
        }
        put(&ruler);
        for row in rows {
            let cells = row.cells.get(from..to).unwrap_or_default();
            let text: String = cells.iter().map(|c| char::from(*c)).collect();
            put(&format!("{:>12} {text}", row.label));
        }
        put("");
        from = to;
    }
}

fn legend(grid: &Grid, what: &str) -> String {
    let quantum = milli_u(grid.quantum_us);
    format!("strip chart: one character is {quantum} ms, bar every 10; {what}")
}

/// 0..9, a..z, then '+'.
fn digit(n: u64) -> u8 {
    match n {
        0..=9 => b'0' + n as u8,
        10..=35 => b'a' + (n - 10) as u8,
        _ => b'+',
    }
}

fn taxel_row(trace: &Trace, grid: &Grid) -> Row {
    let mut row = Row::new("taxels", grid, b' ');
    for frame in trace.each::<event::Frame>() {
        let mark = match frame.in_contact {
            0 => b'.',
            taxels => digit(taxels.into()),
        };
        let cell = grid.cell(frame.t_us.saturating_sub(1));
        if row.cells.get(cell) == Some(&b' ') {
            row.set(cell, mark);
        }
        row.raise(cell, mark);
    }
    row
}

/// Contacts of a frame, the most in the quantum.
fn contact_row(trace: &Trace, grid: &Grid) -> Row {
    let mut row = Row::new("contacts", grid, b' ');
    let (mut frame_now, mut count) = (None, 0u64);
    for event in &trace.events {
        match event {
            Event::Frame(frame) => {
                let cell = grid.cell(frame.t_us.saturating_sub(1));
                if row.cells.get(cell) == Some(&b' ') {
                    row.set(cell, b'.');
                }
            }
            Event::Contact(contact) => {
                count = match frame_now == Some(contact.frame) {
                    true => count + 1,
                    false => 1,
                };
                frame_now = Some(contact.frame);
                row.raise(grid.cell(contact.t_us.saturating_sub(1)), digit(count));
            }
            _ => {}
        }
    }
    row
}

/// Ninths of the pad, 0 left or bottom to 9 right or top, of the contact with the smallest identity.
fn place_rows(trace: &Trace, grid: &Grid) -> [Row; 2] {
    let taxels = &trace.header.taxels;
    let span = |pick: fn(&PlaceUm) -> i32| {
        let low = taxels.iter().map(pick).min().unwrap_or(0);
        let high = taxels.iter().map(pick).max().unwrap_or(0);
        (i64::from(low), i64::from(high))
    };
    let (xs, ys) = (span(|p| p.x), span(|p| p.y));
    let ninth = |v: i32, (low, high): (i64, i64)| {
        let width = (high - low).max(1);
        let n = ((i64::from(v) - low) * 18 / width + 1) / 2;
        digit(n.clamp(0, 9) as u64)
    };
    let mut x = Row::new("x", grid, b' ');
    let mut y = Row::new("y", grid, b' ');
    let mut seen = (usize::MAX, u32::MAX);
    for now in trace.each::<event::Contact>() {
        let cell = grid.cell(now.t_us.saturating_sub(1));
        // The first sample of the smallest identity in the quantum.
        if seen.0 == cell && seen.1 <= now.contact {
            continue;
        }
        seen = (cell, now.contact);
        x.set(cell, ninth(now.place.x, xs));
        y.set(cell, ninth(now.place.y, ys));
    }
    [x, y]
}

/// The chart of a contact path.
pub(super) fn contacts(trace: &Trace) -> Vec<String> {
    // As tall as with eight wires: both charts of a run then share their quantum.
    let grid = Grid::new(length_us(trace), 10);
    let mut out = vec![legend(&grid, "x, y: 0 left or bottom, 9 right or top")];
    let mut rows = vec![taxel_row(trace, &grid), contact_row(trace, &grid)];
    rows.extend(place_rows(trace, &grid));
    print(&mut out, &grid, &rows);
    out
}

/// The chart of a schedule: events, contacts, then a row a wire.
pub(super) fn schedule(trace: &Trace) -> Vec<String> {
    let all = bursts(trace);
    let chosen = shown_wires(trace, &all, ROWS);
    let grid = Grid::new(length_us(trace), chosen.len() + 2);
    let widest = all.iter().map(|b| b.width).max().unwrap_or(0).max(1);
    let mut out = vec![
        legend(&grid, &format!("9 is {widest} ticks")),
        "  ! limited, x refused; events ! limiter, X all-off, B break, P pre-scale, n note"
            .to_owned(),
    ];
    let mut marks = Row::new("events", &grid, b' ');
    for happening in happenings(trace) {
        marks.raise(grid.cell(happening.t_us), happening.kind.mark());
    }
    for burst in all.iter().filter(|b| b.reason.is_some()) {
        marks.raise(grid.cell(burst.from_us), HappeningKind::Limiter.mark());
    }
    for felt in trace.each::<event::Felt>().filter(|felt| felt.is_break()) {
        marks.raise(grid.cell(felt.t_us), HappeningKind::Break.mark());
    }
    let mut rows = vec![marks, contact_row(trace, &grid)];
    for wire in &chosen {
        let mut row = Row::new(format!("wire {wire}"), &grid, b'.');
        for burst in all.iter().filter(|b| b.wire() == Some(*wire)) {
            let mark = match burst.width {
                0 => b'x',
                _ if burst.reason.is_some() => b'!',
                w => digit((u64::from(w) * 9).div_ceil(u64::from(widest))),
            };
            for cell in grid.cells_of(burst.from_us, burst.to_us) {
                row.raise(cell, mark);
            }
        }
        rows.push(row);
    }
    print(&mut out, &grid, &rows);
    let hidden = trace.header.wires.len().saturating_sub(chosen.len());
    if hidden > 0 {
        out.push(format!("  {hidden} wires without a row"));
    }
    let stray = all.iter().filter(|b| b.wire().is_none()).count();
    if stray > 0 {
        out.push(format!(
            "  {stray} bursts on outputs that drive no wire of the display"
        ));
    }
    out
}

#[cfg(test)]
#[path = "strip_tests.rs"]
mod tests;
