//! How long a frame takes through the core, and a scene through everything. `docs/benchmarks.md` says what each
//! line means and what it should be.

mod clusters;
mod frames;
mod projection;
mod textbook;
mod timing;

use std::error::Error;

use palpate_core::contact::{Compressor, Settings};
use palpate_core::skin::Layout;
use palpate_hil::files::{LayoutFile, Setup, load_layout};
use palpate_hil::{plan, run};

use frames::ROUND;
use timing::{Samples, head, measure, row, time};

fn main() -> Result<(), Box<dyn Error>> {
    head()?;
    let clock = measure(1000, 20_000, |_| ());
    row("two readings of the clock, in every line", &clock, None)?;
    let load = projection::bench()?;
    let pad = sensor("uskin-4x4")?;
    stages("4x4, 12 in contact, K_C = 1", &pad, &[12], 1, None)?;
    stages("4x4, 12 in contact, K_C = 4", &pad, &[12], 4, None)?;
    let hand = sensor("allegro")?;
    // 125 taxels over 15 modules.
    let touched: Vec<usize> = (0..15).map(|m| 8 + usize::from(m % 3 == 0)).collect();
    let case = "240 taxels, 125 in contact, K_C = 4 a module";
    stages(case, &hand, &touched, 4, Some(20.0))?;
    scene()?;
    timing::note(&format!(
        "Loop: {:.1} wires driven an onset, {} stimuli changed by the guard.",
        load.stimuli, load.limited
    ))?;
    clusters::bench()
}

fn sensor(name: &str) -> Result<Layout, Box<dyn Error>> {
    match load_layout(name)?.value {
        LayoutFile::Sensor(file) => Ok(plan::layout(&file)?),
        LayoutFile::Display(_) => Err(format!("{name}: expected a sensor layout").into()),
    }
}

/// A scan through relative frame and compression, without a bus.
fn stages(
    case: &str,
    layout: &Layout,
    touched: &[usize],
    clusters: u16,
    target: Option<f64>,
) -> Result<(), Box<dyn Error>> {
    let (initialiser, scans) = frames::scans(layout, touched)?;
    let settings = Settings {
        clusters,
        exponent: 2.0,
        ..Settings::default()
    };
    let mut compressor = Compressor::new(layout, settings)?;
    let mut relative = initialiser.frame(layout);
    let wanted = touched.iter().sum::<usize>();
    let mut failure = None;
    let samples = measure(ROUND, 50 * ROUND, |i| {
        let made = initialiser
            .relative(&scans[i % ROUND], &mut relative)
            .and_then(|_| compressor.compress(&relative).map(<[_]>::len));
        match made {
            Ok(_) if relative.contacts().len() == wanted => {}
            other => failure = Some(format!("{case}: {other:?}")),
        }
    });
    match failure {
        Some(failure) => Err(failure.into()),
        None => Ok(row(case, &samples, target)?),
    }
}

/// The default scene from its files to its trace: 10 s of virtual time.
fn scene() -> Result<(), Box<dyn Error>> {
    let mut samples = Samples::default();
    for round in 0..16 {
        let (us, outcome) = time(|| -> Result<_, Box<dyn Error>> {
            let setup = Setup::load("sphere-along", "emulated")?;
            Ok(run::run(&setup, &run::Input::Scene, 1)?)
        });
        outcome?;
        if round > 0 {
            samples.push(us);
        }
    }
    row(
        "default scene, 10 s simulated, to the trace",
        &samples,
        Some(1e5),
    )?;
    Ok(())
}
