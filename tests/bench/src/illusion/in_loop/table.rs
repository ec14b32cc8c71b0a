//! The comparison as a table for people.

use std::fmt::Write;

use palpate_tests::felt::PATHS;

use super::{Case, Figures, OTHERS, law};

/// A block per bench and wires: a line per law and kind of scene, the four paths as one by the worst of them.
pub(super) fn text(cases: &[Case], figures: &[Figures]) -> String {
    let mut out = String::new();
    let scenes = PATHS.len() + OTHERS.len();
    let of_laws = cases.chunks(scenes).zip(figures.chunks(scenes));
    let mut block = None;
    for (cases, figures) in of_laws {
        let (case, (paths, others)) = (cases[0], figures.split_at(PATHS.len()));
        if block.replace((case.drive, case.wires)) != Some((case.drive, case.wires)) {
            let _ = writeln!(
                out,
                "\n  {}, {}\n    {:14} {:14} {:>11}  {:>4} {:>5} {:3}  {:>13}  {:>13} {:>5}  {:>12}  {:>7}  {:>8}",
                case.drive.name,
                case.wires,
                "law",
                "scene",
                "error mm",
                "path",
                "most",
                "",
                "level dB",
                "breaks",
                "jumps",
                "skin, wire C",
                "limited",
                "mJ"
            );
        }
        let path = paths.iter().copied().reduce(Figures::worse);
        let lines = path
            .iter()
            .chain(others)
            .zip(["four paths"].into_iter().chain(OTHERS));
        for (figures, scene) in lines {
            let _ = writeln!(out, "    {:14} {scene:14} {}", law(case.law), line(figures));
        }
    }
    out
}

fn line(figures: &Figures) -> String {
    let [s, typical, d] = &figures.by;
    // Two contacts have no one place, so nothing of them is scored.
    let mm = |mm: Option<f64>| mm.map_or("-".to_owned(), |mm| format!("{mm:.2}"));
    let felt = typical
        .level_db
        .map_or(["-".to_owned(), "-".to_owned()], |level| {
            level.map(|db| format!("{db:.1}"))
        });
    let [energy, amplitude] = typical.mm.map(mm);
    let [median, low] = felt;
    let bound = figures.bound;
    let (path, most) = (
        mm(bound.map(|b| b.path_mm)),
        mm(bound.and_then(|b| b.most_mm)),
    );
    let met = match bound.and_then(|b| b.is_met()) {
        Some(true) => "yes",
        Some(false) => "no",
        None => "",
    };
    format!(
        "{energy:>5} {amplitude:>5}  {path:>4} {most:>5} {met:3}  {median:>6} {low:>6}  {:>4} {:>4} {:>3} {:>5}  {:>5.1} {:>6.1}  {:>7}  {:>8.0}",
        s.breaks,
        typical.breaks,
        d.breaks,
        typical.jumps,
        figures.skin_c,
        figures.wire_c,
        figures.limited,
        figures.energy_mj,
    )
}
