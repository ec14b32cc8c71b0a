//! Figure 5.5 of the thesis: contact path (A), contacts and time per frame (B), and what two emulated users
//! feel in five trials each, by (5.2) (C) and by the default law (D). Breaks are red.

use std::fmt::Write;

use palpate_core::illusion::{Model, ModelSettings};
use palpate_core::units::{Milliamps, Point};
use palpate_emulators::perceiver::Perceiver;
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{Plot as Frame, Svg, dot};
use palpate_records::trace::{Event, PlaceUm, Trace};

use super::super::Figure;
use super::array;
use super::users::{PEOPLE, TRIALS, Trial, trials};
use crate::failure::Failure;
use crate::felt::{PATHS, SOA_US, Worn};
use crate::plan;
use crate::run::{Input, run};
use palpate_files::Setup;

const COLUMN: f64 = 280.0;
const ROW: f64 = 290.0;

fn mm(p: PlaceUm) -> (f64, f64) {
    (f64::from(p.x) * 1e-3, f64::from(p.y) * 1e-3)
}

/// The figure, as the perceiver feels it at this current.
pub(super) fn five_five(perceiver: Perceiver, drive: Milliamps) -> Result<Figure, Failure> {
    let display = array("thimble-8")?;
    let worn = |model: Model| {
        let settings = ModelSettings {
            model,
            ..ModelSettings::default()
        };
        Worn::new(&display, &settings, perceiver, drive).map_err(|e| Failure::Input(e.to_string()))
    };
    let wires: Vec<(f64, f64)> = display
        .wires()
        .iter()
        .map(|w| (f64::from(w.place.x), f64::from(w.place.y)))
        .collect();
    let mut laws = [worn(Model::Phantom)?, worn(Model::default())?];
    let mut svg = Svg::new(4.0 * COLUMN, 4.0 * ROW, "Figure 5.5 for four paths");
    let (mut breaks, mut outside) = ([0usize; 2], [0usize; 2]);
    for (column, scene) in (0u8..).zip(PATHS) {
        let left = f64::from(column) * COLUMN;
        let setup = Setup::load(scene, "emulated")?;
        let outcome = run(&setup, &Input::Scene, 1)?;
        let trace = &outcome.trace;
        svg.text((left + 100.0, 11.0), "wire-name", scene);
        contact_path(&mut svg, left, trace);
        counts(&mut svg, left, trace, &outcome.frame_us);
        let path = contacts_at_onsets(&setup, trace)?;
        for (row, law) in (2u8..).zip(&mut laws) {
            let felt = trials(law, &path, wires.len());
            let unfelt = felt.iter().flat_map(|t| &t.onsets);
            for onset in unfelt.filter(|o| o.felt.is_none()) {
                let counted = if onset.inside {
                    &mut breaks
                } else {
                    &mut outside
                };
                counted[usize::from(row) - 2] += 1;
            }
            felt_path(&mut svg, left, ROW * f64::from(row), &wires, &path, &felt);
        }
    }
    for (row, name) in (0u8..).zip(["A", "B", "C  (5.2)", "D  default"]) {
        let beside = if row == 0 { 80.0 } else { 140.0 };
        svg.text((beside, ROW * f64::from(row) + 11.0), "wire-name", name);
    }
    Ok(Figure {
        name: "figure-5-5".into(),
        title: "Figure 5.5: four paths, touched and felt".into(),
        words: format!(
            "Columns: {}. A: contacts found (dots) on the path (grey). B: taxels in contact, and time per frame on \
             this machine against the 10 ms of a scan (dashed). C, D: felt place at each onset in {TRIALS} trials of \
             {PEOPLE} emulated users (a colour each) by the energy centroid, at the published drive without intensity; \
             red crosses stand where nothing was felt: breaks inside the wires, {} by (5.2) with s = 1 and {} by \
             the default, and past the outermost wires, {} and {}. Breaks come from the law; what scatters comes from \
             the skin's uneven contact, whose size is assumed.",
            PATHS.join(", "),
            breaks[0],
            breaks[1],
            outside[0],
            outside[1]
        ),
        svg: svg.finish(),
    })
}

/// The newest contact at each onset, on the display.
fn contacts_at_onsets(setup: &Setup, trace: &Trace) -> Result<Vec<Point>, Failure> {
    let plan = plan::plan(setup, 1, palpate_core::contact::Levels::Off)?;
    let found = trace.events.iter().filter_map(|e| match e {
        Event::Contact { t_us, place, .. } => Some((*t_us, mm(*place))),
        _ => None,
    });
    let found: Vec<(u64, (f64, f64))> = found.collect();
    let (Some(first), Some(last)) = (found.first(), found.last()) else {
        return Ok(Vec::new());
    };
    let onsets = (first.0.div_ceil(SOA_US)..=last.0 / SOA_US).map(|k| k * SOA_US);
    let newest = |t: u64| {
        let after = found.partition_point(|c| c.0 <= t);
        let (x, y) = found[after.saturating_sub(1)].1;
        plan.map.apply(Point::new(x as f32, y as f32))
    };
    Ok(onsets.map(newest).collect())
}

