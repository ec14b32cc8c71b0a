//! The loop on skins that are no uSkin module, beside what compression alone costs on the same readings; and the loops of a
//! hand's four fingers in one turn.

use std::cell::Cell;

use palpate_core::contact::{Compressor, Levels};
use palpate_core::driver::Pca9685Bank;
use palpate_core::projector::Projector;
use palpate_core::skin::{Baseline, BaselinePhase, Layout, ModuleScan, RelativeFrame, Scan};
use palpate_core::units::{Duration, Instant};
use palpate_files::Setup;
use palpate_live::clock;
use palpate_run::place::{Place, fingers};
use palpate_run::{Failure, TaxelTable, build, plan, taxels};

use crate::findings::{Findings, NO_ERROR};
use crate::null_bus::NullBus;
use crate::timing::Samples;

const SCENES: [(&str, &str); 4] = [
    ("iCub patch, 140 taxels", "icub-patch-stroke"),
    ("DIGIT, 64 x 48 blocks", "digit-circle"),
    ("H1, one of 35 patches", "h1-patch"),
    ("H1, 1260 cells as one skin", "h1-follow"),
];

/// Measures all of them.
///
/// # Errors
/// A scene that does not run.
pub fn measure(findings: &mut Findings) -> Result<(), Failure> {
    for (name, scene) in SCENES {
        let (turn, alone) = times(&Setup::load(scene, "emulated")?)?;
        let (case, turn, alone) = (format!("turn {name}"), turn.median(), alone.median());
        findings.row(&case, "default", NO_ERROR, turn);
        findings.row(&case, "compression alone", NO_ERROR, alone);
        findings.target(&case, turn, 2.0 * alone);
    }
    hand(findings)
}

/// The most that a turn of a hand's four loops may take, us.
const HAND_US: f64 = 25.0;
/// Scans of a skin that nothing touches, and scans while all four fingertips hold the ball.
const FREE: usize = 100;
const HELD: std::ops::Range<usize> = 300..900;
const TURNS: usize = 4000;

/// A finger's modules, its loop and its boards.
type Finger<'a> = (Vec<usize>, Projector, Pca9685Bank<NullBus<'a>>);

/// Turns of all four loops of `allegro-grasp`, a scan of each of 15 modules waiting every time. On a bench onsets are
/// staggered; here all four are due at once.
fn hand(findings: &mut Findings) -> Result<(), Failure> {
    let broken = |e: &dyn std::fmt::Display| Failure::Input(format!("bench hand: {e}"));
    let setup = Setup::load("allegro-grasp", "allegro-hand")?;
    let tables = taxels(&setup, 1, |_| ())?;
    let layout = plan::layout(&setup.sensor.value)?;
    let sent = Cell::new(0);
    let finger = |(place, own): (Place, Setup)| {
        let projector = build(&own, 1, Levels::Dynamic(10))?;
        let prescale = projector.guard().prescale();
        let bank = Pca9685Bank::new(NullBus(&sent), &plan::boards(&own.bench.value), prescale);
        Ok((place.modules, projector, bank))
    };
    let loops = fingers(&setup).into_iter().map(finger);
    let mut loops: Vec<Finger<'_>> = loops.collect::<Result<_, Failure>>()?;
    let (mut quiet, mut onsets) = (Samples::default(), Samples::default());
    let (mut now, mut next_scan) = (Instant::ZERO, Instant::ZERO);
    for frame in (0..FREE).chain(HELD.cycle()).take(TURNS) {
        let scans = scans(&tables, &layout, frame);
        let of = |finger: &Finger<'_>| finger.0.iter().map(|m| scans[*m].clone()).collect();
        let own: Vec<Vec<Vec<[u16; 3]>>> = loops.iter().map(of).collect();
        let begun = clock::now();
        let mut begin = 0;
        for ((_, projector, bank), scans) in loops.iter_mut().zip(&own) {
            begin += usize::from(turn(projector, scans, now, bank).map_err(|e| broken(&e))?);
        }
        let us = begun.elapsed().as_secs_f64() * 1e6;
        match begin {
            _ if frame < HELD.start => {}
            0 => quiet.push(us),
            4 => onsets.push(us),
            some => return Err(broken(&format!("{some} of 4 onsets in one turn"))),
        }
        if now >= next_scan {
            next_scan = now + Duration::from_millis(10);
        }
        let due = loops.iter().map(|(_, projector, _)| projector.next());
        now = due
            .fold(next_scan, Instant::min)
            .max(now + Duration::from_micros(1));
    }
    if let Some(cause) = loops.iter().find_map(|(_, p, _)| p.guard().latched()) {
        return Err(broken(&format!(
            "a guard has stopped its finger: {cause:?}"
        )));
    }
    let case = "hand of four fingers, 15 scans in";
    findings.row(case, "default", NO_ERROR, quiet.median());
    findings.row(case, "four onsets", NO_ERROR, onsets.median());
    findings.target(case, onsets.median(), HAND_US);
    Ok(())
}

