//! The whole loop on one 4x4 module: 16 CAN frames in, contacts, and stimuli out when they are due; and what is felt
//! against the time it takes.

use std::convert::Infallible;
use std::hint::black_box;

use embedded_hal::i2c::{ErrorType, I2c, Operation};
use palpate_core::bus::{Actuators, Received, SensorBus};
use palpate_core::contact::{LevelTable, Levels};
use palpate_core::driver::Pca9685Bank;
use palpate_core::guard::Guarded;
use palpate_core::projector::{Observer, Projector};
use palpate_core::schedule::Entry;
use palpate_core::skin::Module;
use palpate_core::units::{Duration, Instant};
use palpate_core::wire::can::CanFrame;
use palpate_core::wire::uskin::{IdProfile, Reading, Wiring, encode};

use super::compression::presses::{self, Presses, ROUND};
use super::plot::{Mark, Plot, Series};
use super::timing::Samples;
use super::{Findings, Row};
use crate::failure::Failure;
use crate::run::{Input, run as run_scene};
use crate::{clock, plan};
use palpate_files::{Setup, load_bench, load_scene};

/// A bus that holds one scan.
struct OneScan {
    frames: Vec<CanFrame>,
    at: Instant,
    taken: usize,
}

impl SensorBus for OneScan {
    type Error = Infallible;

    fn receive(&mut self) -> Result<Option<Received>, Infallible> {
        let frame = self.frames.get(self.taken).copied();
        self.taken += 1;
        Ok(frame.map(|frame| Received {
            at: self.at,
            bus: 0,
            frame,
        }))
    }

    fn transmit(&mut self, _bus: u8, _frame: &CanFrame) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Actuators that do nothing.
struct Nothing;

impl Actuators for Nothing {
    type Error = Infallible;

