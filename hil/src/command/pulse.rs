//! `hil pulse`: one wire is heated once, or one motor shakes once, by the way of every run.

use std::io::{self, BufRead, IsTerminal, Write};

use palpate_core::guard::Used;
use palpate_core::schedule::{Entry, Reason};
use palpate_files::{BenchKind, Setup};
use palpate_live::host;
use palpate_live::real::refuse_stopped;
use palpate_live::views::Wanted;
use palpate_records::trace::event::AllOff;
use palpate_records::verdict::{COLUMNS, Verdict, wrapped};
use palpate_run::{Failure, Input, Keep, Outcome, stopped_by};
use serde_json::{Value, json};

use crate::cli::PulseArgs;

use super::devices::bench_of;
use super::pulse_plan::{Judged, PulsePlan};

/// The seed of the skin's noise, where it is emulated.
const SEED: u64 = 1;

/// Heats one wire of a bench once.
///
/// # Errors
/// [`Failure::Input`] for a wire that the bench does not have, and where a person did not agree; else as `hil run`.
pub fn pulse(args: &PulseArgs) -> Result<(), Failure> {
    let plan = PulsePlan::new(bench_of(args.bench.as_deref(), &args.unit)?, args)?;
    let setup = plan.pulse()?;
    if setup.bench.value.is_hardware() {
        refuse_stopped(&setup)?;
    }
    let is_wired = setup.bench.value.kind == BenchKind::Real;
    let judged = plan.judged().or_else(|refused| {
        // A run that drives has reserved the heat of seconds to come: that the bench is held is the reason to tell.
        if is_wired {
            hear(&plan)?;
        }
        Err(refused)
    })?;
    agreed(args, &plan, &judged, &setup)?;
    if is_wired {
        hear(&plan)?;
    }
    let outcome = run(&setup)?;
    let sent = Sent::new(&outcome);
    let lines = told(&plan, &judged, &sent, &outcome);
    let object = || object(&plan, &judged, &sent, &outcome, &lines.join(". "));
    args.voice.tell(object, |out| {
        lines
            .iter()
            .try_for_each(|line| writeln!(out, "{}", wrapped(line, COLUMNS)))
    })?;
    concluded(outcome, &sent)
}

/// Runs a scene to its end.
fn run(setup: &Setup) -> Result<Outcome, Failure> {
    let wanted = Wanted {
        quiet: true,
        ..Wanted::default()
    };
    host::run(setup, &Input::Scene, SEED, Keep::default(), wanted)
}

/// Listens to the skin of a bench of hardware with all outputs off: the guard stops a wire that is driven while no sensor frame
/// comes, and that stop would be latched.
fn hear(plan: &PulsePlan) -> Result<(), Failure> {
    let outcome = run(&plan.silence()?)?;
    let silent = outcome
        .summary
        .boards
        .iter()
        .all(|board| board.readings == 0);
    concluded(outcome, &Sent::default())?;
    match silent {
        false => Ok(()),
        true => Err(Failure::Device(format!(
            "no sensor frame came from the skin of {}: nothing was driven, since the guard drives nothing without one. Connect the boards and their supply, or name their layout with --layout; `hil doctor` says what the interfaces receive",
            plan.place()
        ))),
    }
}

/// Ends the command as a run that sent this demands.
fn concluded(outcome: Outcome, sent: &Sent) -> Result<(), Failure> {
    let conclusion = &outcome.summary.conclusion;
    if conclusion.verdict == Verdict::LimitExceeded {
        return Err(Failure::Check(conclusion.line()));
    }
    if let Some(failure) = outcome.failure {
        return Err(failure);
    }
    match stopped_by(&outcome.trace) {
        Some(by) if sent.entry.is_none() => Err(Failure::Stopped(format!(
            "stopped by {by} before the pulse; outputs are off"
        ))),
        _ => Ok(()),
    }
}

/// Stimuli that a run drove.
#[derive(Default)]
struct Sent {
    /// The pulse, as the guard passed it.
    entry: Option<Entry>,
    /// Onsets of wires, refused ones too.
    stimuli: usize,
    /// Time from the onset to when all outputs were known to be off, ms.
    off_ms: Option<f64>,
}

