//! `hil calibrate`: what is felt on a bench, over all wires, fingers and people that priors and evidence allow.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use palpate_buses::signals::Signals;
use palpate_files::{
    BandFile, EvidenceFile, FileKind, Format, Loaded, Overrides, Setup, load_bench, load_evidence,
    load_priors, load_scene,
};
use palpate_run::calibrate::{Calibration, Drawn, ENOUGH, Kinds, Posterior, SCENE, Spread};
use palpate_run::{Failure, plan};
use rayon::prelude::*;
use serde_json::json;

use super::sweep::{Stopping, pool};
use crate::cli::{CalibrateArgs, Planned};
use palpate_live::output::Outputs;
use palpate_live::progress::Progress;

/// Draws, weighs and prints.
///
/// # Errors
/// [`Failure`] for files that cannot be; [`Failure::Stopped`] where a signal came first.
pub fn calibrate(args: &CalibrateArgs) -> Result<(), Failure> {
    let priors = load_priors(&args.priors)?;
    let evidence = args.evidence.iter().map(|name| load_evidence(name));
    let evidence: Vec<Loaded<EvidenceFile>> = evidence.collect::<Result<_, _>>()?;
    let mut overrides = Overrides::default();
    for set in &args.set {
        overrides.set(&format!("--set bench.{set}"), &format!("bench.{set}"))?;
    }
    let bench = load_bench(&args.bench)?;
    // The scene drives one display, which it would say of itself.
    plan::one_display(&bench)?;
    let setup = Setup::join(load_scene(SCENE)?, bench)?.with(&overrides)?;
    let outputs = Outputs::new(args.force);
    outputs.check_some(args.out.as_deref(), Format::Toml)?;
    let own = args.planned == Planned::Own;
    let calibration = Calibration::new(setup, &priors, &evidence, own, args.seed)?;
    let posterior = enough(args, &calibration)?;
    if let Some(path) = &args.out {
        let text = || band(args, path, &calibration, &posterior).text();
        outputs.write_some(Some(path), Format::Toml, text)?;
    }
    tell(args, &posterior)
}

/// The band for a file at `path`, which finds files of priors and evidence from its own folder.
fn band(
    args: &CalibrateArgs,
    path: &Path,
    calibration: &Calibration,
    posterior: &Posterior,
) -> BandFile {
    let is_here = path.parent().is_none_or(|folder| folder == Path::new(""));
    let found = |kind: FileKind, name: &str| {
        let is_found = is_here || kind.names().contains(&name);
        let absolute = || std::path::absolute(name).ok();
        let path = (!is_found).then(absolute).flatten();
        path.map_or_else(|| name.to_owned(), |path| path.display().to_string())
    };
    calibration.band(posterior, &args.priors, &args.evidence, found)
}

/// Draws until the effective sample size is enough, or no more may be drawn.
fn enough(args: &CalibrateArgs, calibration: &Calibration) -> Result<Posterior, Failure> {
    let pool = pool(args.jobs)?;
    let jobs = pool.current_num_threads();
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    let most = args.most.max(args.draws);
    let (mut drawn, mut wanted) = (Vec::new(), args.draws);
    loop {
        let from = drawn.len() as u64;
        let progress = Progress::counted("calibrate", wanted - from, "draws");
        let next = AtomicU64::new(from);
        let worker = || -> Result<Vec<(u64, Drawn)>, Failure> {
            let mut own = Vec::new();
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= wanted || signals.caught().is_some() {
                    return Ok(own);
                }
                own.push((number, calibration.drawn(number, &mut Stopping(&signals))?));
                progress.step();
            }
        };
        let workers: Vec<Result<_, Failure>> =
            pool.install(|| (0..jobs).into_par_iter().map(|_| worker()).collect());
        let mut fresh: Vec<(u64, Drawn)> = Vec::new();
        for of_one in workers {
            fresh.extend(of_one?);
        }
        if let Some(signal) = signals.caught() {
            return Err(Failure::Stopped(signal.to_owned()));
        }
        // In the order of their numbers: sums do not depend on the number of cores.
        fresh.sort_by_key(|(number, _)| *number);
        drawn.extend(fresh.into_iter().map(|(_, drawn)| drawn));
        let posterior = Posterior::new(&drawn);
        if posterior.effective >= ENOUGH || wanted >= most {
            return Ok(posterior);
        }
        // As many as this share of effective draws wants, and a tenth more.
        let share = posterior.effective / wanted as f64;
        let more = (1.1 * ENOUGH / share.max(1e-9)).ceil() as u64;
        wanted = more.clamp(wanted + 1, most.min(4 * wanted).max(wanted + 1));
    }
}

fn tell(args: &CalibrateArgs, posterior: &Posterior) -> Result<(), Failure> {
    let object = || {
        json!({
            "bench": args.bench, "scene": SCENE, "priors": args.priors, "evidence": args.evidence,
            "planned": if args.planned == Planned::Own { "own" } else { "nominal" },
            "seed": args.seed, "posterior": posterior,
        })
    };
    args.voice.tell(object, |out| {
        writeln!(
            out,
            "{} on {SCENE}: {} draws, effective sample size {:.0}",
            args.bench, posterior.draws, posterior.effective
        )?;
        writeln!(
            out,
            "{:26}{:>26}{:>8}{:>20}",
            "5 / 50 / 95 %", "level, dB", "felt", "error, mm"
        )?;
        writeln!(out, "{}", line("priors", &posterior.before))?;
        writeln!(out, "{}", line("with evidence", &posterior.after))?;
        writeln!(
            out,
            "{:26}{:>8}{:>16}{:>12}{:>12}",
            "probability", "taut", "loose < 0.3 %", "0.3 to 1 %", "> 1 %"
        )?;
        writeln!(out, "{}", shares("priors", &posterior.kinds_before))?;
        writeln!(out, "{}", shares("with evidence", &posterior.kinds_after))?;
        if posterior.effective < ENOUGH {
            writeln!(out, "{}", few(posterior))?;
        }
        Ok(())
    })
}

fn line(name: &str, spread: &Spread) -> String {
    let [low, half, high] = spread.level_db;
    let [least, middle, most] = spread.error_mm;
    format!(
        "{name:26}{:>26}{:>7.0}%{:>20}",
        format!("{low:+.1} / {half:+.1} / {high:+.1}"),
        100.0 * spread.felt,
        format!("{least:.1} / {middle:.1} / {most:.1}")
    )
}

fn shares(name: &str, kinds: &Kinds) -> String {
    let [little, some, much] = kinds.loose;
    format!(
        "{name:26}{:>8.2}{little:>16.2}{some:>12.2}{much:>12.2}",
        kinds.taut
    )
}

/// Words for too few effective draws, with what helps.
fn few(posterior: &Posterior) -> String {
    format!(
        "Only {:.0} of {} draws count, fewer than {ENOUGH:.0}: percentiles rest on few wires. --most allows more draws; wider tolerances leave more.",
        posterior.effective, posterior.draws
    )
}
