//! Heading and verdict; results, band, ledger and events as tables; the making of the page.

use super::page::table;
use super::series::scan_us;
use super::svg::escape;
use super::{ReportExtras, ReportState, SummaryRow};
use crate::felt::{decibels, energies, felt_level, felt_scores};
use crate::figures::{Figure, figures};
use crate::fixed::{milli_u, seconds};
use crate::frame_time::FrameTime;
use crate::margin::used_words;
use crate::measure::{self, Errors};
use crate::model;
use crate::trace::{Source, Trace, event};
use crate::verdict::Conclusion;
use crate::words;
use std::fmt::Write;

/// Most happenings in the table.
const EVENTS: usize = 200;

/// Prefix of the name of a replayed recording.
const REPLAY: &str = "replay of ";

/// A scene's name; of a replayed file without its folders, which stand among the facts.
pub(super) fn title(scene: &str) -> String {
    match scene.strip_prefix(REPLAY) {
        Some(path) => {
            let file = path.rsplit(['/', '\\']).next().unwrap_or(path);
            format!("{REPLAY}{file}")
        }
        None => scene.to_owned(),
    }
}

/// Verdict of the run and its reasons.
pub(super) fn verdict(page: &mut String, trace: &Trace, known: Option<&Conclusion>) {
    let mut shown = Conclusion::default();
    shown.add_margins(&trace.ledger.margins);
    let shown = known.unwrap_or(&shown);
    page.push_str(&super::page::verdict(shown.verdict, &shown.why));
}

/// Name of the scene, and whether hardware took part.
pub(super) fn heading(page: &mut String, trace: &Trace) {
    let h = &trace.header;
    let (class, word) = match h.source {
        Source::Emulated => ("", "EMULATED"),
        Source::Real => (" real", "REAL"),
        Source::Observed => (" real", "OBSERVED"),
    };
    let _ = writeln!(
        page,
        "<header><h1>{}</h1><span class=\"badge{class}\">{word}</span></header>",
        escape(&title(&h.scene))
    );
    if let Some(banner) = h.source.banner() {
        let _ = writeln!(page, "<p role=\"note\"><strong>{banner}</strong></p>");
    }
}