impl Sent {
    fn new(outcome: &Outcome) -> Self {
        let entries = || outcome.trace.each::<Entry>().filter(|e| e.off > e.on);
        let entry = entries().next().copied();
        let is_off = outcome.failure.is_none();
        let off = outcome.trace.each::<AllOff>().next_back();
        let since =
            |entry: Entry| Some(off?.t_us.saturating_sub(entry.at.as_micros()) as f64 * 1e-3);
        Self {
            entry,
            stimuli: entries().count(),
            off_ms: entry.filter(|_| is_off).and_then(since),
        }
    }
}

/// Words on the pulse: its length, strength and warmth.
fn what(plan: &PulsePlan, judged: &Judged, setup: &Setup) -> String {
    if let (Some(coil), Some(haptics)) = (judged.coil_k, &setup.bench.value.haptics) {
        return format!(
            "at {:.0} % of its highest level, {} V; {}",
            judged.duty * 1e2,
            haptics.full_v,
            warm(coil)
        );
    }
    let pulses = match plan.pulses {
        1 => "one pulse".to_owned(),
        n => format!("{n} pulses"),
    };
    let limits = &setup.limits.value.limits;
    let felt = match plan.felt {
        true => "the smallest that is felt in bursts, by the response of its wires",
        false => "none within the limits is known to be felt, this is the widest that they pass",
    };
    let shortened = judged.entry.reason.map_or_else(String::new, |reason| {
        format!(", which the guard has made smaller ({})", reason.word())
    });
    format!(
        "{pulses} of {:.0} us at {:.0} mA, {:.2} % of its period ({felt}{shortened}): {:.2} mJ, skin at {:.1} C at most, {:.1} C allowed",
        judged.width_us,
        setup.bench.value.drive.current_ma,
        judged.duty * 1e2,
        judged.energy_mj,
        judged.predicted.peak_c,
        limits.skin_peak_mc as f64 * 1e-3,
    )
}

/// Words on the coil of a motor.
fn warm((rise_k, most_k): (f64, f64)) -> String {
    format!("its coil {rise_k:.1} K over the air at most, {most_k:.1} K allowed")
}

/// Word for a bench: hardware where any part of it is, else emulated.
fn kind(setup: &Setup) -> &'static str {
    match setup.bench.value.is_hardware() {
        true => "hardware",
        false => "emulated",
    }
}

/// Time that the wire's channel is on, ms.
fn length_ms(entry: &Entry) -> f64 {
    entry.until.since(entry.at).as_micros() as f64 * 1e-3
}

/// Returns once the wire may be heated: by the option, or by what a person types.
fn agreed(
    args: &PulseArgs,
    plan: &PulsePlan,
    judged: &Judged,
    setup: &Setup,
) -> Result<(), Failure> {
    if args.yes {
        return Ok(());
    }
    let (will, ask, none) = match judged.coil_k {
        Some(_) => ("shake", "Shake it?", "nothing was shaken"),
        None => ("be heated", "Heat it?", "nothing was heated"),
    };
    let question = format!(
        "{} {} of {} ({}) will {will} for {:.0} ms: {}",
        plan.actuator(),
        plan.wire,
        plan.place(),
        kind(setup),
        length_ms(&judged.entry),
        what(plan, judged, setup)
    );
    if !io::stdin().is_terminal() {
        return Err(Failure::Input(format!(
            "{question}. Expected --yes: standard input is no terminal to ask at"
        )));
    }
    // On standard error: an object or a file of the result has no question in it.
    let question = wrapped(&format!("{question}."), COLUMNS);
    let asked = write!(io::stderr(), "{question}\n{ask} [y/N] ");
    asked.map_err(Failure::written("standard error"))?;
    let mut answer = String::new();
    let read = io::stdin().lock().read_line(&mut answer);
    let yes = matches!(&*answer.trim().to_lowercase(), "y" | "yes");
    match read {
        Ok(_) if yes => Ok(()),
        _ => Err(Failure::Input(none.into())),
    }
}

/// Row of the guard that the pulse leaves nearest to its limit, with the used share.
fn nearest(used: &Used) -> (&'static str, f64) {
    let heat = used
        .rows()
        .into_iter()
        .filter(|(row, _)| !is_momentary(row));
    heat.fold(
        ("", 0.0),
        |most, row| if row.1 > most.1 { row } else { most },
    )
}

/// A row that counts what is on at this moment alone.
fn is_momentary(row: &str) -> bool {
    matches!(row, "pulse" | "burst" | "burst_energy" | "supply")
}

