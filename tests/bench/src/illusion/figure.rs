//! Figure 5.5 of the thesis: contact path (A), contacts and time per frame (B), and what two emulated users feel in five
//! trials each, by (5.2) (C) and by the default law (D). Breaks are red.

use palpate_core::contact::Levels;
use palpate_core::illusion::{Display, IllusionModel, ModelSettings};
use palpate_core::units::{Milliamps, Point};
use palpate_emulators::person::channels::Person;
use palpate_emulators::person::contact::WireContacts;
use palpate_files::Setup;
use palpate_records::felt::FeltOnset;
use palpate_records::report::svg::Svg;
use palpate_records::trace::{Event, PlaceUm, Trace};
use palpate_run::{Failure, Input, Outcome, plan};
use palpate_tests::felt::{PATHS, SOA_US, Worn};

use crate::findings::Figure;
use crate::plot::{Area, Axis, Mark, Plot, Series};
use crate::scenes::{display, run};

const COLUMN: f64 = 280.0;
const ROW: f64 = 290.0;
/// Emulated users, whose skin touches every wire a little differently, and trials of each.
const PEOPLE: u32 = 2;
const TRIALS: u32 = 5;
/// Seed of their skin.
const SEED: u64 = 1;
/// Time from scan to scan, microseconds.
const SCAN_US: f64 = 10_000.0;

fn mm(p: PlaceUm) -> (f64, f64) {
    (f64::from(p.x) * 1e-3, f64::from(p.y) * 1e-3)
}

fn place(p: &Point) -> (f64, f64) {
    (f64::from(p.x), f64::from(p.y))
}

/// The figure, as the person feels it at this current.
pub(super) fn five_five(person: Person, drive: Milliamps) -> Result<Figure, Failure> {
    let display = display("thimble-8")?;
    let worn = |model: IllusionModel| {
        let settings = ModelSettings {
            model,
            ..ModelSettings::default()
        };
        Worn::new(&display, &settings, person, drive).map_err(|e| Failure::Input(e.to_string()))
    };
    let mut laws = [
        worn(IllusionModel::Phantom)?,
        worn(IllusionModel::default())?,
    ];
    let mut svg = Svg::new(4.0 * COLUMN, 4.0 * ROW, "Figure 5.5 for four paths");
    // Breaks inside the wires and past the outermost ones, by law.
    let mut breaks = [[0_usize; 2]; 2];
    for (column, scene) in (0_u8..).zip(PATHS) {
        let left = f64::from(column) * COLUMN;
        let setup = Setup::load(scene, "emulated")?;
        let outcome = run(&setup, &Input::Scene)?;
        svg.text((left + 100.0, 11.0), "wire-name", scene);
        contact_path(&outcome.trace).draw(&mut svg, area(left, 0.0));
        counts(&outcome, &mut svg, left);
        let path = contacts_at_onsets(&setup, &outcome.trace)?;
        for ((row, law), breaks) in (2_u8..).zip(&mut laws).zip(&mut breaks) {
            let felt = trials(law, &path, display.wires().len())?;
            for onset in felt
                .iter()
                .flatten()
                .filter(|o| !o.met.is_some_and(|m| m.is_felt()))
            {
                breaks[usize::from(!onset.inside)] += 1;
            }
            let plot = felt_path(&display, &path, &felt);
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
        title: "Figure 5.5: four paths, touched and felt".into(),
        words: format!(
            "Columns: {}. A: contacts found (dots) on the true path (line). B: taxels in contact, and time per frame on \
             this machine against the 10 ms of a scan (line). C, D: felt place at each onset in {TRIALS} trials of \
             {PEOPLE} emulated users (a colour each) by the energy centroid, at the published drive without intensity. \
             Red crosses stand where nothing was felt: breaks inside the wires, {broken} by (5.2) with s = 1 and \
             {default_broken} by the default, and past the outermost wires, {beyond} and {default_beyond}. Breaks come \
             from the law; what scatters comes from the skin's uneven contact, whose size is assumed.",
            PATHS.join(", "),
        ),
        svg: svg.finish(),
        legend: String::new(),
    })
}

/// All trials of a path, people one after another.
fn trials(worn: &mut Worn, path: &[Point], wires: usize) -> Result<Vec<Vec<FeltOnset>>, Failure> {
    let each = (0..PEOPLE).flat_map(|person| (0..TRIALS).map(move |trial| (person, trial)));
    each.map(|(person, trial)| {
        let touching = WireContacts::new(SEED, person, trial, wires);
        worn.follow(path, |wire, seconds| touching.factor(wire, seconds))
    })
    .collect()
}

/// The newest contact at each onset, on the display.
fn contacts_at_onsets(setup: &Setup, trace: &Trace) -> Result<Vec<Point>, Failure> {
    let plan = plan::plan(setup, 1, Levels::Off)?;
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
            Event::Truth { place, .. } => truth.push(mm(*place)),
            Event::Contact { place, .. } => found.push(mm(*place)),
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
        Event::Frame { in_contact, .. } => Some(f64::from(*in_contact)),
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

fn felt_path(display: &Display, path: &[Point], trials: &[Vec<FeltOnset>]) -> Plot<'static> {
    let wires = display.wires().iter().map(|w| place(&w.place)).collect();
    let aim = path.iter().map(place).collect();
    let mut series = vec![
        Series::new("contact", Mark::Line, aim),
        Series::new("wires", Mark::Places, wires),
    ];
    for trials in trials.chunks(TRIALS as usize) {
        let onsets = trials.iter().flatten();
        let felt = onsets.filter_map(|o| o.met.map(|met| mm(met.energy)));
        series.push(Series::new("felt", Mark::Scatter, felt.collect()));
    }
    let unfelt = trials
        .iter()
        .flatten()
        .filter(|o| !o.met.is_some_and(|m| m.is_felt()));
    let missing = unfelt.map(|o| mm(o.target)).collect();
    series.push(Series::new("nothing felt", Mark::Crosses, missing));
    Plot {
        x: Axis::linear("display x [mm]").span(-17.0, 17.0),
        y: Axis::linear("y [mm]").span(-17.0, 17.0),
        series,
    }
}