/// Stages of compression for a scan, by themselves.
struct Alone {
    baseline: Baseline,
    relative: RelativeFrame,
    compressor: Compressor,
    masked: bool,
}

impl Alone {
    /// Microseconds of a frame; none before the reference is known.
    fn frame(&mut self, scan: &Scan) -> Option<f64> {
        let ready = self.baseline.phase() == BaselinePhase::Ready
            || self.baseline.feed(scan) == BaselinePhase::Ready;
        if !ready {
            return None;
        }
        if !self.masked {
            self.baseline.mask(&mut self.relative);
            self.masked = true;
        }
        let begun = clock::now();
        let news = self.baseline.advance(scan, &mut self.relative).ok()?;
        if news || !self.compressor.repeat() {
            self.compressor.compress(&self.relative).ok()?;
        }
        Some(begun.elapsed().as_secs_f64() * 1e6)
    }
}

/// Times of turns that take a scan of every module and have nothing else to do, and of compression alone.
fn times(setup: &Setup) -> Result<(Samples, Samples), Failure> {
    let broken = |e: &dyn std::fmt::Display| Failure::Input(format!("bench skins: {e}"));
    let tables = taxels(setup, 1, |_| ())?;
    let levels = || Levels::Dynamic(10);
    let mut projector = build(setup, 1, levels())?;
    let layout = projector.layout().clone();
    let sensing = plan::plan(setup, 1, levels())?.sensing;
    let mut alone = Alone {
        baseline: Baseline::new(&layout, sensing.baseline).map_err(|e| broken(&e))?,
        relative: RelativeFrame::new(&layout),
        compressor: Compressor::new(&layout, sensing.compression).map_err(|e| broken(&e))?,
        masked: false,
    };
    let sent = Cell::new(0);
    let prescale = plan::prescale(&setup.bench.value)?;
    let mut bank = Pca9685Bank::new(NullBus(&sent), &plan::boards(&setup.bench.value), prescale);
    let (mut turns, mut compressions) = (Samples::default(), Samples::default());
    let mut scan = Scan::new(&layout);
    let frames = tables.iter().map(TaxelTable::frames).min().unwrap_or(0);
    for frame in 0..frames {
        let scans = scans(&tables, &layout, frame);
        let at = Instant::from_micros(tables[0].time_us[frame]);
        // What was due before has its turns, as on a bench: an onset 20 ms late would stop the run there.
        let mut due = projector.next();
        while due < at {
            turn(&mut projector, &[], due, &mut bank).map_err(|e| broken(&e))?;
            due = projector.next();
        }
        let begun = clock::now();
        turn(&mut projector, &scans, at, &mut bank).map_err(|e| broken(&e))?;
        let us = begun.elapsed().as_secs_f64() * 1e6;
        scan.load(at, &scans.concat()).map_err(|e| broken(&e))?;
        if let Some(own) = alone.frame(&scan) {
            turns.push(us);
            compressions.push(own);
        }
    }
    Ok((turns, compressions))
}

/// One turn of the loop: a scan of every module, then what is due; whether that is an onset.
fn turn(
    projector: &mut Projector,
    scans: &[Vec<[u16; 3]>],
    at: Instant,
    bank: &mut Pca9685Bank<NullBus<'_>>,
) -> Result<bool, String> {
    for (module, counts) in (0..).zip(scans) {
        let scan = ModuleScan::whole(module, at, counts);
        projector.push(&scan, &mut ()).map_err(|e| e.to_string())?;
    }
    let turned = projector.turn(at, bank, &mut ());
    turned.map_err(|e| format!("{e:?}"))
}

/// Counts of all taxels of every module in one frame.
fn scans(tables: &[TaxelTable], layout: &Layout, frame: usize) -> Vec<Vec<[u16; 3]>> {
    let of_module = |(table, module): (&TaxelTable, &palpate_core::skin::Module)| {
        let axes = usize::from(module.axes());
        let row = table.frame(frame).unwrap_or_default();
        let mut readings = row.chunks_exact(axes);
        let counts = |active: &bool| match active.then(|| readings.next()).flatten() {
            Some([x, y, z]) => [*x, *y, *z],
            Some([z]) => [0, 0, *z],
            _ => [0; 3],
        };
        module.active().iter().map(counts).collect()
    };
    tables.iter().zip(layout.modules()).map(of_module).collect()
}