/// Nominal width of the pulse that was sent, us; of none, that which the guard was asked for.
fn width_us(judged: &Judged, sent: &Sent) -> f64 {
    let ticks = |entry: &Entry| f64::from(entry.width().get());
    let part = |entry: &Entry| ticks(entry) / ticks(&judged.entry);
    judged.width_us * sent.entry.as_ref().map_or(1.0, part)
}

/// Sentences of a pulse that is over.
fn told(plan: &PulsePlan, judged: &Judged, sent: &Sent, outcome: &Outcome) -> Vec<String> {
    let Some(entry) = &sent.entry else {
        let (actuator, place) = (plan.actuator(), plan.place());
        let nothing = format!("{actuator} {} of {place}: nothing was sent", plan.wire);
        return vec![nothing];
    };
    let off = sent.off_ms.map_or_else(
        || "when all outputs were off is not confirmed".to_owned(),
        |ms| format!("all outputs confirmed off {ms:.0} ms after its onset"),
    );
    let felt = match (
        outcome.summary.source.words(),
        outcome.summary.felt.level_db,
    ) {
        ("emulated", Some(level)) => {
            let felt = match level.median < 0.0 {
                true => "does not feel it alone",
                false => "feels it",
            };
            format!("; the emulated wearer {felt} ({:+.1} dB)", level.median)
        }
        _ => String::new(),
    };
    let (source, length_ms) = (outcome.summary.source.words(), length_ms(entry));
    let who = format!(
        "{source}: {} {} of {}",
        plan.actuator(),
        plan.wire,
        plan.place()
    );
    let line = match judged.coil_k {
        Some(coil) => {
            let level = entry.width().duty() * 1e2;
            format!(
                "{who}: shaken at {level:.0} % of its highest level for {length_ms:.1} ms; {off}; {}{felt}",
                warm(coil)
            )
        }
        None => {
            let (row, share) = nearest(&judged.used);
            format!(
                "{who}: sent {:.0} us within {length_ms:.1} ms; {off}; heat: {row} {:.1} % of its limit{felt}",
                width_us(judged, sent),
                share * 1e2,
            )
        }
    };
    vec![line, next(plan, judged)]
}

/// Advice on the twitch to look for, and on what to check where none is seen.
fn next(plan: &PulsePlan, judged: &Judged) -> String {
    if judged.coil_k.is_some() {
        return format!(
            "Feel for a buzz of this motor, and of no other. None: check its leads, and that driver {} of the bench is its channel; `hil pulse` of its neighbours shows swapped ones; then `hil doctor`",
            plan.wire
        );
    }
    format!(
        "Look for a twitch of this wire, and of no other; one pulse alone may be too weak to feel. None: check its amplifier, supply and plug, and that output {} of the bench is its channel; `hil pulse` of its neighbours shows swapped ones; then `hil doctor`",
        plan.wire
    )
}

fn object(plan: &PulsePlan, judged: &Judged, sent: &Sent, outcome: &Outcome, line: &str) -> Value {
    let summary = &outcome.summary;
    let mut object = json!({
        "source": summary.source, "verdict": summary.conclusion.verdict, "why": summary.conclusion.why,
        "bench": summary.bench, "finger": plan.finger, plan.actuator(): plan.wire,
        "sent": sent.entry.is_some(), "stimuli": sent.stimuli, "length_ms": length_ms(&judged.entry),
        "reason": judged.entry.reason.map(Reason::word), "off_ms": sent.off_ms, "text": line,
    });
    let own = match judged.coil_k {
        Some((coil_k, _)) => json!({ "level": judged.duty, "coil_k": coil_k }),
        None => {
            let rows = judged.used.rows().into_iter();
            let rows = rows.filter(|(row, _)| !is_momentary(row));
            let used: serde_json::Map<String, Value> = rows
                .map(|(row, share)| (row.to_owned(), share.into()))
                .collect();
            json!({
                "pulses": plan.pulses, "width_us": width_us(judged, sent), "duty": judged.duty,
                "energy_mj": judged.energy_mj, "skin_c": judged.predicted.peak_c,
                "felt_by_table": plan.felt, "used": used,
            })
        }
    };
    if let (Value::Object(all), Value::Object(own)) = (&mut object, own) {
        all.extend(own);
    }
    object
}
