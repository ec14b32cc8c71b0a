//! Tests of `mod.rs`.

use super::*;
use crate::synthetic;
use crate::trace::{EnergyPermille, Event, PlaceUm, event};

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
    // The page's own script and numbers, whatever names a run has.
    assert_eq!(page.matches("<script").count(), 2);
    written(page);
}

/// A whole page that loads nothing, of numbers that are ones.
pub(super) fn written(page: &str) {
    for bad in ["@import", "url(", "src=", "fetch", "import("] {
        assert!(!page.contains(bad), "{bad}");
    }
    let drawn = page.replace(SCRIPT, "");
    for bad in ["NaN", "inf\"", "inf "] {
        assert!(!drawn.contains(bad), "{bad}");
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

pub(super) fn show(name: &str, page: &str) {
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
            made: &[("command", "hil run <a> & b".to_owned())],
            ..ReportExtras::default()
        },
    );
    sound(&page);
    show("report.html", &page);
    assert!(page.contains("EMULATED") && page.contains("196.888"));
    assert!(page.contains("hil run &lt;a&gt; &amp; b"));
    let places = [
        "class=\"verdict",
        "<dl class=\"result\">",
        "<svg",
        "<table>",
        "<dl>",
    ];
    let at = |text: &str| page.find(text).unwrap();
    assert!(
        places.is_sorted_by_key(|text| at(text)),
        "the result, pictures, tables, how it was made"
    );
    assert!(at("Contact path") < at("Felt path") && at("Felt path") < at("Felt level and error"));
    assert!(page.contains("wall time") && page.contains("path error"));
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
}

#[test]
fn frames_are_drawn_as_far_as_they_are_known() {
    let section = "Contacts and time per frame";
    let (measured, not) = (
        "Measured on this machine",
        "Time per frame was not measured.",
    );
    let mut trace = synthetic::circle(1);
    let times = timing(100);
    let timed = ReportExtras {
        frame_us: &times,
        ..ReportExtras::default()
    };
    let page = report_html(&trace, &timed);
    assert!(page.contains(section) && page.contains(measured) && !page.contains(not));
    let page = report_html(&trace, &ReportExtras::default());
    assert!(page.contains(section) && page.contains(not) && !page.contains(measured));
    // Contacts that another machine found come without taxels.
    for event in &mut trace.events {
        if let Event::Frame(event::Frame { in_contact, .. }) = event {
            *in_contact = 0;
        }
    }
    let page = report_html(&trace, &timed);
    assert!(!page.contains(section) && page.contains("Contact path on the sensor"));
}

/// Text between two others.
fn between<'a>(page: &'a str, from: &str, to: &str) -> &'a str {
    let (_, rest) = page.split_once(from).unwrap();
    rest.split_once(to).unwrap().0
}

#[test]
fn the_result_counts_what_is_felt_and_marks_what_is_not() {
    let mut trace = synthetic::circle(3);
    let tiles = |trace: &Trace| {
        let page = report_html(trace, &ReportExtras::default());
        between(&page, "<dl class=\"result\">", "</dl>").to_owned()
    };
    let (all, felt) = trace
        .each::<event::Felt>()
        .fold((0, 0), |(all, felt), onset| {
            (all + 1, felt + usize::from(onset.is_felt()))
        });
    assert!(all > 10);
    let shown = tiles(&trace);
    assert!(
        shown.contains(&format!(
            "<dd>{felt} of {all} <small>onsets with one contact"
        )),
        "{shown}"
    );
    assert_eq!(
        shown.contains("<div class=\"warns\"><dt>felt</dt>"),
        felt < all
    );
    for event in &mut trace.events {
        if let Event::Felt(onset) = event {
            onset.met = None;
        }
    }
    let silent = tiles(&trace);
    assert!(silent.contains(&format!(
        "<div class=\"warns\"><dt>felt</dt><dd>0 of {all} "
    )));
    // Without an onset there is nothing to count, and no plot.
    trace
        .events
        .retain(|event| !matches!(event, Event::Felt(_)));
    assert!(!tiles(&trace).contains("<dt>felt"));
    let page = report_html(&trace, &ReportExtras::default());
    assert!(!page.contains("Felt level and error"));
}