fn panel(left: f64, top: f64) -> Frame {
    Frame {
        left: left + 48.0,
        top: top + 24.0,
        width: COLUMN - 60.0,
        height: ROW - 74.0,
        x: Scale::exact(0.0, 1.0),
        y: Scale::exact(0.0, 1.0),
    }
}

fn contact_path(svg: &mut Svg, left: f64, trace: &Trace) {
    let mut plot = panel(left, 0.0);
    plot.equal((-10.0, -10.0), (10.0, 10.0));
    plot.x_axis(svg, "sensor x [mm]");
    plot.y_axis(svg, "y [mm]");
    plot.frame(svg);
    let half = plot.px(1.9) - plot.px(0.0);
    for taxel in &trace.header.taxels {
        let (x, y) = plot.at(mm(*taxel));
        svg.rect((x - half, y - half), (2.0 * half, 2.0 * half), "taxel");
    }
    let (mut truth, mut dots) = (String::new(), String::new());
    for event in &trace.events {
        match event {
            Event::Truth { place, .. } => dot(&mut truth, plot.at(mm(*place))),
            Event::Contact { place, .. } => dot(&mut dots, plot.at(mm(*place))),
            _ => {}
        }
    }
    svg.path(&truth, "truth-dots");
    svg.path(&dots, "dots w2");
}

fn counts(svg: &mut Svg, left: f64, trace: &Trace, frame_us: &[f32]) {
    let in_contact: Vec<f64> = trace
        .events
        .iter()
        .filter_map(|e| match e {
            Event::Frame { in_contact, .. } => Some(f64::from(*in_contact)),
            _ => None,
        })
        .collect();
    let frames = in_contact.len().max(1) as f64;
    let mut upper = panel(left, ROW);
    upper.height = 80.0;
    (upper.x, upper.y) = (Scale::exact(0.0, frames), Scale::exact(0.0, 16.0));
    upper.y_axis(svg, "taxels in contact");
    let mut line = String::new();
    for (frame, n) in in_contact.iter().enumerate() {
        let (x, y) = upper.at((frame as f64, *n));
        let _ = write!(line, "{}{x:.1} {y:.1}", if frame == 0 { 'M' } else { 'L' });
    }
    svg.path(&line, "series");
    upper.frame(svg);
    let mut lower = panel(left, ROW + 116.0);
    (lower.height, lower.x, lower.y) = (96.0, upper.x, Scale::decades(0.5, 10_000.0));
    lower.y_axis(svg, "time per frame [\u{b5}s]");
    lower.x_axis(svg, "frame");
    let mut dots = String::new();
    for (frame, us) in frame_us.iter().enumerate() {
        if *us > 0.0 {
            dot(&mut dots, lower.at((frame as f64, f64::from(*us))));
        }
    }
    svg.path(&dots, "dots series-dots");
    let (from, to) = (lower.at((0.0, 10_000.0)), lower.at((frames, 10_000.0)));
    svg.line(from, to, "bound");
    lower.frame(svg);
}

fn felt_path(
    svg: &mut Svg,
    left: f64,
    top: f64,
    wires: &[(f64, f64)],
    path: &[Point],
    trials: &[Trial],
) {
    let mut plot = panel(left, top);
    plot.equal((-17.0, -17.0), (17.0, 17.0));
    plot.x_axis(svg, "display x [mm]");
    plot.y_axis(svg, "y [mm]");
    plot.frame(svg);
    let mut aim = String::new();
    for (i, p) in path.iter().enumerate() {
        let (x, y) = plot.at((f64::from(p.x), f64::from(p.y)));
        let _ = write!(aim, "{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' });
    }
    svg.path(&aim, "aim");
    for wire in wires {
        let (x, y) = plot.at(*wire);
        let bar = plot.px(2.5) - plot.px(0.0);
        svg.line((x - bar, y), (x + bar, y), "wire");
    }
    let mut crosses = String::new();
    for person in 0..PEOPLE {
        let mut dots = String::new();
        for trial in trials.iter().filter(|t| t.person == person) {
            for onset in &trial.onsets {
                match onset.felt {
                    Some(felt) => dot(&mut dots, plot.at(mm(felt.energy))),
                    None => {
                        let (x, y) = plot.at(mm(onset.target));
                        let _ = write!(
                            crosses,
                            "M{:.1} {:.1}l6 6M{:.1} {:.1}l6 -6",
                            x - 3.0,
                            y - 3.0,
                            x - 3.0,
                            y + 3.0
                        );
                    }
                }
            }
        }
        svg.path(&dots, &format!("dots w{}", 3 * person));
    }
    svg.path(&crosses, "cross");
}
