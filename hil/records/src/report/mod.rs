//! The report of a run: one self-contained page with plots as SVG. It loads nothing. Without scripts every plot
//! stands as it is; with them it has values, zoom and playback (`page.js`).
//!
//! The result comes first. Then come the figures of the thesis's 5.5, contact path and felt path, and what was felt over
//! time; the schedule as a strip chart; temperatures; contacts and time per frame. Tables follow, and last how it was made.

mod face;
mod felt;
mod figures;
mod hand;
mod headline;
pub mod page;
mod paths;
mod playback;
pub mod scale;
mod series;
mod strip;
pub mod svg;
mod tables;
mod texture;
mod thermal;
mod timeplot;

use crate::digest::trace_digest;
use crate::felt::FeltBand;
use crate::readings::Readings;
use crate::trace::{Source, Trace};
use crate::verdict::Conclusion;
pub use hand::{FingerReport, HandReport, Pad, hand_html};
use std::fmt::Write;
pub use thermal::Warmth;

/// Script that lets the plots of a report answer.
const SCRIPT: &str = include_str!("page.js");

/// A line of the summary that the trace itself does not hold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SummaryRow {
    /// Name of the measured quantity.
    pub name: String,
    /// Value as printed.
    pub value: String,
    /// Unit, empty for a count.
    pub unit: String,
    /// `true` for a value to look at.
    pub over: bool,
}

/// The run through its wires in one of their states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportState {
    /// State of the wires, `cold` or `passed`.
    pub state: &'static str,
    /// Median level, dB over the person's threshold.
    pub level_db: f64,
    /// Error of the felt place by energy, RMSE, mm.
    pub error_mm: Option<f64>,
}

/// Content of a report beside the trace: measurements of this machine,
/// which differ from run to run and so have no place in a trace.
#[derive(Clone, Debug, Default)]
pub struct ReportExtras<'a> {
    /// Compression time of each frame in the trace's order, microseconds; empty if not measured, NaN
    /// where one is missing.
    pub frame_us: &'a [f32],
    /// More lines for the summary. Path error, felt error, time per frame and the ledger are there
    /// without being named here.
    pub summary: &'a [SummaryRow],
    /// Felt level and error of the bench over all that is not measured, where they are known.
    pub band: Option<&'a FeltBand>,
    /// Reason why they are not known.
    pub no_band: Option<&'a str>,
    /// The run in each state of its wires.
    pub states: &'a [ReportState],
    /// Readings of every taxel, where they were kept.
    pub readings: Option<&'a Readings>,
    /// The emulated finger over time, where there is one.
    pub warmth: &'a [Warmth],
    /// Making of the page, such as command, date and host: names and values, shown with the facts of the run.
    pub made: &'a [(&'static str, String)],
    /// Conclusion of the run; without it the page says what its ledger shows.
    pub conclusion: Option<&'a Conclusion>,
}

/// The report as one HTML page.
pub fn report_html(trace: &Trace, extras: &ReportExtras<'_>) -> String {
    let mut page = String::with_capacity(256 * 1024);
    page.push_str(&page::head(&tables::title(&trace.header.scene)));
    tables::heading(&mut page, trace);
    tables::verdict(&mut page, trace, extras.conclusion);
    headline::tiles(&mut page, trace, extras.band);
    let [pad, display] = figures::planes(&mut page, trace);
    felt::section(&mut page, trace);
    texture::section(&mut page, trace);
    figures::schedule(&mut page, trace);
    thermal::section(&mut page, trace, extras.warmth);
    face::section(&mut page, trace);
    figures::temperatures(&mut page, trace);
    figures::frames(&mut page, trace, extras);
    tables::summary(&mut page, trace, extras);
    tables::band(&mut page, extras);
    tables::states(&mut page, extras.states);
    tables::events(&mut page, trace);
    tables::made(&mut page, trace, extras.made);
    let mut after = String::new();
    playback::data(&mut after, trace, extras.readings, [&pad, &display]);
    let _ = write!(after, "<script>\n{SCRIPT}</script>");
    page + &foot(trace, &after)
}

/// The end of a page: which version made it, of what, and what comes after the content.
fn foot(trace: &Trace, after: &str) -> String {
    let words = format!(
        ", trace version {}, digest of the exact trace {}. {}",
        crate::trace::VERSION,
        trace_digest(trace),
        match trace.header.source {
            Source::Emulated | Source::Observed =>
                "Every value here comes from emulated hardware and a model of the skin.",
            Source::Real => "Real hardware took part; what is felt still comes from a model.",
        }
    );
    page::foot(&words, after)
}

#[cfg(test)]
mod tests;
