//! Rows of chapter 4 before compression: the frame, faulty sensors, the relative frame and the threshold.

use palpate_core::random::RandomStream;
use palpate_core::skin::{
    Baseline, BaselineError, BaselinePhase, BaselineSettings, Layout, Module, RelativeFrame, Scan,
};
use palpate_core::units::{Instant, Point};
use palpate_files::{LayoutFile, load_layout};
use palpate_run::{Failure, plan};
use serde_json::json;

use super::row::{Answer, Mark, Row, broken};

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "eq-4.1",
        says: "A module gives a frame of 4 x 4 x 3 readings, the hand's 15 modules give 240 x 3 = 720.",
        assumed: "Nothing.",
        compute: frame,
    },
    Row {
        id: "sec-4.3.3-faulty",
        says: "A sensor is faulty where a reading is a multiple of the standard deviation from the mean of all sensors.",
        assumed: "The multiple, 3: the thesis prints none. One of 16 taxels reads 900 counts too much.",
        compute: faulty,
    },
    Row {
        id: "eq-4.2",
        says: "The relative frame is the absolute difference from the mean of the frames before contact.",
        assumed: "Ten frames before contact; a press of up to 400 counts, noise of 5 counts.",
        compute: relative,
    },
    Row {
        id: "eq-4.3",
        says: "The contact threshold is the largest value of the relative frame at t = 1.",
        assumed: "The frames of eq-4.2.",
        compute: threshold,
    },
];

/// Distance between taxels of the module, mm: printed in section 5.5.
pub(super) const PITCH_MM: f32 = 4.7;
/// Standard deviations of `sec-4.3.3-faulty`.
const FAULTY: f32 = 3.0;
/// Frames before contact.
const REFERENCE: usize = 10;
/// Readings at rest: x, y, z.
const REST: [f64; 3] = [32_800.0, 32_800.0, 37_400.0];

/// The module of 4 x 4 taxels.
pub(super) fn module() -> Result<Layout, Failure> {
    let module = Module::grid("uskin", 4, 4, PITCH_MM);
    module.and_then(Layout::single).map_err(broken)
}

/// Readings of a frame: noise about rest, and a press over a place of the module, mm.
fn readings(layout: &Layout, stream: &mut RandomStream, press: Option<[f64; 2]>) -> Vec<[u16; 3]> {
    let points = layout.modules().iter().flat_map(|m| m.points());
    let reading = |point: &Point| {
        let z = press.map_or(0.0, |[x, y]| {
            let (dx, dy) = (f64::from(point.x) - x, f64::from(point.y) - y);
            400.0 * (-(dx * dx + dy * dy) / 40.0).exp()
        });
        let mut axis = |axis: usize, add: f64| {
            (REST[axis] + add + 5.0 * (stream.uniform() - 0.5)).round() as u16
        };
        [axis(0, 0.1 * z), axis(1, -0.2 * z), axis(2, z)]
    };
    points.map(reading).collect()
}

/// Ten frames at rest, the one that gives the threshold, and one with a press.
pub(super) struct Sequence {
    layout: Layout,
    frames: Vec<Vec<[u16; 3]>>,
}

impl Sequence {
    pub(super) fn new() -> Result<Self, Failure> {
        let layout = module()?;
        let mut stream = RandomStream::new(1, "hil reproduce");
        let mut frames: Vec<_> = (0..=REFERENCE)
            .map(|_| readings(&layout, &mut stream, None))
            .collect();
        frames.push(readings(&layout, &mut stream, Some([1.0, 5.0])));
        Ok(Self { layout, frames })
    }

    /// The skin's layout.
    pub(super) const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The baseline after the frames at rest, and the relative frame of the press.
    pub(super) fn pressed(&self) -> Result<(Baseline, RelativeFrame), Failure> {
        let mut baseline =
            Baseline::new(&self.layout, BaselineSettings::default()).map_err(broken)?;
        let mut scan = Scan::new(&self.layout);
        let (last, rest) = self.frames.split_last().ok_or_else(|| broken("no frame"))?;
        for frame in rest {
            load(&mut scan, frame)?;
            baseline.feed(&scan);
        }
        if baseline.phase() != BaselinePhase::Ready {
            return Err(broken("a baseline that is not ready"));
        }
        let mut frame = baseline.frame(&self.layout);
        load(&mut scan, last)?;
        baseline.advance(&scan, &mut frame).map_err(broken)?;
        Ok((baseline, frame))
    }
}

