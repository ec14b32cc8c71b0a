//! The loop on skins that are no uSkin module, beside what compression alone costs on the same readings.

use std::cell::Cell;

use palpate_core::contact::{Compressor, Levels};
use palpate_core::driver::Pca9685Bank;
use palpate_core::projector::Projector;
use palpate_core::skin::{Baseline, BaselinePhase, Layout, ModuleScan, RelativeFrame, Scan};
use palpate_core::units::Instant;
use palpate_files::Setup;
use palpate_hil::clock;
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
    Ok(())
}

/// What compression does with a scan, by itself.
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

/// Times of turns that take a scan of every module, and of compression alone.
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

/// One turn of the loop: a scan of every module, then what is due.
fn turn(
    projector: &mut Projector,
    scans: &[Vec<[u16; 3]>],
    at: Instant,
    bank: &mut Pca9685Bank<NullBus<'_>>,
) -> Result<(), String> {
    for (module, counts) in (0..).zip(scans) {
        let scan = ModuleScan::whole(module, at, counts);
        projector.push(&scan, &mut ()).map_err(|e| e.to_string())?;
    }
    let turned = projector.turn(at, bank, &mut ());
    turned.map(|_| ()).map_err(|e| format!("{e:?}"))
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
