//! Bursts on one wire as a person feels them, against values that an enthalpy form computed by the midpoint rule.

use super::*;
use crate::display::solver::exact::Exact;
use crate::person::channels::{Levels, Perceiver, Person};
use palpate_core::physics::{
    Alloy, History, Mechanics, Mount, RPhase, TissueParameters, WireParameters, WireState,
};

const MS: u64 = 1_000_000;
const PERSON: Person = Person {
    vibration_um: 0.45,
    flutter_um: 5.0,
    np2_um: None,
    growth: [0.7, 1.0],
};

/// A wire on a finger, driven by pulses of this width and power.
#[derive(Clone)]
struct Case {
    wire: WireParameters,
    finger_c: f64,
    pulse: (u64, f64),
    linear: bool,
}

/// What five seconds of bursts come to; levels and motion are those of the last second.
#[derive(Debug)]
struct Seen {
    wire_c: f64,
    least_m: f64,
    u_um: f64,
    added_mpa: f64,
    skin_c: f64,
    levels: Levels,
}

fn wire(state: WireState, sag_state: WireState, sag_um: f64) -> WireParameters {
    WireParameters {
        length_m: 8e-3,
        wire_share: 1.0,
        mount: Mount {
            sag_m: sag_um * 1e-6,
            ..Mount::DEFAULT
        },
        history: History {
            state,
            sag_state,
            coldest_c: None,
        },
        ..trained()
    }
}

fn thick(wire: WireParameters) -> Case {
    Case {
        wire,
        finger_c: 33.0,
        pulse: (120_000, 7.098),
        linear: false,
    }
}

/// An alloy whose martensite forms under -25 C.
fn r_alloy(wire: WireParameters) -> WireParameters {
    WireParameters {
        alloy: Alloy {
            austenite_start_c: -9.0,
            austenite_finish_c: 1.0,
            martensite_start_c: -25.0,
            martensite_finish_c: -35.0,
            reference_stress_pa: 0.0,
            ..Alloy::LOW
        },
        reversible: 0.0,
        ..wire
    }
}

/// The default of the design: 50 um, little two-way strain.
fn thin(state: WireState) -> Case {
    let thick = wire(state, WireState::Cold, 250.0);
    Case {
        wire: WireParameters {
            diameter_m: 50e-6,
            air_h: 240.0,
            reversible: 0.0,
            mechanics: Mechanics {
                transformation_strain: 0.002,
                ..Mechanics::DEFAULT
            },
            ..thick
        },
        finger_c: 33.0,
        pulse: (100_000, 5.926),
        linear: false,
    }
}

fn built(case: &Case, tissue: &TissueParameters) -> (Exact, f64) {
    let (wire, start_c) = (&case.wire, case.finger_c);
    let mut solver = Exact::new(wire, tissue, start_c).unwrap();
    if case.linear {
        solver = solver.with_linear_bow(tissue, start_c);
    }
    let rest_m = solver.bow_m();
    (solver, rest_m)
}

fn run(case: &Case) -> Seen {
    let tissue = TissueParameters {
        body_c: case.finger_c,
        ..TissueParameters::DEFAULT
    };
    let mut case = case.clone();
    case.wire.ends_c = case.finger_c;
    let (solver, rest_m) = built(&case, &tissue);
    let mut wire = Wire::on(solver).worn(&tissue).unwrap();
    wire.keep_stretches();
    let mut perceiver = Perceiver::new(PERSON, &[(0.0, 0.0)]).unwrap();
    let mut seen = Seen {
        wire_c: 0.0,
        least_m: 1.0,
        u_um: 0.0,
        added_mpa: 0.0,
        skin_c: 0.0,
        levels: Levels::SILENT,
    };
    let (mut last, end) = (false, Nanos(5_000 * MS));
    let mut start = Nanos(MS);
    while start < end {
        if !last && start.0 >= 4_000 * MS {
            perceiver.settle();
            perceiver.onset();
            last = true;
        }
        let next = Nanos((start.0 + 117 * MS).min(end.0));
        let second = start + Nanos(15_200_000);
        for (at, watts) in [
            (start, case.pulse.1),
            (start + Nanos(case.pulse.0), 0.0),
            (second, case.pulse.1),
            (second + Nanos(case.pulse.0), 0.0),
        ] {
            wire.set_power(at, watts);
            look(&mut wire, at, rest_m, &mut seen);
        }
        // The largest displacement may come long after a pulse.
        while last && wire.now() < next {
            let at = Nanos((wire.now().0 + 100_000).min(next.0));
            look(&mut wire, at, rest_m, &mut seen);
        }
        wire.take_stretches(next, |stretch| perceiver.pass(0, stretch));
        start = next;
    }
    perceiver.settle();
    seen.levels = perceiver.felt(33.0).unwrap().levels;
    let peaks = wire.peaks(end);
    (seen.wire_c, seen.skin_c) = (peaks.wire_c, peaks.shallow_c);
    seen
}

