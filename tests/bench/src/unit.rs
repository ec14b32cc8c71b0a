//! Cost of a driver unit: its turns, a seal, and a stimulus by its integer rows beside the whole guard.
//!
//! Bus and network take no time here. What a microcontroller takes is counted in instructions by `ci/unit`.

use std::cell::Cell;
use std::fmt::Display;
use std::hint::black_box;
use std::time::Duration as Wall;

use palpate_core::codec::link::{HEADER, MOST, Request, TAG};
use palpate_core::guard::{Guard, HARD, Plant, WornWire};
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Duration, Instant, Ticks};
use palpate_live::clock;
use palpate_run::Failure;
use palpate_tests::unit::{Host, LetterBox, plan, unit, wires};

use crate::findings::{Findings, NO_ERROR};
use crate::timing::{Race, Samples};

/// Turns timed one by one; the first tenth warms up.
const TURNS: u64 = 20_000;
/// Samples of each method of a race.
const SAMPLES: usize = 200;
const BUDGET: Wall = Wall::from_secs(3);
/// Time of the unit's clock at its start.
const START: Instant = Instant::from_micros(1_000_000);
/// Between two plans: long enough for the unit to play each in full.
const CADENCE: Duration = Duration::from_millis(2000);
/// From a command to the onset of its stimuli.
const AHEAD: Duration = Duration::from_millis(20);

fn failed(error: impl Display) -> Failure {
    Failure::Input(format!("bench unit: {error}"))
}

/// Measures the family.
///
/// # Errors
/// A unit that plays nothing, or plays what it shall refuse.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::new("unit");
    turns(&mut findings)?;
    idle_and_forged(&mut findings)?;
    seals(&mut findings)?;
    admission(&mut findings)?;
    findings
        .words
        .push("Turns with a command are timed one by one, the clock's own cost included.".into());
    Ok(findings)
}

/// A turn that takes a command of sixteen stimuli and answers it, and the turn that begins them.
fn turns(findings: &mut Findings) -> Result<(), Failure> {
    let mut began_rows = Vec::new();
    for (method, worn) in [
        ("integer rows", None),
        ("with thermal rows", Some(WornWire::default())),
    ] {
        let answers = Cell::new(true);
        let mut unit = unit(worn, &answers).map_err(failed)?;
        let (mut host, mut letters) = (Host::default(), LetterBox::default());
        unit.start(START);
        host.knock(&mut letters);
        unit.turn(START, &mut letters);
        host.greet(&letters).map_err(failed)?;
        let (mut take, mut begin) = (Samples::default(), Samples::default());
        for n in 1..=TURNS {
            let now = START + Duration::from_micros(CADENCE.as_micros() * n);
            // The look at the registers is due now, and is not what is timed.
            unit.turn(now, &mut letters);
            let says = (unit.counts().stops, Request::Play);
            host.command(&mut letters, now, says, &plan(now + AHEAD));
            let begun = clock::now();
            unit.turn(now, &mut letters);
            let took = begun.elapsed();
            let begun = clock::now();
            unit.turn(now + AHEAD, &mut letters);
            let began = begun.elapsed();
            if n > TURNS / 10 {
                take.push(took.as_secs_f64() * 1e6);
                begin.push(began.as_secs_f64() * 1e6);
            }
            // Every stimulus ends.
            let mut ends = now + AHEAD;
            while let Some(end) = unit.guard().next_expiry() {
                ends = ends.max(end);
                unit.turn(ends, &mut letters);
            }
        }
        let counts = unit.counts();
        if u64::from(counts.applied) != 16 * TURNS {
            return Err(failed(format!(
                "expected {} stimuli begun, found {counts:?}",
                16 * TURNS
            )));
        }
        let case = "a turn with a command of 16 stimuli, and its answer";
        findings.row(case, method, NO_ERROR, take.median());
        began_rows.push((method, begin.median()));
    }
    for (method, us) in began_rows {
        let case = "the turn that begins 16 stimuli on two boards";
        findings.row(case, method, NO_ERROR, us);
    }
    Ok(())
}

