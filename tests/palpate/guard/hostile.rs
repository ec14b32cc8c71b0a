//! With the guard in place no limit of the table is passed in the emulator, whatever is asked; without it many
//! are, so that this can fail. And nothing gets hotter than the guard has predicted.
//!
//! `ci/hostile` plays more of them than an ordinary run.

use std::thread;

use palpate_core::random::RandomStream;

use super::rig::{Breach, Parameters, Rig};
use super::schedule::{Kind, draw, with_guard, without_guard};

/// Henriques' Omega a second, 1/s, of skin at rest, which is at 33 C: 3.1e98 exp(-6.27e5 / (8.314463 * 306.15)), rounded up.
const REST_OMEGA_PER_S: f64 = 3.29e-9;

/// What became of many schedules.
#[derive(Clone, Debug, Default)]
struct Tally {
    runs: u64,
    breaches: Vec<(u64, Breach)>,
    /// Runs with more skin or dose than predicted.
    beyond: Vec<(u64, String)>,
    /// Runs that passed a limit when played without the guard.
    bare: u64,
    /// Least distance from prediction to model: peak, mean, deep, K.
    least_k: [f64; 3],
    /// Largest part of the predicted rise that the model came to, of rises over 2 K.
    closest: [f64; 3],
}

/// Which schedules, on which wires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Load {
    Bursts,
    Textures,
    /// Bursts on loose wires.
    Loose,
    /// Bursts on chips with an external clock.
    Clocked,
}

fn one(case: u64, length_s: u64, load: Load, tally: &mut Tally) {
    let mut s = RandomStream::new(case, "hostile schedule");
    let mut parameters = Parameters::draw(&mut s);
    if load == Load::Loose {
        parameters = parameters.loose(&mut s);
    }
    if load == Load::Clocked {
        parameters = parameters.clocked(&mut s);
    }
    let kind = match s.next_u64() % 4 {
        _ if load == Load::Textures => Kind::Textured,
        0 => Kind::Dwelling,
        1 => Kind::Moving,
        _ => Kind::Wild,
    };
    let schedule = draw(&mut s, kind, length_s);
    tally.runs += 1;

    let mut rig = Rig::new(parameters, false);
    without_guard(&mut rig, &schedule);
    rig.inspect();
    tally.bare += u64::from(rig.breach.is_some());

    let mut rig = Rig::new(parameters, length_s > 10);
    let guard = with_guard(&mut rig, &schedule, &mut s, 300);
    rig.advance(rig.now() + 2_000_000_000);
    rig.inspect();
    if let Some(breach) = rig.breach.take() {
        tally.breaches.push((case, breach));
    }
    let predicted = guard.predicted();
    let most = [predicted.peak_c, predicted.mean_c, predicted.deep_c];
    let seen = rig.hottest();
    for i in 0..3 {
        tally.least_k[i] = tally.least_k[i].min(most[i] - seen[i]);
        if most[i] > 35.0 {
            tally.closest[i] = tally.closest[i].max((seen[i] - 33.0) / (most[i] - 33.0));
        }
    }
    let dose = rig.dose();
    // What is predicted ends with the last burst that was passed; skin at rest goes on collecting a trace.
    let rest = REST_OMEGA_PER_S * rig.now() as f64 * 1e-9;
    let doses = dose.omega <= predicted.omega + rest && dose.cem43_min <= predicted.cem43_min;
    if !doses || seen.iter().zip(&most).any(|(seen, most)| seen > most) {
        tally
            .beyond
            .push((case, format!("{predicted:?}, but {seen:?} and {dose:?}")));
    }
}

/// `count` cases of one length on two threads.
fn play(first: u64, count: u64, length_s: u64, load: Load) -> Tally {
    let part = |lane: u64| {
        let mut tally = Tally {
            least_k: [f64::INFINITY; 3],
            ..Tally::default()
        };
        for case in (first..first + count).skip(lane as usize).step_by(2) {
            one(case, length_s, load, &mut tally);
        }
        tally
    };
    let (mut a, b) = thread::scope(|scope| {
        let other = scope.spawn(|| part(1));
        (part(0), other.join().unwrap())
    });
    a.runs += b.runs;
    a.breaches.extend(b.breaches);
    a.beyond.extend(b.beyond);
    a.bare += b.bare;
    for i in 0..3 {
        a.least_k[i] = a.least_k[i].min(b.least_k[i]);
        a.closest[i] = a.closest[i].max(b.closest[i]);
    }
    a
}

/// A whole number from the environment.
fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name)
        .ok()
        .and_then(|v| v.parse().ok())
        .unwrap_or(default)
}

fn judge(tally: &Tally) {
    println!(
        "{} schedules, {} pass a limit without the guard; model below prediction by {:.3?} K at least, and at most {:.3?} of the predicted rise",
        tally.runs, tally.bare, tally.least_k, tally.closest
    );
    let first = |n: usize| n.min(5);
    let (passed, beyond) = (&tally.breaches, &tally.beyond);
    assert!(
        passed.is_empty(),
        "{}: {:?}",
        passed.len(),
        &passed[..first(passed.len())]
    );
    assert!(
        beyond.is_empty(),
        "{}: {:?}",
        beyond.len(),
        &beyond[..first(beyond.len())]
    );
    assert!(tally.bare * 5 >= tally.runs, "too tame to say anything");
}

#[test]
fn no_second_passes_a_limit() {
    judge(&play(
        setting("PALPATE_FIRST", 0),
        setting("PALPATE_SECONDS", 3_000),
        1,
        Load::Bursts,
    ));
}

#[test]
fn no_two_minutes_pass_a_limit() {
    judge(&play(
        setting("PALPATE_FIRST", 0),
        setting("PALPATE_MINUTES", 20),
        120,
        Load::Bursts,
    ));
}

/// Loose wires take up and give off latent heat around the skin's own temperature.
#[test]
fn no_loose_wire_passes_a_limit() {
    let first = setting("PALPATE_FIRST", 0);
    judge(&play(first, setting("PALPATE_LOOSE", 600), 1, Load::Loose));
    judge(&play(first, 4, 120, Load::Loose));
}

/// An external clock of a stated tolerance is anywhere within it; fewer pulses are booked.
#[test]
fn no_external_clock_passes_a_limit() {
    let first = setting("PALPATE_FIRST", 0);
    let count = setting("PALPATE_CLOCKED", 600);
    judge(&play(first, count, 1, Load::Clocked));
    judge(&play(first, 4, 120, Load::Clocked));
}

/// Textures ask period by period: the guard sees hundreds of stimuli a second on every wire.
#[test]
fn no_texture_passes_a_limit() {
    let first = setting("PALPATE_FIRST", 0);
    judge(&play(
        first,
        setting("PALPATE_TEXTURED", 120),
        3,
        Load::Textures,
    ));
    judge(&play(first, 4, 60, Load::Textures));
}
