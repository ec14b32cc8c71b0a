//! The second golden of a scene: what was left of every limit, the one used up most first. And the golden of a
//! surface: what a scene comes to over a grid of forces and speeds.

use super::{COLUMNS, head, put};
use crate::fixed::milli;
use crate::report::Margin;
use crate::trace::Trace;

/// Thousandths, rounded; what is no number or does not fit counts as the largest one, which no limit is.
fn thousandths(value: f64) -> i64 {
    let value = (value * 1000.0).round();
    if value.abs() < 9e15 {
        value as i64
    } else {
        i64::MAX
    }
}

/// The golden of margins, from the most used up to the least.
pub fn margins_golden(trace: &Trace, margins: &[Margin]) -> String {
    let mut out = String::new();
    head(&mut out, "margins", trace);
    out.push('\n');
    put(
        &mut out,
        "margin                               used          worst            limit",
    );
    let mut sorted: Vec<&Margin> = margins.iter().collect();
    sorted.sort_by(|a, b| {
        let used = thousandths(b.used * 100.0).cmp(&thousandths(a.used * 100.0));
        used.then(a.name.cmp(b.name))
    });
    for m in sorted {
        let over = if m.over() { "  OVER" } else { "" };
        let line = format!(
            "  {:<26} {:>12} % {:>14} {:>16} {}{over}",
            m.name,
            milli(thousandths(m.used * 100.0)),
            milli(thousandths(m.worst)),
            milli(thousandths(m.limit)),
            if m.unit.is_empty() { "-" } else { m.unit },
        );
        put(&mut out, &line);
    }
    out
}

/// One point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Force, N.
    pub force_n: f64,
    /// Speed over the skin, mm/s.
    pub speed_mm_s: f64,
    /// Largest duty of any wire, percent.
    pub duty_percent: f64,
    /// Electrical energy, mJ.
    pub energy_mj: f64,
    /// Felt error, mm RMSE; `None` where nothing was felt.
    pub felt_mm: Option<f64>,
    /// Limiter events.
    pub limited: u32,
}

/// The golden of a surface over force and speed; `trace` is any of its runs, for what they have in common.
pub fn surface_golden(trace: &Trace, points: &[SurfacePoint]) -> String {
    let mut out = String::new();
    head(&mut out, "surface", trace);
    out.push('\n');
    put(
        &mut out,
        "force [N]  speed [mm/s]  peak duty [%]  energy [mJ]  felt error [mm]  limiter events",
    );
    for p in points {
        let felt = p
            .felt_mm
            .map_or_else(|| "-".to_owned(), |mm| milli(thousandths(mm)));
        let line = format!(
            "{:>9} {:>13} {:>14} {:>12} {felt:>16} {:>15}",
            milli(thousandths(p.force_n)),
            milli(thousandths(p.speed_mm_s)),
            milli(thousandths(p.duty_percent)),
            milli(thousandths(p.energy_mj)),
            p.limited
        );
        debug_assert!(line.len() <= COLUMNS);
        put(&mut out, &line);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn the_margin_used_up_most_comes_first_and_hostile_numbers_fit() {
        let margins = [
            Margin::new("pulse", 20.0, 200.0, "us", 0.0),
            Margin::new("skin at 0.1 mm", 43.5, 43.0, "C", 33.0),
            Margin::new("dose", f64::NAN, 0.0, "", 0.0),
            Margin::new("burst", f64::INFINITY, 50.0, "ms", 0.0),
        ];
        let text = margins_golden(&synthetic::empty(), &margins);
        let rows: Vec<&str> = text.lines().skip(6).collect();
        assert!(
            rows[3].contains("pulse") && rows[3].contains("10.000 %"),
            "{text}"
        );
        assert!(
            rows[2].contains("skin") && rows[2].contains("OVER"),
            "{text}"
        );
        assert!(text.lines().all(|l| l.len() <= COLUMNS));
    }

    #[test]
    fn a_surface_is_a_row_a_point() {
        let point = SurfacePoint {
            force_n: 0.5,
            speed_mm_s: 7.05,
            duty_percent: 2.392,
            energy_mj: 1e30,
            felt_mm: None,
            limited: u32::MAX,
        };
        let text = surface_golden(&synthetic::empty(), &[point]);
        assert!(
            text.contains("    0.500         7.050          2.392"),
            "{text}"
        );
    }
}