fn load(scan: &mut Scan, frame: &[[u16; 3]]) -> Result<(), Failure> {
    scan.load(Instant::ZERO, frame).map_err(broken)
}

fn frame() -> Result<Answer, Failure> {
    let LayoutFile::Sensor(file) = load_layout("allegro")?.value else {
        return Err(broken("`allegro` is no skin"));
    };
    let hand = plan::layout(&file)?;
    let one = module()?;
    let read = hand.modules().iter().flat_map(|m| m.active());
    let taxels = read.filter(|active| **active).count();
    let axes = usize::from(one.modules()[0].axes());
    let found = [
        one.taxels() * axes,
        hand.modules().len(),
        taxels,
        taxels * axes,
    ];
    let same = found == [48, 15, 240, 720];
    Ok(Answer::new(
        Mark::new(same, || "the layout `allegro` has other modules".into()),
        format!(
            "{} readings a module; {} modules, {} taxels, {} readings.",
            found[0], found[1], found[2], found[3]
        ),
        json!({ "readings_of_module": found[0], "modules": found[1], "taxels": found[2], "readings": found[3] }),
    ))
}

fn faulty() -> Result<Answer, Failure> {
    let layout = module()?;
    let mut stream = RandomStream::new(2, "hil reproduce");
    let mut frame = readings(&layout, &mut stream, None);
    frame[5][2] += 900;
    let faults = |sigmas: f32| -> Result<Vec<usize>, Failure> {
        let settings = BaselineSettings {
            reference_frames: 1,
            fault_sigmas: Some(sigmas),
            ..BaselineSettings::default()
        };
        let mut baseline =
            Baseline::new(&layout, settings).map_err(|e: BaselineError| broken(e))?;
        let mut scan = Scan::new(&layout);
        load(&mut scan, &frame)?;
        baseline.feed(&scan);
        baseline.feed(&scan);
        let marked = baseline.faulty().iter().enumerate();
        Ok(marked.filter(|(_, f)| **f).map(|(i, _)| i).collect())
    };
    let found = faults(FAULTY)?;
    let beyond = faults(4.0)?;
    Ok(Answer::new(
        Mark::new(found == [5], || "another rule finds faulty taxels".into()),
        format!(
            "Taxels {found:?} at {FAULTY} deviations, {beyond:?} at 4: of 16 values none is further than sqrt(15) = 3.87 deviations."
        ),
        json!({ "readings": frame, "deviations": FAULTY, "faulty": found, "faulty_at_4": beyond }),
    ))
}

fn relative() -> Result<Answer, Failure> {
    let sequence = Sequence::new()?;
    let (_, frame) = sequence.pressed()?;
    let taxels = 0..sequence.layout.taxels();
    let found: Vec<[f32; 3]> = taxels
        .map(|taxel| [0, 1, 2].map(|axis| frame.axis(axis)[taxel]))
        .collect();
    let most = frame.magnitude().iter().copied().fold(0.0, f32::max);
    let count = frame.contacts().len();
    Ok(Answer::new(
        Mark::Agrees,
        format!(
            "|s - mean| of 48 readings; the largest vector is {most:.1} counts, {count} taxels are in contact."
        ),
        json!({
            "reference_frames": sequence.frames[..REFERENCE],
            "frame": sequence.frames[REFERENCE + 1],
            "relative": found,
        }),
    ))
}

fn threshold() -> Result<Answer, Failure> {
    let sequence = Sequence::new()?;
    let (baseline, frame) = sequence.pressed()?;
    Ok(Answer::new(
        Mark::Agrees,
        format!(
            "{:.1} counts, from one frame of 48 readings.",
            baseline.threshold()
        ),
        json!({
            "reference_frames": sequence.frames[..REFERENCE],
            "frame": sequence.frames[REFERENCE],
            "threshold": baseline.threshold(),
            "in_contact": frame.contacts().len(),
        }),
    ))
}
