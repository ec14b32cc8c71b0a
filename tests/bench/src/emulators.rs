//! Emulated benches against the wall clock: whole runs, both passes, with everything a run writes but the files.

use std::cell::RefCell;
use std::time::Duration;

use palpate_files::Setup;
use palpate_run::{Failure, Input, run};

use crate::findings::{Findings, NO_ERROR};
use crate::timing::Race;

/// Whole runs of each scene; the hand is to run at least a hundred times faster than real time on one core.
const RUNS: usize = 15;

/// Scenes and benches: from one module of 16 taxels to a hand of 240 on four buses with eight wires, then several
/// displays of eight wires each.
const RUN: [(&str, &str); 6] = [
    ("sphere-along", "emulated"),
    ("allegro-one-bus", "emulated"),
    ("allegro-one-bus-overwrite", "emulated"),
    ("allegro-four-buses", "emulated"),
    ("allegro-grasp", "allegro-hand"),
    ("ten-fingers", "ten-fingers"),
];

/// Times every scene of [`RUN`].
///
/// # Errors
/// [`Failure`] for a scene that does not run.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::new("emulators");
    let failed = RefCell::new(None);
    let setups = RUN.map(|(scene, bench)| Setup::load(scene, bench));
    let setups = setups.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut race = Race::default();
    for setup in &setups {
        race.enter(|| {
            let outcome = run(setup, &Input::Scene, 1);
            outcome.map_err(|e| {
                failed.borrow_mut().get_or_insert(e);
            })
        });
    }
    let samples = race.run(RUNS, Duration::from_secs(60));
    if let Some(failure) = failed.into_inner() {
        return Err(failure);
    }
    for (((name, bench), setup), times) in RUN.iter().zip(&setups).zip(&samples) {
        findings.row(
            &format!("a whole run of {name} on {bench}, calibration included"),
            "default",
            NO_ERROR,
            times.median(),
        );
        let faster = |us: f64| setup.scene.value.length_s * 1e6 / us;
        findings.words.push(format!(
            "{name} on {bench}: {:.0} times faster than real time (median of {}; {:.0} to {:.0})",
            faster(times.median()),
            times.len(),
            faster(times.quantile(1.0)),
            faster(times.quantile(0.0)),
        ));
    }
    findings.words.push(
        "targets: allegro-four-buses and allegro-hand at least 100 times, ten-fingers 40, on one core (`taskset -c 0`)"
            .into(),
    );
    Ok(findings)
}
