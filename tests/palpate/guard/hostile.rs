//! With the guard in place no limit of the table is passed in the emulator, whatever is asked; without it many
//! are, so that this can fail. And nothing gets hotter than the guard has predicted.
//!
//! `ci/hostile` plays more of them than an ordinary run.

use std::collections::BTreeMap;
use std::thread;

use palpate_core::guard::WornWire;
use palpate_core::random::RandomStream;
use palpate_core::units::Milliamps;

use super::kernel::sized;
use super::rig::{Breach, Parameters, Rig};
use super::schedule::{Kind, Wish, draw, guard_of, through, with_guard, without_guard};

/// Henriques' Omega a second, 1/s, of skin at rest, rounded up.
fn rest_omega_per_s(rest_c: f64) -> f64 {
    3.11e98 * libm::exp(-6.27e5 / (8.314463 * (rest_c + 273.15)))
}

/// Wires that are guarded by rows of their own, um and mm.
const SIZES: [(f64, f64); 5] = [
    (50.0, 3.0),
    (50.0, 8.0),
    (75.0, 5.0),
    (75.0, 8.0),
    (100.0, 8.0),
];
/// Fingers at rest that they lie on, degrees C.
const RESTS_C: [f64; 2] = [29.0, 36.0];

/// Wires of each size: loose ones that are cold, loose ones after a hot pass, and taut ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Cold,
    Passed,
    Taut,
}

impl State {
    const ALL: [Self; 3] = [Self::Cold, Self::Passed, Self::Taut];

    /// Brings drawn wires into this state.
    fn applied(self, drawn: Parameters, s: &mut RandomStream) -> Parameters {
        match self {
            Self::Cold => drawn.loose(s),
            Self::Passed => drawn.passed(s),
            Self::Taut => drawn,
        }
    }
}

/// Part of a limit of heat or power from which on a schedule has come close to it. A burst takes at most three quarters of
/// what is left, so few come closer.
const CLOSE: f64 = 0.7;

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
    /// Runs that came close to a limit of heat or power behind the guard.
    close: u64,
    /// Largest part of each limit of heat and power that was reached behind the guard.
    reached: BTreeMap<&'static str, f64>,
    /// Hottest tissue at 0.1 mm, its mean over 10 s, tissue at 0.4 mm, and wire, degrees C.
    hottest_c: [f64; 4],
}

impl Tally {
    fn empty() -> Self {
        Self {
            least_k: [f64::INFINITY; 3],
            ..Self::default()
        }
    }

    /// Adds what became of other schedules.
    fn join(&mut self, other: Self) {
        self.runs += other.runs;
        self.breaches.extend(other.breaches);
        self.beyond.extend(other.beyond);
        self.bare += other.bare;
        self.close += other.close;
        for i in 0..3 {
            self.least_k[i] = self.least_k[i].min(other.least_k[i]);
            self.closest[i] = self.closest[i].max(other.closest[i]);
        }
        for (mine, other) in self.hottest_c.iter_mut().zip(other.hottest_c) {
            *mine = mine.max(other);
        }
        for (limit, part) in other.reached {
            let mine = self.reached.entry(limit).or_default();
            *mine = mine.max(part);
        }
    }
}