#[test]
fn band_and_states_are_tables() {
    let trace = synthetic::circle(1);
    let band = FeltBand {
        level_db: [-22.2, 1.0, 10.6],
        felt: 0.8,
        error_mm: [0.656, 1.2, 8.4],
        draws: 1000,
        effective: 210.4,
        seed: 1,
        scene: "sphere-along".to_owned(),
        identified: true,
        evidence: vec!["<mine>".to_owned()],
    };
    let state = |state, level_db, error_mm| ReportState {
        state,
        level_db,
        error_mm,
    };
    let states = [state("passed", 4.5, Some(0.71)), state("cold", -3.4, None)];
    let extras = ReportExtras {
        band: Some(&band),
        states: &states,
        ..ReportExtras::default()
    };
    let page = report_html(&trace, &extras);
    sound(&page);
    let table = between(&page, "<h2>Felt band</h2>", "</section>");
    let level =
        "<td class=\"num\">-22.2</td><td class=\"num\">+1.0</td><td class=\"num\">+10.6</td>";
    assert!(
        table.contains("of which 210 count. 80 % feel it") && table.contains(level),
        "{table}"
    );
    assert!(table.contains("(&lt;mine&gt;) allow: 1000 draws") && table.contains("0.7</td>"));
    assert!(page.contains("band -22.2 to +10.6 dB"));
    let table = between(&page, "<h2>By state</h2>", "</section>");
    let cold = "<tr class=\"over\"><td>cold</td><td class=\"num\">-3.4</td>";
    assert!(table.contains(cold) && table.contains("0.71"), "{table}");
}

#[test]
fn a_band_that_is_not_computed_says_how() {
    let extras = ReportExtras {
        no_band: Some("not computed: hil calibrate a&b"),
        ..ReportExtras::default()
    };
    let page = report_html(&synthetic::circle(1), &extras);
    sound(&page);
    let section = between(&page, "<h2>Felt band</h2>", "</section>");
    assert!(section.contains("<p>not computed: hil calibrate a&amp;b</p>"));
}

#[test]
fn a_table_of_many_columns_names_each_cell() {
    let columns = [("", "a & b"), ("num", "c")];
    let row = || [(false, vec!["x".to_owned(), "1".to_owned()])];
    let wide = page::wide(&columns, row());
    assert!(wide.contains("<td data-l=\"a &amp; b\">x</td><td class=\"num\" data-l=\"c\">1</td>"));
    assert!(!page::table(&columns, row()).contains("data-l"));
}

#[test]
fn names_are_escaped() {
    let mut trace = synthetic::circle(1);
    trace.header.scene = "<script>alert('1')</script>&\"x\"".to_owned();
    trace.header.bench = "<b>".to_owned();
    trace.header.illusion = "<i>".to_owned();
    trace.header.source = Source::Real;
    trace.events.push(Event::Note(event::Note {
        t_us: 3,
        text: "<img src=x>".to_owned(),
    }));
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
        Event::Wire(event::Temperature {
            t_us: 1,
            wire: 900,
            milli_c: i32::MIN,
        }),
        Event::Truth(event::Truth {
            t_us: 2,
            place: PlaceUm {
                x: i32::MIN,
                y: i32::MAX,
            },
            force_mn: 0,
        }),
        Event::Felt(event::Felt {
            t_us: 2,
            target: PlaceUm::default(),
            inside: false,
            met: None,
            energy: EnergyPermille::default(),
        }),
        Event::Frame(event::Frame {
            t_us: 9,
            frame: u32::MAX,
            in_contact: u16::MAX,
            peak_counts: 0,
        }),
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
    let trace = synthetic::circle(600);
    let times = timing(60_000);
    let page = report_html(
        &trace,
        &ReportExtras {
            frame_us: &times,
            ..ReportExtras::default()
        },
    );
    show("long.html", &page);
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
}
