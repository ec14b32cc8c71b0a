//! Tables of a golden: columns known by the kind of golden, cells as printed.

use super::GoldenKind;
use std::fmt::Write;

/// Role of a column in a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The column names the row.
    Key,
    /// A difference in the column is told.
    Told,
    /// The column follows from the bursts of the row's wire: a difference is told where these are the same.
    Derived,
}

/// A column: what it says, in which unit, how wide it is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name of the column.
    pub name: &'static str,
    /// Unit of its cells; empty for counts and names.
    pub unit: &'static str,
    /// Role in a comparison.
    pub role: Role,
    width: usize,
}

const fn column(name: &'static str, unit: &'static str, role: Role, width: usize) -> Column {
    Column {
        name,
        unit,
        role,
        width,
    }
}

use Role::{Derived, Key, Told};

const WIRES: &[Column] = &[
    column("wire", "", Key, 6),
    column("output", "", Told, 8),
    column("x", "mm", Told, 9),
    column("y", "mm", Told, 9),
    column("bursts", "", Derived, 8),
    column("limited", "", Derived, 9),
    column("on", "s", Derived, 9),
    column("widest", "", Derived, 8),
    column("mean duty", "%", Derived, 15),
    column("hottest", "C", Told, 13),
];

const CONTACTS: &[Column] = &[
    column("contact", "", Key, 9),
    column("from", "s", Told, 10),
    column("to", "s", Told, 10),
    column("frames", "", Told, 8),
    column("x0", "mm", Told, 9),
    column("y0", "mm", Told, 9),
    column("x1", "mm", Told, 9),
    column("y1", "mm", Told, 9),
    column("levels", "", Told, 9),
    column("peak", "", Told, 7),
    column("taxels", "", Told, 8),
];

const POINTS: &[Column] = &[
    column("force", "N", Key, 11),
    column("speed", "mm/s", Key, 14),
    column("peak duty", "%", Told, 15),
    column("energy", "mJ", Told, 13),
    column("felt error", "mm", Told, 17),
    column("limiter events", "", Told, 16),
];

/// A table of a golden.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Columns of the table.
    pub columns: &'static [Column],
    /// Rows of the table, a cell a column; no cell has a space.
    pub rows: Vec<Vec<String>>,
    /// Rows that are counted and not listed.
    pub untold: u64,
}

impl Column {
    /// `x [mm]`.
    fn heading(&self) -> String {
        if self.unit.is_empty() {
            return self.name.to_owned();
        }
        format!("{} [{}]", self.name, self.unit)
    }
}

impl Table {
    /// The empty table of a kind of golden.
    pub(super) const fn new(kind: GoldenKind) -> Self {
        Self {
            columns: match kind {
                GoldenKind::Schedule => WIRES,
                GoldenKind::Contacts => CONTACTS,
                GoldenKind::Surface => POINTS,
            },
            rows: Vec::new(),
            untold: 0,
        }
    }

    /// Heading of the table as a line.
    pub(super) fn heading(&self) -> String {
        self.line(|column| column.heading())
    }

    /// A row of the table as a line.
    pub(super) fn row(&self, cells: &[String]) -> String {
        let mut cells = cells.iter();
        self.line(|_| cells.next().cloned().unwrap_or_default())
    }

    fn line(&self, mut cell: impl FnMut(&Column) -> String) -> String {
        let mut line = String::new();
        for column in self.columns {
            let cell = cell(column);
            // One that is too wide must not run into its neighbour.
            let gap = usize::from(cell.len() >= column.width);
            let _ = write!(line, "{:gap$}{cell:>width$}", "", width = column.width);
        }
        line
    }

    /// The cells that name a row.
    pub(super) fn key(&self, row: &[String]) -> Vec<String> {
        let cells = self.columns.iter().zip(row);
        let keys = cells.filter(|(column, _)| column.role == Key);
        keys.map(|(_, cell)| cell.clone()).collect()
    }

    /// The cells of a row's line, if it is one.
    pub(super) fn read_row(&self, line: &str) -> Option<Vec<String>> {
        let cells: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let figure = |cell: &String| cell.bytes().all(|b| b"0123456789+-.:/".contains(&b));
        (cells.len() == self.columns.len() && cells.iter().all(figure)).then_some(cells)
    }
}
