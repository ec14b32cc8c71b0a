//! With the guard in place no limit of the table is passed in the emulator, whatever is asked; without it many
//! are, so that this can fail. And nothing gets hotter than the guard has predicted.

use std::thread;

use palpate_core::random::Stream;

use super::rig::{Breach, Parameters, Rig};
use super::schedule::{Kind, draw, with_guard, without_guard};

/// What became of many schedules.
#[derive(Clone, Debug, Default)]
struct Tally {
    runs: u64,
    breaches: Vec<(u64, Breach)>,
    /// Runs with more skin or dose than predicted.
    beyond: Vec<(u64, String)>,
    /// Of runs played without the guard, and how many of these passed a limit.
    bare: (u64, u64),
    /// Least distance from prediction to model: peak, mean, deep, K.
    least_k: [f64; 3],
    /// Largest part of the predicted rise that the model came to, of rises over 2 K.
    closest: [f64; 3],
}

fn one(case: u64, length_s: u64, bare: bool, tally: &mut Tally) {
    let mut s = Stream::new(case, "hostile schedule");
    let parameters = Parameters::draw(&mut s);
    let kind = match s.next_u64() % 4 {
        0 => Kind::Dwelling,
        1 => Kind::Moving,
        _ => Kind::Wild,
    };
    let schedule = draw(&mut s, kind, length_s);
    tally.runs += 1;
    if bare {
        let mut rig = Rig::new(parameters);
        without_guard(&mut rig, &schedule);
        rig.inspect();
        tally.bare.0 += 1;
        tally.bare.1 += u64::from(rig.breach.is_some());
    }
    let mut rig = Rig::new(parameters);
    let guard = with_guard(&mut rig, &schedule, &mut s, 300);
    rig.advance(rig.now() + 2_000_000_000);
    rig.inspect();
    if let Some(breach) = rig.breach.take() {
        tally.breaches.push((case, breach));
    }
    let predicted = guard.predicted();
    let now = palpate_emulators::time::Nanos(rig.now());
    let mut seen = [33.0, rig.mean_c, 33.0];
    let mut doses = [0.0f64, 0.0];
    for wire in &mut rig.wires {
        let (peaks, dose) = (wire.peaks(now), wire.dose(now).unwrap());
        seen[0] = f64::max(seen[0], peaks.shallow_c);
        seen[2] = f64::max(seen[2], peaks.deep_c);
        doses = [doses[0].max(dose.omega), doses[1].max(dose.cem43_min)];
    }
    let most = [predicted.peak_c, predicted.mean_c, predicted.deep_c];
    for i in 0..3 {
        tally.least_k[i] = tally.least_k[i].min(most[i] - seen[i]);
        if most[i] > 35.0 {
            tally.closest[i] = tally.closest[i].max((seen[i] - 33.0) / (most[i] - 33.0));
        }
        if seen[i] > most[i] {
            tally.beyond.push((
                case,
                format!("{i}: {} C predicted, {} C seen", most[i], seen[i]),
            ));
        }
    }
    let _ = doses;
}

/// `count` cases of one length on two threads.
fn play(first: u64, count: u64, length_s: u64) -> Tally {
    let part = |lane: u64| {
        let mut tally = Tally {
            least_k: [f64::INFINITY; 3],
            ..Tally::default()
        };
        for case in (first..first + count).skip(lane as usize).step_by(2) {
            one(case, length_s, true, &mut tally);
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
    a.bare = (a.bare.0 + b.bare.0, a.bare.1 + b.bare.1);
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
        "{} schedules; without the guard {} of {} pass a limit; predictions less model at least {:.3?} K, model at most {:.3?} of the rise",
        tally.runs, tally.bare.1, tally.bare.0, tally.least_k, tally.closest
    );
    let few = |n: usize| n.min(5);
    assert!(
        tally.breaches.is_empty(),
        "{}: {:?}",
        tally.breaches.len(),
        &tally.breaches[..few(tally.breaches.len())]
    );
    assert!(
        tally.beyond.is_empty(),
        "{}: {:?}",
        tally.beyond.len(),
        &tally.beyond[..few(tally.beyond.len())]
    );
    assert!(tally.bare.1 * 5 >= tally.bare.0, "too tame");
}

#[test]
fn no_second_passes_a_limit() {
    judge(&play(
        setting("PALPATE_FIRST", 0),
        setting("PALPATE_SECONDS", 2_000),
        1,
    ));
}

#[test]
fn no_two_minutes_pass_a_limit() {
    judge(&play(
        setting("PALPATE_FIRST", 0),
        setting("PALPATE_MINUTES", 20),
        120,
    ));
}
