//! The report of a run: what its summary adds to the trace, and how it was made.

use std::path::{Path, PathBuf};

use palpate_files::Setup;
use palpate_records::report::{
    FingerReport, HandReport, Pad, ReportExtras, ReportState, SummaryRow, hand_html, report_html,
};
use palpate_run::{Outcome, Refresh};

use palpate_live::host::made;

/// The page of a run of several displays: the hand, with a link to every finger's own page in these files beside it.
pub(super) fn hand(setup: &Setup, outcome: &Outcome, files: &[PathBuf]) -> String {
    let pads = setup.sensor.value.modules.iter().map(|module| {
        let read = module.taxels().into_iter().filter(|taxel| taxel.active);
        Pad {
            name: module.name.clone(),
            place_mm: module.place_mm,
            taxels_mm: read.map(|taxel| [taxel.x_mm, taxel.y_mm]).collect(),
        }
    });
    let pads: Vec<Pad> = pads.collect();
    let files: Vec<_> = files.iter().map(|f| file_name(f)).collect();
    let displays = outcome.displays.iter().zip(&setup.fingers).zip(&files);
    let fingers = displays.map(|((display, finger), file)| FingerReport {
        name: &display.name,
        file,
        trace: &display.outcome.trace,
        modules: &finger.modules,
        merged: finger.merged,
        conclusion: &display.outcome.summary.conclusion,
    });
    let fingers: Vec<FingerReport<'_>> = fingers.collect();
    hand_html(&HandReport {
        trace: &outcome.trace,
        pads: &pads,
        fingers: &fingers,
        made: &made(),
        conclusion: &outcome.summary.conclusion,
    })
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// The page of a run.
pub fn report(outcome: &Outcome) -> String {
    let s = &outcome.summary;
    let row = |name: &str, value: String, unit: &str| SummaryRow {
        name: name.into(),
        value,
        unit: unit.into(),
        ..SummaryRow::default()
    };
    let refresh = |pick: fn(&Refresh) -> f64| {
        let hz = s.taxels.refresh_hz.as_ref();
        hz.map_or_else(|| "-".to_owned(), |hz| format!("{:.1}", pick(hz)))
    };
    let rows = [
        row("taxel refresh, median", refresh(|hz| hz.median), "Hz"),
        row("taxel refresh, slowest", refresh(|hz| hz.min), "Hz"),
        row("frozen taxels", s.taxels.frozen.to_string(), ""),
        row("dead taxels", s.taxels.dead.to_string(), ""),
        row("computed in", format!("{:.3}", s.wall_s), "s"),
    ];
    let states = s.felt.states.iter().map(|state| ReportState {
        state: state.state,
        level_db: state.level_db,
        error_mm: state.error_energy_mm.map(|error| error.rmse),
    });
    let states: Vec<ReportState> = states.collect();
    report_html(
        &outcome.trace,
        &ReportExtras {
            frame_us: &outcome.frame_us,
            summary: &rows,
            band: s.felt.band.as_ref(),
            no_band: s.felt.no_band.as_deref(),
            states: &states,
            readings: outcome.readings.as_ref(),
            warmth: &outcome.warmth,
            made: &made(),
            conclusion: Some(&s.conclusion),
        },
    )
}
