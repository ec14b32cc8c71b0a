//! The report of a wearer's run: the page that `hil run --html` makes, with the latency budget in its summary.

use std::path::{Path, PathBuf};

use palpate_core::units::Instant;
use palpate_files::Format;
use palpate_live::host::made;
use palpate_live::output::{Outputs, note};
use palpate_records::report::{ReportExtras, report_html};
use palpate_records::trace::{Driven, Event, Header, Ledger, Trace, sort_by_time};
use palpate_run::Failure;

use crate::budget::Budget;

/// Events that a page is made of at most: a minute and a half of one finger.
const MOST: usize = 1 << 20;

/// A report while it is gathered.
pub(super) struct Report {
    path: PathBuf,
    outputs: Outputs<'static>,
    header: Header,
    events: Vec<Event>,
    left_out: usize,
}

impl Report {
    /// Looks whether the page can be written there.
    pub(super) fn begin(path: &Path, force: bool, header: Header) -> Result<Self, Failure> {
        if path.extension().is_none_or(|e| e != "html") {
            return Err(Failure::Input(format!(
                "--html {}: expected a name that ends in .html",
                path.display()
            )));
        }
        let outputs = Outputs::new(force);
        outputs.check(path, Format::Html)?;
        Ok(Self {
            path: path.to_owned(),
            outputs,
            header,
            events: Vec::new(),
            left_out: 0,
        })
    }

    /// Keeps events, as long as there is room.
    pub(super) fn add(&mut self, events: &[Event]) {
        let room = (MOST - self.events.len()).min(events.len());
        self.events.extend_from_slice(&events[..room]);
        self.left_out += events.len() - room;
    }

    /// Writes the page.
    pub(super) fn write(
        mut self,
        latency: &Budget,
        driven: Driven,
        end: Instant,
    ) -> Result<(), Failure> {
        if self.left_out > 0 {
            let (path, left_out) = (self.path.display(), self.left_out);
            note(&format!(
                "{path}: {left_out} events at the end found no room on the page; --record keeps all"
            ));
        }
        sort_by_time(&mut self.events);
        let trace = Trace {
            header: self.header,
            events: self.events,
            ledger: Ledger {
                driven,
                length_us: end.as_micros(),
                ..Ledger::default()
            },
        };
        let extras = ReportExtras {
            summary: &latency.rows(),
            made: &made(),
            ..ReportExtras::default()
        };
        let page = || report_html(&trace, &extras);
        self.outputs
            .write_some(Some(&self.path), Format::Html, page)
    }
}
