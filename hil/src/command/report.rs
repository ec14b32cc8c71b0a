//! The report of a run: what its summary adds to the trace, and how it was made.

use palpate_records::report::{ReportExtras, SummaryRow, report_html};
use palpate_run::{FeltBand, FeltCorner, Outcome, Refresh};

use crate::host::made;

/// A row per preset and person: the level at both ends of the gain, and the place's error, which no gain moves.
fn band_rows(band: &FeltBand) -> Vec<SummaryRow> {
    let pair = |low: &FeltCorner| {
        let same = |c: &&FeltCorner| (c.preset, &c.person) == (low.preset, &low.person);
        let high = band.corners.iter().rfind(same).unwrap_or(low);
        let error = low.error_energy_mm.map_or(String::new(), |e| {
            format!(", error {:.2} mm RMSE by energy", e.rmse)
        });
        SummaryRow {
            name: format!(
                "felt level, median: {} wires, person {}, gain {} to {}{error}",
                low.preset, low.person, low.gain, high.gain
            ),
            value: format!("{:+.1} to {:+.1}", low.level_db, high.level_db),
            unit: "dB".into(),
            ..SummaryRow::default()
        }
    };
    let gain = band.corners.first().map(|c| c.gain);
    let lowest = band.corners.iter().filter(|c| Some(c.gain) == gain);
    lowest.map(pair).collect()
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
    let mut rows = vec![
        row("taxel refresh, median", refresh(|hz| hz.median), "Hz"),
        row("taxel refresh, slowest", refresh(|hz| hz.min), "Hz"),
        row("frozen taxels", s.taxels.frozen.to_string(), ""),
        row("dead taxels", s.taxels.dead.to_string(), ""),
        row("computed in", format!("{:.3}", s.wall_s), "s"),
    ];
    rows.extend(s.felt.band.iter().flat_map(band_rows));
    report_html(
        &outcome.trace,
        &ReportExtras {
            frame_us: &outcome.frame_us,
            summary: &rows,
            readings: outcome.readings.as_ref(),
            warmth: &outcome.warmth,
            made: &made(),
            conclusion: Some(&s.conclusion),
        },
    )
}
