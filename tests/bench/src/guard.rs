//! Cost of the guard: every wire of the worn module driven at one onset.

use std::hint::black_box;

use palpate_core::contact::{LevelTable, Levels};
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Duration, Instant, Milliamps, Ticks};

use palpate_files::Setup;
use palpate_live::clock;
use palpate_run::{Failure, plan};

use crate::findings::{Findings, NO_ERROR};
use crate::timing::Samples;

/// Onsets timed; the first tenth warms up.
const ONSETS: u64 = 40_000;
/// Target for eight wires, microseconds.
const TARGET_US: f64 = 5.0;

/// Times an onset of all wires, at a width that passes and at one that is narrowed every time.
///
/// # Errors
/// Fixtures that do not fit together.
pub fn measure(findings: &mut Findings) -> Result<(), Failure> {
    let setup = Setup::load("sphere-along", "emulated")?;
    let levels = LevelTable::from_intensities(&[1.0], 1)
        .map_err(|e| Failure::Input(format!("bench guard: {e}")))?;
    let plan = plan::plan(&setup, 1, Levels::Table(levels))?;
    let wires = plan.display.wires().len() as u16;
    for (method, width) in [("default", 15), ("every stimulus limited", 160)] {
        let mut guard = plan.guard.clone();
        let (mut samples, mut read, mut limited) = (Samples::default(), Samples::default(), 0);
        for onset in 0..ONSETS {
            let at = Instant::ZERO + Duration::from_micros(58_500 * onset);
            let until = at + Duration::from_millis(35);
            let stimuli: Vec<_> = (0..wires)
                .map(|wire| Stimulus {
                    wire,
                    width: Ticks::new(width),
                    peak: Milliamps(990),
                    at,
                    until,
                })
                .collect();
            guard.hear(at);
            let begun = clock::now();
            for wire in 0..usize::from(wires) {
                black_box(guard.budget(wire, at, until));
            }
            let read_us = begun.elapsed().as_secs_f64() * 1e6;
            let begun = clock::now();
            let update = guard.admit(at, Board(0), &stimuli, |entry| {
                limited += u64::from(entry.reason.is_some());
            });
            let us = begun.elapsed().as_secs_f64() * 1e6;
            black_box(update);
            black_box(guard.expire(until, Board(0)));
            if onset >= ONSETS / 10 {
                samples.push(us);
                read.push(read_us);
            }
        }
        let case = format!("guard, {wires} wires at one onset");
        findings.row(&case, method, NO_ERROR, samples.median());
        let case = format!("guard, budgets of {wires} wires read");
        findings.row(&case, method, NO_ERROR, read.median());
        let what = format!(
            "guard, {method}, {limited} of {} stimuli limited",
            ONSETS * u64::from(wires)
        );
        findings.target(&what, samples.median(), TARGET_US);
    }
    Ok(())
}
