//! Figure 5.5 of the thesis: contact path (A), contacts and time per frame (B), and what a person feels in the loop in five
//! runs, by (5.2) (C) and by the default law (D). Breaks are red.

use palpate_core::illusion::IllusionModel;
use palpate_files::{Overrides, Setup};
use palpate_hil::reproduce::setups::run;
use palpate_records::report::svg::Svg;
use palpate_records::trace::{Event, PlaceUm, Trace, event};
use palpate_run::{Failure, Input, Outcome};
use palpate_tests::felt::PATHS;

use super::laws::{BENCH, SCORING, play};
use crate::findings::Figure;
use crate::plot::{Area, Axis, Mark, Plot, Series};

const COLUMN: f64 = 280.0;
const ROW: f64 = 290.0;
/// Time from scan to scan, microseconds.
const SCAN_US: f64 = 10_000.0;

fn mm(p: PlaceUm) -> (f64, f64) {
    (f64::from(p.x) * 1e-3, f64::from(p.y) * 1e-3)
}

/// The figure, as the typical person feels it.
pub(super) fn five_five() -> Result<Figure, Failure> {
    let mut svg = Svg::new(4.0 * COLUMN, 4.0 * ROW, "Figure 5.5 for four paths");
    // Breaks inside the wires and past the outermost ones, by law.
    let mut breaks = [[0_usize; 2]; 2];
    for (column, scene) in (0_u8..).zip(PATHS) {
        let left = f64::from(column) * COLUMN;
        svg.text((left + 100.0, 11.0), "wire-name", scene);
        let setup = Setup::load(scene, BENCH)?;
        let outcome = run(&setup, &Input::Scene)?;
        contact_path(&outcome.trace).draw(&mut svg, area(left, 0.0));
        counts(&outcome, &mut svg, left);
        let laws = [IllusionModel::Phantom, IllusionModel::default()];
        for ((row, law), breaks) in (2_u8..).zip(laws).zip(&mut breaks) {
            let mut overrides = Overrides::default();
            overrides.scene("figure", "illusion.model", law.name());
            let felt = trials(&setup.clone().with(&overrides)?)?;
            for onset in felt.iter().filter(|o| !o.felt) {
                breaks[usize::from(!onset.inside)] += 1;
            }
            let wires = outcome.trace.header.wires.iter().map(|w| mm(w.place));
            let plot = felt_path(wires.collect(), &felt);
            plot.draw(&mut svg, area(left, ROW * f64::from(row)));
        }
    }
    for (row, name) in (0_u8..).zip(["A", "B", "C  (5.2)", "D  default"]) {
        let beside = if row == 0 { 80.0 } else { 140.0 };
        svg.text((beside, ROW * f64::from(row) + 11.0), "wire-name", name);
    }
    let [[broken, beyond], [default_broken, default_beyond]] = breaks;
    Ok(Figure {
        name: "figure-5-5".into(),
        title: "Figure 5.5: four paths, touched and felt in the loop".into(),
        words: format!(
            "Columns: {}. A: contacts found (dots) on the true path (line). B: taxels in contact, and time per frame on \
             this machine against the 10 ms of a scan (line). C, D: the contact (blue) and where each onset of {} runs pulls by the energy \
             centroid, on the default bench with guard and heat: a dot where the typical person feels it, a red cross where \
             not. Such breaks inside the wires: {broken} by (5.2) with s = 1, {default_broken} by the default; past the \
             outermost wires {beyond} and {default_beyond}.",
            PATHS.join(", "),
            SCORING.len(),
        ),
        svg: svg.finish(),
        legend: String::new(),
        alone: None,
    })
}

/// One onset of a run.
struct Trial {
    target: (f64, f64),
    inside: bool,
    /// Place that it is felt at by the energy centroid.
    at: (f64, f64),
    felt: bool,
}

/// All onsets of a run per scoring seed.
fn trials(setup: &Setup) -> Result<Vec<Trial>, Failure> {
    let mut trials = Vec::new();
    for seed in SCORING {
        let outcome = play(setup, seed)?;
        for event in &outcome.trace.events {
            if let Event::Felt(event::Felt {
                target,
                inside,
                met: Some(met),
                ..
            }) = event
            {
                trials.push(Trial {
                    target: mm(*target),
                    inside: *inside,
                    at: mm(met.energy),
                    felt: met.is_felt(),
                });
            }
        }
    }
    Ok(trials)
}

/// A square panel.
const fn area(left: f64, top: f64) -> Area {
    Area {
        at: (left + 48.0, top + 24.0),
        size: (COLUMN - 60.0, COLUMN - 60.0),
    }
}

fn contact_path(trace: &Trace) -> Plot<'static> {
    let (mut truth, mut found) = (Vec::new(), Vec::new());
    for event in &trace.events {
        match event {
            Event::Truth(event::Truth { place, .. }) => truth.push(mm(*place)),
            Event::Contact(event::Contact { place, .. }) => found.push(mm(*place)),
            _ => {}
        }
    }
    let taxels = trace.header.taxels.iter().map(|p| mm(*p)).collect();
    Plot {
        x: Axis::linear("sensor x [mm]").span(-10.0, 10.0),
        y: Axis::linear("y [mm]").span(-10.0, 10.0),
        series: vec![
            Series::new("taxels", Mark::Places, taxels),
            Series::new("truth", Mark::Line, truth),
            Series::new("contacts", Mark::Scatter, found),
        ],
    }
}

fn counts(outcome: &Outcome, svg: &mut Svg, left: f64) {
    let in_contact = outcome.trace.events.iter().filter_map(|e| match e {
        Event::Frame(event::Frame { in_contact, .. }) => Some(f64::from(*in_contact)),
        _ => None,
    });
    let counts: Vec<_> = in_contact.enumerate().map(|(i, n)| (i as f64, n)).collect();
    let frames = counts.len().max(1) as f64;
    let times = outcome.frame_us.iter().enumerate();
    let times = times.map(|(i, us)| (i as f64, f64::from(*us))).collect();
    let panel = |top: f64, height: f64| Area {
        at: (left + 48.0, ROW + top),
        size: (COLUMN - 60.0, height),
    };
    let x = |label| Axis::linear(label).span(0.0, frames);
    let upper = Plot {
        x: x(""),
        y: Axis::linear("taxels in contact").span(0.0, 16.0),
        series: vec![Series::new("taxels", Mark::Line, counts)],
    };
    upper.draw(svg, panel(24.0, 80.0));
    let scan = vec![(0.0, SCAN_US), (frames, SCAN_US)];
    let lower = Plot {
        x: x("frame"),
        y: Axis::decades("time per frame [\u{b5}s]").span(0.5, SCAN_US),
        series: vec![
            Series::new("frames", Mark::Scatter, times),
            Series::new("scan", Mark::Line, scan),
        ],
    };
    lower.draw(svg, panel(140.0, 96.0));
}

fn felt_path(wires: Vec<(f64, f64)>, trials: &[Trial]) -> Plot<'static> {
    let places = |felt: bool| {
        let these = trials.iter().filter(move |t| t.felt == felt);
        these.map(|t| t.at).collect()
    };
    let contact = trials.iter().map(|t| t.target).collect();
    Plot {
        x: Axis::linear("display x [mm]").span(-17.0, 17.0),
        y: Axis::linear("y [mm]").span(-17.0, 17.0),
        series: vec![
            Series::new("contact", Mark::Scatter, contact),
            Series::new("wires", Mark::Places, wires),
            Series::new("not felt", Mark::Crosses, places(false)),
            Series::new("felt", Mark::Scatter, places(true)),
        ],
    }
}
