//! The report of a run: one self-contained page with plots as SVG. It loads nothing and runs nothing.
//!
//! The figures follow the thesis's 5.5: the contact path (A), contacts and time per frame against
//! frames (B), the felt path (C); then wire temperatures and the schedule as a strip chart.

mod figures;
mod paths;
pub mod scale;
mod series;
mod strip;
pub mod svg;
mod tables;
mod texture;
mod thermal;

use crate::digest::trace_digest;
use crate::trace::{Source, Trace};
use std::fmt::Write;
use svg::escape;
pub use thermal::{Margin, SkinLimits, Thermal, Warmth};

/// The style sheet of the pages, light and dark.
pub const STYLE: &str = include_str!("style.css");

/// A line of the summary that the trace itself does not hold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SummaryRow {
    /// What was measured.
    pub name: String,
    /// How much.
    pub value: String,
    /// Unit, empty for a count.
    pub unit: String,
    /// The limit, in the same unit.
    pub limit: Option<String>,
    /// Whether the value breaks its limit.
    pub over: bool,
}

/// What a report shows beside the trace: measurements of this machine, which differ from run to run
/// and so have no place in a trace.
#[derive(Clone, Debug, Default)]
pub struct ReportExtras<'a> {
    /// Compression time of each frame in the trace's order, microseconds; empty if not measured, NaN
    /// where one is missing.
    pub frame_us: &'a [f32],
    /// More lines for the summary. Path error, felt error, time per frame and the ledger are there
    /// without being named here.
    pub summary: &'a [SummaryRow],
    /// What the emulated finger came to, where there is one.
    pub thermal: Option<Thermal<'a>>,
}

/// The report as one HTML page.
pub fn report_html(trace: &Trace, extras: &ReportExtras<'_>) -> String {
    let scene = escape(&tables::title(&trace.header.scene));
    let mut page = String::with_capacity(256 * 1024);
    let _ = writeln!(
        page,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>{scene} \u{b7} palpate</title>\n<style>\n{STYLE}</style></head>\n<body><main>"
    );
    tables::head(&mut page, trace);
    tables::summary(&mut page, trace, extras);
    if let Some(thermal) = &extras.thermal {
        thermal::section(&mut page, thermal);
    }
    figures::planes(&mut page, trace);
    figures::frames(&mut page, trace, extras);
    texture::section(&mut page, trace);
    figures::temperatures(&mut page, trace);
    figures::schedule(&mut page, trace);
    tables::events(&mut page, trace);
    let _ = writeln!(
        page,
        "<footer>palpate {}, trace version {}, digest of the exact trace {}. {}</footer>\n\
         </main></body></html>",
        env!("CARGO_PKG_VERSION"),
        crate::trace::VERSION,
        trace_digest(trace),
        match trace.header.source {
            Source::Emulated =>
                "Every value here comes from emulated hardware and a model of the skin.",
            Source::Real => "Real hardware took part; what is felt still comes from a model.",
        }
    );
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;
    use crate::trace::{Event, PlaceUm};

    fn timing(n: u64) -> Vec<f32> {
        (0..n)
            .map(|i| match i % 97 {
                13 => f32::NAN,
                50 => 9.5,
                k => 0.9 + (k as f32 * 0.61).sin().abs() * 0.8,
            })
            .collect()
    }

    fn sound(page: &str) {
        for bad in ["NaN", "inf\"", "inf ", "<script", "@import", "url(", "src="] {
            assert!(!page.contains(bad), "{bad}");
        }
        let namespace = "http://www.w3.org/2000/svg";
        let rest = page.replace(namespace, "");
        assert!(!rest.contains("http://") && !rest.contains("https://"));
        assert_eq!(
            page.matches("<section>").count(),
            page.matches("</section>").count()
        );
        assert!(page.ends_with("</html>\n"));
    }

    fn show(name: &str, page: &str) {
        if let Some(folder) = std::env::var_os("PALPATE_SHOW") {
            std::fs::write(std::path::Path::new(&folder).join(name), page).unwrap();
        }
    }

    #[test]
    fn a_run_becomes_one_page_that_needs_nothing() {
        let trace = synthetic::circle(10);
        let times = timing(1000);
        let rows = [SummaryRow {
            name: "wall time".to_owned(),
            value: "0.031".to_owned(),
            unit: "s".to_owned(),
            ..SummaryRow::default()
        }];
        let page = report_html(
            &trace,
            &ReportExtras {
                frame_us: &times,
                summary: &rows,
                thermal: None,
            },
        );
        sound(&page);
        show("report.html", &page);
        assert!(page.contains("EMULATED") && page.contains("196.888"));
        assert!(page.contains("wall time") && page.contains("path error"));
        assert!(page.len() < 1_000_000, "{} bytes", page.len());
    }

    #[test]
    fn names_are_escaped() {
        let mut trace = synthetic::circle(1);
        trace.header.scene = "<script>alert('1')</script>&\"x\"".to_owned();
        trace.header.bench = "<b>".to_owned();
        trace.header.illusion = "<i>".to_owned();
        trace.header.source = Source::Real;
        trace.events.push(Event::Note {
            t_us: 3,
            text: "<img src=x>".to_owned(),
        });
        let page = report_html(&trace, &ReportExtras::default());
        sound(&page.replace("&lt;img src=x&gt;", ""));
        assert!(page.contains("&lt;script&gt;") && page.contains("REAL"));
    }

    #[test]
    fn whatever_is_missing_or_absurd_leaves_a_page() {
        let mut trace = synthetic::empty();
        let page = report_html(&trace, &ReportExtras::default());
        sound(&page);
        show("empty.html", &page);
        let odd = [f32::NAN, f32::INFINITY, 0.0, -1.0];
        sound(&report_html(
            &trace,
            &ReportExtras {
                frame_us: &odd,
                ..ReportExtras::default()
            },
        ));
        trace.header.taxels.clear();
        trace.header.wires.clear();
        trace.header.soa_us = u64::MAX;
        trace.ledger.length_us = u64::MAX;
        trace.events = vec![
            Event::Wire {
                t_us: 1,
                wire: 900,
                milli_c: i32::MIN,
            },
            Event::Truth {
                t_us: 2,
                place: PlaceUm {
                    x: i32::MIN,
                    y: i32::MAX,
                },
                force_mn: 0,
            },
            Event::Felt {
                t_us: 2,
                target: PlaceUm::default(),
                inside: false,
                felt: None,
                energy_permille: 0,
            },
            Event::Frame {
                t_us: 9,
                frame: u32::MAX,
                in_contact: u16::MAX,
                peak_counts: 0,
            },
        ];
        sound(&report_html(
            &trace,
            &ReportExtras {
                frame_us: &[f32::MAX, 1.0],
                ..ReportExtras::default()
            },
        ));
    }

    #[test]
    fn a_long_run_stays_small() {
        let trace = synthetic::circle(60);
        let times = timing(6000);
        let page = report_html(
            &trace,
            &ReportExtras {
                frame_us: &times,
                ..ReportExtras::default()
            },
        );
        show("long.html", &page);
        assert!(page.len() < 2_500_000, "{} bytes", page.len());
    }
}