fn look(wire: &mut Wire, at: Nanos, rest_m: f64, seen: &mut Seen) {
    seen.least_m = seen.least_m.min(wire.fraction(at));
    let u_um = (rest_m + wire.displacement_m(at)) * 1e6;
    if u_um > seen.u_um {
        seen.u_um = u_um;
        seen.added_mpa = wire.strain(at).elastic * 28e3 - 10.0;
    }
}

/// Wire, least martensite, displacement, stress beyond the bias where it is stated, skin and both levels.
type Row = (f64, f64, f64, Option<f64>, f64, f64, f64);

fn cases() -> [(&'static str, Case, Row); 8] {
    use WireState::{Cold, Passed};
    let cool = {
        let mut wire = r_alloy(wire(Passed, Passed, 250.0));
        let mut r = RPhase {
            strain: 0.002,
            ..RPhase::LOW
        };
        r.bands = Alloy {
            austenite_start_c: 33.0,
            austenite_finish_c: 43.0,
            martensite_start_c: 41.0,
            martensite_finish_c: 31.0,
            ..r.bands
        };
        wire.r_phase = Some(r);
        wire
    };
    let linear = |case: Case| Case {
        linear: true,
        ..case
    };
    [
        (
            "cold",
            linear(thick(wire(Cold, Cold, 170.0))),
            (50.049, 0.4712, 233.14, None, 35.692, 2.224, -0.199),
        ),
        (
            "cold in its bow",
            thick(wire(Cold, Cold, 170.0)),
            (50.648, 0.8115, 68.65, Some(28.99), 35.710, -3.237, -6.667),
        ),
        (
            "passed",
            linear(thick(wire(Passed, Passed, 170.0))),
            (48.927, 0.0, 46.06, None, 35.694, 6.471, 3.066),
        ),
        (
            "passed in its bow",
            thick(wire(Passed, Passed, 170.0)),
            (48.517, 0.0, 42.64, Some(14.32), 35.694, 6.418, 2.462),
        ),
        (
            "R alloy",
            thick(r_alloy(wire(Passed, Passed, 170.0))),
            (48.545, 0.0, 36.79, Some(11.82), 35.694, 5.919, 1.366),
        ),
        (
            "R alloy at 29 C",
            Case {
                finger_c: 29.0,
                ..thick(cool)
            },
            (45.260, 0.0, 73.60, Some(17.85), 31.825, 11.895, 7.368),
        ),
        (
            "thin, passed",
            thin(Passed),
            (51.252, 0.0, 56.13, Some(24.70), 34.997, 6.941, 3.463),
        ),
        (
            "thin, cold",
            thin(Cold),
            (53.142, 0.3624, 35.72, Some(14.22), 34.998, 3.277, 1.098),
        ),
    ]
}

#[test]
fn bursts_are_felt_as_computed_elsewhere() {
    let mut wrong = Vec::new();
    for (name, case, row) in cases() {
        let seen = run(&case);
        println!("{name}: {seen:?}\n    {row:?}");
        let found = [
            (seen.wire_c, row.0, 0.02),
            (seen.least_m, row.1, 1e-3),
            (seen.u_um, row.2, 0.1),
            (seen.added_mpa, row.3.unwrap_or(seen.added_mpa), 0.1),
            (seen.skin_c, row.4, 0.02),
            (seen.levels.vibration_db, row.5, 0.02),
            (seen.levels.flutter_db, row.6, 0.02),
        ];
        for (found, expected, close) in found {
            if (found - expected).abs() > close {
                wrong.push(format!("{name}: {found} for {expected}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Bursts of pulses of 183 us every 5.08 ms from cold: hottest wire, least martensite within a second, hottest skin.
fn passed(case: &Case, tissue: &TissueParameters, (bursts, pulses): (u64, u64)) -> [f64; 3] {
    let (solver, _) = built(case, tissue);
    let mut wire = Wire::on(solver);
    let (mut least, mut end) = (1.0_f64, Nanos::ZERO);
    for burst in 0..bursts {
        for pulse in 0..pulses {
            let at = Nanos(burst * 250 * MS + pulse * 5_080_000);
            wire.set_power(at, case.pulse.1);
            end = at + Nanos(183_000);
            wire.set_power(end, 0.0);
            least = least.min(wire.fraction(end));
        }
    }
    for step in 1..=1000 {
        least = least.min(wire.fraction(end + Nanos(step * MS)));
    }
    let peaks = wire.peaks(wire.now());
    [peaks.wire_c, least, peaks.shallow_c]
}

#[test]
fn a_hot_pass_does_what_was_computed_elsewhere() {
    let at = |finger_c: f64| TissueParameters {
        body_c: finger_c,
        ..TissueParameters::DEFAULT
    };
    let on = |mut case: Case, finger_c: f64| {
        case.finger_c = finger_c;
        case.wire.ends_c = finger_c;
        case
    };
    let much = |sag_um: f64| thick(wire(WireState::Cold, WireState::Cold, sag_um));
    let little = || {
        let mut case = much(250.0);
        case.wire.reversible = 0.0;
        case.wire.mechanics.transformation_strain = 0.002;
        case
    };
    for (name, case, pulses, [wire_c, least, skin_c]) in [
        ("thin", thin(WireState::Cold), 3, [71.2, 0.0, 33.7]),
        (
            "thin",
            on(thin(WireState::Cold), 29.0),
            3,
            [66.6, 0.0, 29.8],
        ),
        ("thick, 0.2 %", little(), 5, [62.5, 0.0, 34.1]),
        ("thick, 0.2 %", on(little(), 29.0), 5, [57.9, 0.0, 30.1]),
        ("thick, 1 %, deep", much(500.0), 5, [62.4, 0.005, 34.1]),
        ("thick, 1 %, tight", much(170.0), 5, [70.6, 0.37, 34.4]),
    ] {
        let found = passed(&case, &at(case.finger_c), (1, pulses));
        let close = [0.05, 0.001, 0.05];
        for ((found, expected), close) in found.iter().zip([wire_c, least, skin_c]).zip(close) {
            assert!(
                (found - expected).abs() <= close,
                "{name}: {found} for {expected}"
            );
        }
    }
    // The least heat in a wire: a burst leaves most of it martensite, and eight leave little.
    let mut least = little();
    least.wire.specific_heat = 837.0;
    least.wire.latent_heat = 24e3;
    least.pulse.1 = 1.97 * 1.97 * 2.59 * 0.6;
    let pressed = TissueParameters {
        contact_h: 1e4,
        ..TissueParameters::DEFAULT
    };
    let [once, eight] = [1, 8].map(|bursts| passed(&least, &pressed, (bursts, 5)));
    assert!(
        (once[0] - 47.7).abs() < 0.5 && (once[1] - 0.71).abs() < 0.02,
        "{once:?}"
    );
    assert!((eight[0] - 54.7).abs() < 1.0 && eight[1] < 0.2, "{eight:?}");
}