/// Writes the section of [`facts`].
pub(super) fn made(page: &mut String, trace: &Trace, made: &[(&'static str, String)]) {
    page.push_str("<section><h2>How it was made</h2>");
    facts(page, trace, made);
    page.push_str("</section>\n");
}

/// Facts of pulses, which motors have none of.
const PULSES: [&str; 2] = ["PWM, true", "pulse period"];

/// Facts of the run, and of the making of the page.
fn facts(page: &mut String, trace: &Trace, made: &[(&'static str, String)]) {
    let h = &trace.header;
    page.push_str("<dl>");
    let frames = trace.each::<event::Frame>().count();
    let of_all = match h.displays.as_slice() {
        [] => "frames",
        _ => "frames of all displays",
    };
    let facts = [
        ("bench", h.bench.clone()),
        ("seed", h.seed.to_string()),
        (
            "length",
            format!(
                "{} s, {frames} {of_all}",
                seconds(measure::length_us(trace))
            ),
        ),
        (
            "PWM, true",
            format!(
                "{:.3} Hz (PRE_SCALE {})",
                h.pre_scale.hz(),
                h.pre_scale.get()
            ),
        ),
        (
            "pulse period",
            format!("{} us", milli_u(h.pre_scale.period_ns())),
        ),
        (
            "burst \u{3c4}_d, onsets SOA",
            format!("{} ms, {} ms", milli_u(h.tau_d_us), milli_u(h.soa_us)),
        ),
        ("illusion", h.illusion.clone()),
        ("contacts at most, K_C", h.kc.to_string()),
        ("scene digest", h.scene_digest.clone()),
        ("limits digest", h.limits_digest.clone()),
    ];
    let of_pulses = |name: &str| PULSES.contains(&name);
    let facts = facts
        .into_iter()
        .filter(|(name, _)| !h.motors || !of_pulses(name));
    for (name, value) in made.iter().cloned().chain(facts) {
        let long = if value.len() > 40 {
            " class=\"long\""
        } else {
            ""
        };
        let _ = write!(
            page,
            "<div><dt>{name}</dt><dd{long}>{}</dd></div>",
            escape(&value)
        );
    }
    if let Some(path) = h.scene.strip_prefix(REPLAY) {
        let _ = write!(
            page,
            "<div class=\"whole\"><dt>recording</dt><dd>{}</dd></div>",
            escape(path)
        );
    }
    page.push_str("</dl>\n");
}

fn row(name: &str, value: String, unit: &str) -> SummaryRow {
    SummaryRow {
        name: name.to_owned(),
        value,
        unit: unit.to_owned(),
        over: false,
    }
}

fn error_rows(rows: &mut Vec<SummaryRow>, what: &str, errors: Option<Errors>) {
    let text = |pick: fn(Errors) -> u64| {
        errors.map_or_else(|| "\u{2013}".to_owned(), |e| milli_u(pick(e)))
    };
    rows.push(row(&format!("{what}, RMSE"), text(|e| e.rmse_um), "mm"));
    rows.push(row(&format!("{what}, largest"), text(|e| e.max_um), "mm"));
}

fn results(trace: &Trace, extras: &ReportExtras<'_>) -> Vec<SummaryRow> {
    let mut rows = Vec::new();
    let path = measure::path_error(trace);
    error_rows(&mut rows, "path error on the sensor", path);
    rows.push(row(
        "frames with one true place",
        path.map_or(0, |e| e.count).to_string(),
        "",
    ));
    let level = felt_level(trace);
    // Where no onset was to be felt, none broke and nothing was measured.
    let counted = |count: u64| level.map_or_else(|| "\u{2013}".to_owned(), |_| count.to_string());
    if let Some(level) = level {
        let who = format!("{} on {}", trace.header.person, trace.header.preset);
        for (what, mdb) in [("median", level.median_mdb), ("5 %", level.p5_mdb)] {
            let what = format!("felt level over threshold, {what} ({who})");
            rows.push(row(&what, format!("{:.1}", f64::from(mdb) * 1e-3), "dB"));
        }
        for (what, nm) in [
            ("median", level.skin_median_nm),
            ("most", level.skin_most_nm),
        ] {
            let what = format!("displacement of the skin per onset, {what}");
            rows.push(row(&what, format!("{:.1}", f64::from(nm) * 1e-3), "um"));
        }
    }
    let mut breaks = 0;
    // Without a true path there is nothing to hold the felt path against; breaks need none.
    let known = trace.each::<event::Truth>().next().is_some();
    for score in felt_scores(trace) {
        for (where_felt, errors) in [
            ("over all onsets", score.everywhere),
            ("inside the wires", score.errors),
        ] {
            let errors = errors.filter(|_| known);
            let count = errors.map_or(0, |e| e.count);
            let what = format!("felt error by {}, {count} {where_felt}", score.perceiver);
            error_rows(&mut rows, &what, errors);
        }
        let jumps = row(
            &format!("jumps by {}", score.perceiver),
            counted(score.jumps),
            "onsets",
        );
        rows.push(jumps);
        breaks = score.breaks;
    }
    let mut broken = row("breaks", counted(breaks), "onsets");
    broken.over = breaks > 0;
    rows.push(broken);
    for (name, (least, most)) in energies(trace).into_iter().flatten() {
        let text = format!("{:.1} to {:.1}", decibels(least), decibels(most));
        let what = format!("energy {name}, over one wire's");
        rows.push(row(&what, text, "dB"));
    }
    let most = trace.each().map(|frame: &event::Frame| frame.in_contact);
    rows.push(row(
        "taxels in contact, most",
        most.max().unwrap_or(0).to_string(),
        "",
    ));
    let times = FrameTime::summarise(extras.frame_us.iter().copied());
    let time = |pick: fn(FrameTime) -> f64| {
        times.map_or_else(|| "\u{2013}".to_owned(), |t| format!("{:.2}", pick(t)))
    };
    rows.push(row("time per frame, median", time(|t| t.median), "us"));
    let scan = scan_us(trace).map_or_else(String::new, |us| format!(" (a scan takes {us:.0} us)"));
    let p99 = format!("time per frame, p99{scan}");
    rows.push(row(&p99, time(|t| t.p99), "us"));
    rows.extend(extras.summary.iter().cloned());
    rows
}

/// Results, beside what was spent and allowed.
pub(super) fn summary(page: &mut String, trace: &Trace, extras: &ReportExtras<'_>) {
    let columns = [("", "measured"), ("num", "value"), ("", "unit")];
    let row = |r: SummaryRow| (r.over, vec![r.name, r.value, r.unit]);
    let rows = results(trace, extras).into_iter().map(row);
    let _ = writeln!(
        page,
        "<div class=\"pair\"><section><h2>Results</h2>{}</section>",
        table(&columns, rows)
    );
    ledger(page, trace);
    page.push_str("</div>\n");
}

/// Table of the felt level and error over all that is not measured, or the reason why there is none.
pub(super) fn band(page: &mut String, extras: &ReportExtras<'_>) {
    if let Some(why) = extras.no_band {
        let why = escape(why);
        let _ = writeln!(page, "<section><h2>Felt band</h2><p>{why}</p></section>");
    }
    let Some(band) = extras.band else {
        return;
    };
    let columns = [("", ""), ("num", "5 %"), ("num", "50 %"), ("num", "95 %")];
    let row = |name: &str, cells: [String; 3]| {
        let cells = std::iter::once(name.to_owned()).chain(cells);
        (false, cells.collect())
    };
    let rows = [
        row("level [dB]", band.level_db.map(|db| format!("{db:+.1}"))),
        row("error [mm]", band.error_mm.map(|mm| format!("{mm:.1}"))),
    ];
    let _ = writeln!(
        page,
        "<section><h2>Felt band</h2><p class=\"sub\">Wires, fingers and people as priors and evidence ({}) allow: {} draws \
         on {}, of which {:.0} count. {:.0} % feel it.</p>{}</section>",
        escape(&band.evidence.join(", ")),
        band.draws,
        escape(&band.scene),
        band.effective,
        100.0 * band.felt,
        table(&columns, rows)
    );
}

/// Table of the run in each state of its wires; nothing where that is not known.
pub(super) fn states(page: &mut String, states: &[ReportState]) {
    if states.is_empty() {
        return;
    }
    let columns = [("", "wires"), ("num", "level [dB]"), ("num", "error [mm]")];
    let row = |of: &ReportState| {
        let error = of.error_mm.map(|mm| format!("{mm:.2}"));
        let error = error.unwrap_or_else(|| "\u{2013}".to_owned());
        let level = format!("{:+.1}", of.level_db);
        (of.level_db < 0.0, vec![of.state.to_owned(), level, error])
    };
    let _ = writeln!(
        page,
        "<section><h2>By state</h2><p class=\"sub\">The same currents through wires in either state. The error is RMSE by \
         energy.</p>{}</section>",
        table(&columns, states.iter().map(row))
    );
}

/// A value of the ledger, of a bounded width: what is larger than a million is not told to the digit, and no temperature beyond
/// the model.
fn short(figure: &Figure) -> String {
    let most_c = match figure.name.as_str() {
        "hottest wire" => model::WIRE_C,
        _ => model::TISSUE_C,
    };
    match figure.value {
        Some(milli)
            if figure.unit == "C" && model::known(milli as f64 * 1e-3, most_c).is_none() =>
        {
            format!("> {most_c:.0}")
        }
        Some(milli) if milli > 1_000_000_000 => "> 1e6".to_owned(),
        value => figure.text(value),
    }
}

/// A used part, thousandths of a percent, as a bar and in words; `None` is a limit at rest.
pub(super) fn meter(used: Option<i64>) -> String {
    let bar = used.map_or(100, |used| (used / 1000).clamp(0, 100));
    let words = used_words(used).replace(' ', "\u{a0}");
    format!("<span class=\"meter\"><i style=\"width:{bar}%\"></i></span>{words}")
}

/// A name in which no line ends between a number and its unit.
fn whole_units(name: &str) -> String {
    let mut before = ' ';
    let joined = name.chars().map(|c| {
        let parts = c == ' ' && before.is_ascii_digit();
        before = c;
        if parts { '\u{a0}' } else { c }
    });
    joined.collect()
}

/// Totals, then the margins.
pub(super) fn ledger(page: &mut String, trace: &Trace) {
    let columns = [
        ("", "spent"),
        ("num", "value"),
        ("", "unit"),
        ("num", "limit"),
        ("html", "used"),
    ];
    let row = |f: &Figure| {
        let used = f.used.map_or_else(String::new, |used| meter(Some(used)));
        let unit = match f.unit.as_str() {
            "C" => "\u{b0}C",
            "Omega" => "\u{3a9}",
            unit => unit,
        };
        let limit = f.limit.map_or_else(String::new, |_| f.text(f.limit));
        let cells = vec![whole_units(&f.name), short(f), unit.to_owned(), limit, used];
        (f.over, cells)
    };
    let spent = table(&columns, figures(trace).iter().map(row));
    let words = if trace.ledger.margins.is_empty() {
        "Nothing measured what flowed in this run."
    } else {
        "Limits are held against currents that flowed and temperatures that the model of wire and finger \
         reached. The most used up comes first; temperatures count from 33 \u{b0}C."
    };
    let _ = writeln!(
        page,
        "<section><h2>Ledger against its limits</h2>{spent}<p class=\"sub words\">{words}</p></section>"
    );
}

/// Limiter events, breaks, all-off and notes in words.
pub(super) fn events(page: &mut String, trace: &Trace) {
    let list = words::happenings(trace);
    let _ = writeln!(page, "<section><h2>Events</h2>");
    if list.is_empty() {
        page.push_str("<p class=\"sub\">Nothing worth a line happened.</p></section>\n");
        return;
    }
    let columns = [
        ("num", "from [s]"),
        ("num", "to [s]"),
        ("html", "kind"),
        ("", "what"),
    ];
    let row = |h: &words::Happening| {
        let to = Some(h.last_us).filter(|last_us| *last_us > h.t_us);
        let kind = h.kind.word();
        let kind = format!("<span class=\"kind {kind}\">{kind}</span>");
        let cells = vec![
            seconds(h.t_us),
            to.map(seconds).unwrap_or_default(),
            kind,
            h.text.clone(),
        ];
        (false, cells)
    };
    page.push_str(&table(&columns, list.iter().take(EVENTS).map(row)));
    if list.len() > EVENTS {
        let _ = writeln!(
            page,
            "<p class=\"sub\">and {} more</p>",
            list.len() - EVENTS
        );
    }
    page.push_str("</section>\n");
}