/// A turn in which nothing waits, and one with a forged datagram of the greatest length.
fn idle_and_forged(findings: &mut Findings) -> Result<(), Failure> {
    let answers = Cell::new(true);
    let mut idle = unit(None, &answers).map_err(failed)?;
    let mut attacked = unit(None, &answers).map_err(failed)?;
    let (mut host, mut letters) = (Host::default(), LetterBox::default());
    let mut nothing = LetterBox::default();
    idle.start(START);
    attacked.start(START);
    host.knock(&mut letters);
    attacked.turn(START, &mut letters);
    host.greet(&letters).map_err(failed)?;
    host.command(
        &mut letters,
        START,
        (0, Request::Play),
        &plan(START + AHEAD),
    );
    // Of the session that it asks for, and of the greatest length: only the seal tells.
    let mut race = Race::default();
    race.enter(|| idle.turn(START, &mut nothing));
    race.enter(|| {
        letters.waits = Some(MOST);
        attacked.turn(START, &mut letters);
    });
    let samples = race.run(SAMPLES, BUDGET);
    let counts = attacked.counts();
    if counts.refused == 0 || counts.sessions != 0 {
        return Err(failed(format!("a forged datagram passed: {counts:?}")));
    }
    for (case, samples) in [
        "a turn with nothing",
        "a turn with a forged datagram of 1400 bytes",
    ]
    .into_iter()
    .zip(&samples)
    {
        findings.row(case, "default", NO_ERROR, samples.median());
    }
    Ok(())
}

/// Opening a seal, the copy of the datagram included: it is opened in place.
fn seals(findings: &mut Findings) -> Result<(), Failure> {
    let (mut host, mut letters) = (Host::default(), LetterBox::default());
    host.command(&mut letters, START, (0, Request::Play), &plan(START));
    let length = letters.waits.unwrap_or_default();
    let sealed = *letters.there();
    host.key().open(&mut { sealed }[..length]).map_err(failed)?;
    let mut race = Race::default();
    for length in [HEADER + TAG, length, MOST] {
        let (host, sealed) = (&host, &sealed);
        let mut buffer = [0; MOST];
        race.enter(move || {
            buffer[..length].copy_from_slice(&sealed[..length]);
            black_box(host.key().open(&mut buffer[..length]).is_ok())
        });
    }
    let methods = [
        "no body, forged".to_owned(),
        format!("16 stimuli, {length} bytes"),
        format!("{MOST} bytes, forged"),
    ];
    for (method, samples) in methods.iter().zip(race.run(SAMPLES, BUDGET)) {
        findings.row("a seal opened", method, NO_ERROR, samples.median());
    }
    Ok(())
}

/// A stimulus admitted and ended, by three guards.
fn admission(findings: &mut Findings) -> Result<(), Failure> {
    let (plant, wires) = (Plant::default(), wires());
    let last = |worn| Guard::last_word(HARD, plant, &wires, worn).map_err(failed);
    let guards = [
        ("integer rows", last(None)?),
        ("integer and thermal rows", last(Some(WornWire::default()))?),
        (
            "the whole guard of a host",
            Guard::new(HARD, plant, &wires, WornWire::default()).map_err(failed)?,
        ),
    ];
    let names = guards.each_ref().map(|g| g.0);
    let mut race = Race::default();
    for (_, mut guard) in guards {
        let mut at = START;
        race.enter(move || {
            at += Duration::from_micros(58_500);
            let until = at + Duration::from_millis(35);
            let stimulus = Stimulus {
                wire: 0,
                width: Ticks::new(15),
                peak: plant.peak,
                at,
                until,
            };
            guard.hear(at);
            black_box(guard.admit(at, Board(0), &[stimulus], |_| {}));
            black_box(guard.expire(until, Board(0)))
        });
    }
    for (name, samples) in names.into_iter().zip(race.run(SAMPLES, BUDGET)) {
        let case = "a stimulus admitted and ended, one of 16 wires";
        findings.row(case, name, NO_ERROR, samples.median());
    }
    Ok(())
}