/// Which schedules, on which wires.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Load {
    Bursts,
    Textures,
    /// Bursts on loose wires.
    Loose,
    /// Bursts on chips with an external clock.
    Clocked,
    /// Bursts on a wire of some um and mm, on a finger of some degrees C at rest, every third in the worst corner.
    Sized((f64, f64), State, f64),
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
    if let Load::Sized((um, mm), state, rest_c) = load {
        if case.is_multiple_of(3) {
            parameters = parameters.in_the_worst_corner(&mut s);
        }
        parameters = state.applied(parameters.sized(sized(um, mm), rest_c), &mut s);
    }
    let rest_c = parameters.skin.body_c;
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
    tally.close += u64::from(rig.reached.values().any(|part| *part > CLOSE));
    let predicted = guard.predicted();
    let most = [predicted.peak_c, predicted.mean_c, predicted.deep_c];
    let seen = rig.hottest();
    for i in 0..3 {
        tally.least_k[i] = tally.least_k[i].min(most[i] - seen[i]);
        if most[i] > rest_c + 2.0 {
            let part = (seen[i] - rest_c) / (most[i] - rest_c);
            tally.closest[i] = tally.closest[i].max(part);
        }
    }
    let [peak_c, mean_c, deep_c] = seen;
    tally.join(Tally {
        hottest_c: [peak_c, mean_c, deep_c, rig.hottest_wire()],
        reached: std::mem::take(&mut rig.reached),
        ..Tally::empty()
    });
    let dose = rig.dose();
    // What is predicted ends with the last burst that was passed; skin at rest goes on collecting a trace.
    let rest = rest_omega_per_s(rest_c) * rig.now() as f64 * 1e-9;
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
        let mut tally = Tally::empty();
        for case in (first..first + count).skip(lane as usize).step_by(2) {
            one(case, length_s, load, &mut tally);
        }
        tally
    };
    let (mut a, b) = thread::scope(|scope| {
        let other = scope.spawn(|| part(1));
        (part(0), other.join().unwrap())
    });
    a.join(b);
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
    println!(
        "    {} come close to a limit behind it; hottest {:.2?} C; largest parts {:.3?}",
        tally.close, tally.hottest_c, tally.reached
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

/// Each wire has rows made for it, on colder and on warmer fingers, whatever state it is in. A guard that refuses everything
/// passes no limit either: of each size a quarter of the schedules come close to one.
#[test]
fn no_wire_of_another_size_passes_a_limit() {
    let first = setting("PALPATE_FIRST", 0);
    let (count, long) = (
        setting("PALPATE_SIZED", 20),
        setting("PALPATE_SIZED_LONG", 2),
    );
    for size in SIZES {
        let mut all = Tally::empty();
        for state in State::ALL {
            for rest_c in RESTS_C {
                println!("{size:?} um, mm, {state:?}, on {rest_c} C:");
                for (count, length_s) in [(count, 1), (long, 30)] {
                    let tally = play(first, count, length_s, Load::Sized(size, state, rest_c));
                    judge(&tally);
                    all.join(tally);
                }
            }
        }
        println!("{size:?} um, mm: {all:.3?}");
        assert!(all.close * 4 >= all.runs, "{} of {}", all.close, all.runs);
    }
}

/// A bench in the worst corner of the range after a contact that dwells on one wire for 13 s, as a guard of some wire and
/// finger lets it.
fn dwells((um, mm): (f64, f64), state: State, rest_c: f64, worn: Option<WornWire>) -> Rig {
    let mut s = RandomStream::new(1, "dwelling");
    let drawn = Parameters::draw(&mut s).in_the_worst_corner(&mut s);
    let drawn = state.applied(drawn.sized(sized(um, mm), rest_c), &mut s);
    let parameters = Parameters {
        oscillator_hz: 23_000_000,
        current: Milliamps(1970),
        supply: Milliamps(4000),
        ..drawn
    };
    let bursts = (0..220).map(|n| 1_000 + n * 58_500);
    let pulses = |at: u64| Wish::Pulses {
        wires: 1,
        width: 148,
        until_us: at + 35_000,
    };
    let schedule = bursts.map(|at| (at, pulses(at))).collect();
    let mut rig = Rig::new(parameters, false);
    let guard = guard_of(&rig, worn.unwrap_or(parameters.worn()));
    through(guard, &mut rig, &schedule, &mut s, 0);
    rig.inspect();
    rig
}

/// Rows that refuse everything would be no rows: in the worst corner each wire comes close to a limit of tissue, or has most
/// of the power that any wire may have for 10 s, whatever state it is in.
#[test]
fn a_contact_that_dwells_comes_close_to_a_limit_and_passes_none() {
    for size in SIZES {
        for state in State::ALL {
            for rest_c in RESTS_C {
                let mut rig = dwells(size, state, rest_c, None);
                let [peak_c, mean_c, _] = rig.hottest();
                let of = |limit: &str| rig.reached[limit];
                let parts = [
                    of("skin at 0.1 mm"),
                    of("skin mean"),
                    of("wire power over 10 s"),
                ];
                println!(
                    "{size:?} um, mm, {state:?}, on {rest_c} C: {peak_c:.2} C, mean {mean_c:.2} C; parts {parts:.3?}"
                );
                assert_eq!(rig.breach, None);
                assert!(parts.iter().any(|part| *part > CLOSE));
            }
        }
    }
}

/// A guard of the final module's wire on a usual finger is no guard of a short thin wire, nor of a warmer finger.
#[test]
fn a_guard_is_one_of_its_own_wire_and_finger() {
    for (size, rest_c) in [
        ((50.0, 3.0), 33.0),
        ((50.0, 3.0), 36.0),
        ((75.0, 5.0), 36.0),
    ] {
        let [mut own, mut other] =
            [None, Some(WornWire::default())].map(|worn| dwells(size, State::Taut, rest_c, worn));
        println!(
            "{size:?} um, mm on {rest_c} C: {:.2?} C; by the final wire's guard {:.2?} C",
            own.hottest(),
            other.hottest()
        );
        assert_eq!(own.breach, None);
        assert!(other.breach.is_some(), "{size:?} on {rest_c} C");
    }
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