    fn apply(&mut self, update: &Guarded) -> Result<(), Infallible> {
        black_box(update);
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// An I2C bus without time and without chips.
struct NullBus;

impl ErrorType for NullBus {
    type Error = Infallible;
}

impl I2c for NullBus {
    fn transaction(
        &mut self,
        _address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Infallible> {
        black_box(operations);
        Ok(())
    }
}

/// Counts what the loop sends, so that its calls can be told apart.
struct Counted<A> {
    inner: A,
    updates: usize,
    channels: usize,
}

impl<A: Actuators> Actuators for Counted<A> {
    type Error = A::Error;

    fn apply(&mut self, update: &Guarded) -> Result<(), A::Error> {
        self.updates += 1;
        self.channels += update.channels().iter().flatten().count();
        self.inner.apply(update)
    }

    fn all_off(&mut self) -> Result<(), A::Error> {
        self.inner.all_off()
    }
}

/// What the guard let through.
#[derive(Default)]
struct Tally {
    stimuli: usize,
    limited: usize,
}

impl Observer for Tally {
    fn entry(&mut self, entry: &Entry) {
        self.stimuli += usize::from(entry.width().get() > 0);
        self.limited += usize::from(entry.reason.is_some());
    }
}

/// Times of one run of the loop, by what was due.
#[derive(Default)]
struct Times {
    quiet: Samples,
    ended: Samples,
    onset: Samples,
    channels: usize,
    tally: Tally,
    onsets: usize,
}

/// Polls at every scan, stimulus end and onset, a scan of 16 frames waiting each time.
fn run<A: Actuators>(
    projector: &mut Projector,
    scans: &[Vec<CanFrame>],
    rest: &[Vec<CanFrame>],
    actuators: A,
    count: usize,
) -> Result<Times, Failure> {
    let mut actuators = Counted {
        inner: actuators,
        updates: 0,
        channels: 0,
    };
    let mut bus = OneScan {
        frames: Vec::with_capacity(16),
        at: Instant::ZERO,
        taken: 0,
    };
    let (mut times, mut now, mut next_scan) = (Times::default(), Instant::ZERO, Instant::ZERO);
    let mut tally = Tally::default();
    for step in 0..count {
        let source = match step.checked_sub(rest.len()) {
            None => &rest[step],
            Some(touched) => &scans[touched % ROUND],
        };
        bus.frames.clone_from(source);
        (bus.at, bus.taken) = (now, 0);
        let before = actuators.updates;
        let begun = clock::now();
        let polled = black_box(projector.poll(now, &mut bus, &mut actuators, &mut tally));
        let us = begun.elapsed().as_secs_f64() * 1e6;
        let onset = polled.map_err(|e| broken(&format!("the loop failed: {e:?}")))?;
        times.onsets += usize::from(onset);
        // The first tenth warms up.
        if step >= count / 10 {
            match (onset, actuators.updates > before) {
                (true, _) => times.onset.push(us),
                (false, true) => times.ended.push(us),
                (false, false) => times.quiet.push(us),
            }
        }
        if now >= next_scan {
            next_scan = now + Duration::from_micros(10_000);
        }
        now = projector.next().min(next_scan).max(now + TICK);
    }
    let work = projector.work();
    let compressed = (work.means + work.repeats) as usize;
    if compressed != count - rest.len() {
        return Err(broken(&format!(
            "{compressed} of {count} scans had a contact"
        )));
    }
    times.channels = actuators.channels;
    times.tally = tally;
    Ok(times)
}

/// Virtual time never stands still.
const TICK: Duration = Duration::from_micros(1);

/// The default scene's loop with `touched` taxels always in contact.
fn projector(setup: &Setup) -> Result<Projector, Failure> {
    let strengths: Vec<f32> = (0..200).map(|i| 300.0 + 10.0 * i as f32).collect();
    let levels = LevelTable::from_intensities(&strengths, 10).map_err(|e| broken(&e))?;
    Projector::new(plan::plan(setup, 1, Levels::Table(levels))?).map_err(|e| broken(&e))
}

fn broken(what: &dyn std::fmt::Display) -> Failure {
    Failure::Input(format!("bench loop: {what}"))
}

/// The 16 frames of one scan in the order of the wire.
fn on_the_wire(board: u8, counts: &[[u16; 3]]) -> Option<Vec<CanFrame>> {
    let wiring = Wiring::FLAT;
    let frame = |n| {
        let place = wiring.nth(n)?;
        let [x, y, z] = *counts.get(wiring.taxel(place)?.1)?;
        encode(IdProfile::Current, board, place, Reading { x, y, z })
    };
    (0..wiring.taxels()).map(frame).collect()
}

/// Measures the family.
///
/// # Errors
/// Fixtures that do not fit together.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::default();
    frames(&mut findings)?;
    super::guard::measure(&mut findings)?;
    felt(&mut findings)?;
    Ok(findings)
}

fn row(case: &str, method: &str, error: (f64, &'static str), median_us: f64) -> Row {
    Row {
        family: "loop",
        case: case.into(),
        method: method.into(),
        error: error.0,
        error_unit: error.1,
        median_us,
        peer: false,
    }
}

/// A frame by what is due, over actuators that do nothing and over the real driver on a bus that does nothing.
fn frames(findings: &mut Findings) -> Result<(), Failure> {
    const STEPS: usize = 60_000;
    let setup = Setup::load("sphere-along", "emulated")?;
    let layout = plan::layout(&setup.sensor.value)?;
    let address = layout.modules().first().and_then(Module::address);
    let board = address
        .ok_or_else(|| broken(&"the module has no board"))?
        .board;
    let wire = |range: std::ops::Range<usize>, touched: Option<Presses>| {
        range
            .map(|f| on_the_wire(board, &presses::counts(&layout, f, touched)))
            .collect::<Option<Vec<_>>>()
            .ok_or_else(|| broken(&"a taxel has no identifier"))
    };
    let rest = wire(0..setup.scene.value.reference_frames as usize + 1, None)?;
    let scans = wire(0..ROUND, Some(Presses::EveryModule(12)))?;
    // Real boards repeat three rows of four.
    let stale: Vec<_> = (0..ROUND).map(|f| scans[f / 4 * 4].clone()).collect();

    let none = run(&mut projector(&setup)?, &scans, &rest, Nothing, STEPS)?;
    let quiet = run(&mut projector(&setup)?, &stale, &rest, Nothing, STEPS)?;
    let prescale = plan::prescale(&setup.bench.value)?;
    let bank = Pca9685Bank::new(NullBus, &plan::boards(&setup.bench.value), prescale);
    let driver = run(&mut projector(&setup)?, &scans, &rest, bank, STEPS)?;
    if none.channels == 0 || none.channels != driver.channels {
        let (a, b) = (none.channels, driver.channels);
        return Err(broken(&format!(
            "the loop wrote {a} channels, with a driver {b}"
        )));
    }
    let case = "frame 4x4, 16 CAN frames in";
    for (method, samples) in [
        ("default", &none.quiet),
        ("three of four repeated", &quiet.quiet),
        ("a stimulus ends", &none.ended),
        ("an onset", &none.onset),
        ("a stimulus ends, PCA9685 driver", &driver.ended),
        ("an onset, PCA9685 driver", &driver.onset),
    ] {
        findings
            .rows
            .push(row(case, method, (f64::NAN, ""), samples.median()));
    }
    findings.words.push(format!(
        "default: nothing due. {:.1} wires driven an onset; the guard changed {} stimuli.",
        driver.tally.stimuli as f64 / driver.onsets as f64,
        driver.tally.limited
    ));
    Ok(())
}

/// Felt error against the time of a frame, over K_C, the solver's iterations, cadence, the weights' exponent and the
/// frames left out.
fn felt(findings: &mut Findings) -> Result<(), Failure> {
    type Change = Box<dyn Fn(&mut palpate_files::Scene)>;
    let mut sweeps: Vec<(&str, Vec<(String, Change)>)> =
        vec![("default", vec![("default".into(), Box::new(|_| ()))])];
    let clusters = [2, 4, 8, 16].map(|kc| {
        let change: Change = Box::new(move |s| s.compression.kc = kc);
        (format!("K={kc}"), change)
    });
    sweeps.push(("K_C", clusters.into()));
    let solvers = [(4, 1), (4, 2), (16, 1), (16, 2)].map(|(kc, most)| {
        let change: Change = Box::new(move |s| {
            s.compression.kc = kc;
            s.compression.iterations = Some(most);
        });
        (format!("K={kc}, iterations {most}"), change)
    });
    sweeps.push(("solver stopped early", solvers.into()));
    let cadence = [40.0, 80.0, 105.0, 125.0].map(|ms| {
        let change: Change = Box::new(move |s| s.illusion.soa_ms = Some(ms));
        (format!("SOA {ms} ms"), change)
    });
    sweeps.push(("cadence", cadence.into()));
    let exponent = [0.0, 1.0, 4.0].map(|p| {
        let change: Change = Box::new(move |s| s.compression.weight_exponent = p);
        (format!("p={p}"), change)
    });
    sweeps.push(("weights", exponent.into()));
    let rate = [25.0, 50.0].map(|hz| {
        let change: Change = Box::new(move |s| {
            s.rate_hz = hz;
            s.reference_frames = 10;
        });
        (format!("{hz} Hz"), change)
    });
    sweeps.push(("frames left out", rate.into()));
    let mut series = Vec::new();
    for (sweep, variants) in sweeps {
        let mut points = Vec::new();
        for (method, change) in variants {
            let mut scene = load_scene("sphere-circle")?;
            change(&mut scene.value);
            let seconds = scene.value.length_s;
            let setup = Setup::join(scene, load_bench("emulated")?)?;
            let outcome = run_scene(&setup, &Input::Scene, 1)?;
            // The loop's whole time a second of the scene: frames left out cost nothing.
            // The median stands for every frame, so that a machine with other work to do does not count.
            let summary = &outcome.summary;
            let each = summary.frame_us.map_or(f64::NAN, |t| t.median);
            let spent = each * f64::from(summary.frames) / seconds;
            let error = summary.felt_error_mm.rmse.unwrap_or(f64::NAN);
            findings.rows.push(row(
                "felt sphere-circle, a second",
                &method,
                (error, "mm felt RMSE"),
                spent,
            ));
            points.push((spent, error));
        }
        series.push(Series {
            name: sweep.into(),
            points,
            mark: if sweep == "default" {
                Mark::Ours
            } else {
                Mark::Swept
            },
        });
    }
    let mut plot = Plot::work_precision(
        "felt",
        "Felt error against the time of the whole loop",
        "felt RMSE [mm]",
        series,
    );
    plot.x.label = "time of the loop for a second of touch [\u{b5}s]".into();
    findings.plots.push(plot);
    Ok(())
}
