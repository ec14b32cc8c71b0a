//! The whole loop on one 4x4 module: 16 CAN frames in, contacts, and stimuli out when they are due.

use std::cell::Cell;
use std::convert::Infallible;
use std::hint::black_box;

use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::codec::uskin::{Reading, Wiring, encode};
use palpate_core::contact::{LevelTable, Levels};
use palpate_core::driver::Pca9685Bank;
use palpate_core::projector::{Observer, Projector};
use palpate_core::schedule::Entry;
use palpate_core::skin::{CanSkin, Module};
use palpate_core::units::{Duration, Instant};
use palpate_files::Setup;
use palpate_live::clock;
use palpate_run::{Failure, plan};

use crate::findings::{Findings, NO_ERROR};
use crate::null_bus::NullBus;
use crate::presses::{self, Presses, ROUND};
use crate::timing::Samples;

/// Calls of the loop; the first tenth warms up.
const STEPS: usize = 60_000;

/// A bus that holds one scan.
struct OneScan {
    frames: Vec<CanFrame>,
    at: Instant,
    taken: usize,
}

impl CanBus for OneScan {
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

/// Stimuli that the guard let through.
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
    tally: Tally,
    onsets: usize,
}

/// Polls at every scan, stimulus end and onset, a scan of 16 frames waiting each time: first those at `rest`.
fn run(setup: &Setup, rest: &[Vec<CanFrame>], scans: &[Vec<CanFrame>]) -> Result<Times, Failure> {
    let mut projector = projector(setup)?;
    let sent = Cell::new(0);
    let prescale = plan::prescale(&setup.bench.value)?;
    let mut bank = Pca9685Bank::new(NullBus(&sent), &plan::boards(&setup.bench.value), prescale);
    let bus = OneScan {
        frames: Vec::with_capacity(16),
        at: Instant::ZERO,
        taken: 0,
    };
    let mut skin = CanSkin::new(projector.layout(), bus);
    let (mut times, mut now, mut next_scan) = (Times::default(), Instant::ZERO, Instant::ZERO);
    for step in 0..STEPS {
        let source = match step.checked_sub(rest.len()) {
            None => &rest[step],
            Some(touched) => &scans[touched % ROUND],
        };
        let bus = skin.bus_mut();
        bus.frames.clone_from(source);
        (bus.at, bus.taken) = (now, 0);
        let before = sent.get();
        let begun = clock::now();
        let polled = black_box(projector.poll(now, &mut skin, &mut bank, &mut times.tally));
        let us = begun.elapsed().as_secs_f64() * 1e6;
        let onset = polled.map_err(|e| broken(&format!("the loop failed: {e:?}")))?;
        times.onsets += usize::from(onset);
        if step >= STEPS / 10 {
            match (onset, sent.get() > before) {
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
    if compressed != STEPS - rest.len() {
        return Err(broken(&format!(
            "{compressed} of {STEPS} scans had a contact"
        )));
    }
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
        encode(board, place, Reading { x, y, z })
    };
    (0..wiring.taxels()).map(frame).collect()
}

/// Measures the family.
///
/// # Errors
/// Fixtures that do not fit together.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::new("loop");
    frames(&mut findings)?;
    crate::guard::measure(&mut findings)?;
    crate::settings::measure(&mut findings)?;
    crate::skins::measure(&mut findings)?;
    Ok(findings)
}

/// A frame by what is due, over the PCA9685 driver on a bus that does nothing.
fn frames(findings: &mut Findings) -> Result<(), Failure> {
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
    let times = run(&setup, &rest, &scans)?;
    let case = "frame 4x4, 16 CAN frames in";
    for (method, samples) in [
        ("default", &times.quiet),
        ("a stimulus ends", &times.ended),
        ("an onset", &times.onset),
    ] {
        findings.row(case, method, NO_ERROR, samples.median());
    }
    findings.words.push(format!(
        "default: nothing due. {:.1} wires driven per onset; the guard changed {} stimuli.",
        times.tally.stimuli as f64 / times.onsets as f64,
        times.tally.limited
    ));
    Ok(())
}
