//! What must hold for every parameter and every drive.

use super::*;
use crate::display::solver::record::Peaks;
use palpate_core::physics::{
    Alloy, History, Mechanics, Mount, RPhase, TissueParameters, WireParameters, WireState,
};
use proptest::prelude::*;

prop_compose! {
    /// The stated range of parameters, with both wires.
    fn wires()(
        first in any::<bool>(), high in any::<bool>(),
        wire_share in 0.6..=1.0_f64, specific_heat in 322.0..=837.0_f64, latent_heat in 4e3..=24e3_f64,
        austenite_ratio in prop_oneof![Just(1.0), 0.7..1.3_f64],
        resistance_per_kelvin in prop_oneof![Just(0.0), -5e-4..1e-3_f64],
        bias_stress_pa in prop_oneof![Just(172e6), 0.0..40e6_f64],
        reversible in prop_oneof![Just(0.0), 0.0..0.1_f64],
        r_phase in proptest::option::of(Just(RPhase::LOW)),
    ) -> WireParameters {
        let base = if first { WireParameters::FIRST } else { WireParameters::FINAL };
        let alloy = if high { Alloy::HIGH } else { Alloy::LOW };
        WireParameters {
            alloy, wire_share, specific_heat, latent_heat, austenite_ratio,
            resistance_per_kelvin, bias_stress_pa, reversible, r_phase, ..base
        }
    }
}

prop_compose! {
    /// A wire of the stated range with a bow and a history, where it can be at rest with them.
    fn histories()(
        wire in wires(), passed in any::<bool>(), own in any::<bool>(),
        strain in 0.001..0.02_f64, stress in 0.0..30e6_f64, sag_m in 100e-6..500e-6_f64,
    ) -> WireParameters {
        let of = |passed| if passed { WireState::Passed } else { WireState::Cold };
        let with = WireParameters {
            bias_stress_pa: stress,
            mechanics: Mechanics { transformation_strain: strain, ..wire.mechanics },
            mount: Mount { sag_m, ..wire.mount },
            history: History { state: of(passed), sag_state: of(passed == own), coldest_c: None },
            ..wire
        };
        let can_be = Wire::new(&with, &TissueParameters::DEFAULT, 33.0).is_ok();
        if can_be { with } else { WireParameters { history: History::COLD, ..wire } }
    }
}

prop_compose! {
    fn tissues()(
        contact_h in 1000.0..=10_000.0_f64,
        contact_fraction in prop_oneof![Just(0.0), 0.1..=0.5_f64],
        air_c in -10.0..45.0_f64,
    ) -> TissueParameters {
        TissueParameters { contact_h, contact_fraction, air_c, ..TissueParameters::DEFAULT }
    }
}

/// Pieces of drive: how long in ns and how much current; pulses up to 5 A, steady currents that a wire
/// could survive (beyond them a wire with a rising resistance runs away and there is no state to compare).
fn drives() -> impl Strategy<Value = Vec<(u64, f64)>> {
    let pulse = (0..200_000_u64, 0.0..5.0_f64);
    let full = Just((124_000_u64, 1.97));
    let pause = prop_oneof![Just(4_955_040_u64), 0..20_000_000_u64, 0..5_000_000_000_u64];
    let steady = (0..5_000_000_000_u64, 0.0..0.25_f64);
    let piece = prop_oneof![
        2 => pulse,
        6 => full,
        6 => pause.prop_map(|span| (span, 0.0)),
        1 => steady,
    ];
    proptest::collection::vec(piece, 1..60)
}

fn run(wire: &mut Wire, drive: &[(u64, f64)], cuts: &[u64]) -> Nanos {
    let mut t = Nanos::ZERO;
    for (i, &(span, amps)) in drive.iter().enumerate() {
        wire.set_current(t, amps);
        if let Some(cut) = cuts.get(i % cuts.len().max(1)) {
            let part = span / (cut + 1);
            for k in 1..=*cut {
                wire.advance(t + Nanos(part * k));
            }
        }
        t = t + Nanos(span);
    }
    wire.advance(t);
    t
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// However time is cut, the answer is the same to 1e-9 K.
    #[test]
    fn cuts_change_nothing(
        p in histories(), s in tissues(), drive in drives(), cuts in proptest::collection::vec(1..7_u64, 1..5),
    ) {
        let mut whole = Wire::new(&p, &s, 33.0).and_then(|w| w.worn(&s)).unwrap();
        let mut cut = whole.clone();
        let end = run(&mut whole, &drive, &[]);
        run(&mut cut, &drive, &cuts);
        for (a, b) in whole.solver().nodes().iter().zip(cut.solver().nodes()) {
            prop_assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        prop_assert!((whole.fraction(end) - cut.fraction(end)).abs() < 1e-9);
        let (a, b) = (whole.displacement_m(end), cut.displacement_m(end));
        prop_assert!((a - b).abs() < 1e-12, "{a} {b}");
        let (a, b) = (whole.peaks(end), cut.peaks(end));
        prop_assert!((a.wire_c - b.wire_c).abs() < 1e-9);
        prop_assert!((a.shallow_c - b.shallow_c).abs() < 1e-9, "{a:?} {b:?}");
        prop_assert!((a.deep_c - b.deep_c).abs() < 1e-9, "{a:?} {b:?}");
    }

    /// Maxima are the same, asked for at every edge or once.
    #[test]
    fn asking_changes_nothing(p in histories(), s in tissues(), drive in drives()) {
        let mut once = Wire::new(&p, &s, 33.0).unwrap();
        let mut often = once.clone();
        let end = run(&mut once, &drive, &[]);
        let (mut t, mut windows) = (Nanos::ZERO, often.peaks(Nanos::ZERO));
        for &(span, amps) in &drive {
            often.set_current(t, amps);
            t = t + Nanos(span);
            windows.raise(&often.window_peaks(t, &Peaks::NONE));
        }
        let all = once.peaks(end);
        for other in [often.peaks(end), windows] {
            prop_assert!((all.wire_c - other.wire_c).abs() < 1e-9);
            prop_assert!((all.shallow_c - other.shallow_c).abs() < 1e-9, "{all:?} {other:?}");
            prop_assert!((all.deep_c - other.deep_c).abs() < 1e-9, "{all:?} {other:?}");
        }
    }

    /// A light copy that looks ahead answers as a whole copy does, to the bit.
    #[test]
    fn looking_ahead_is_exact(
        p in histories(), s in tissues(), drive in drives(), ahead in prop_oneof![0..20_000_000_u64, 0..5_000_000_000_u64],
    ) {
        let mut wire = Wire::new(&p, &s, 33.0).and_then(|w| w.worn(&s)).unwrap().with_dose();
        let (last, before) = drive.split_last().unwrap();
        let at = run(&mut wire, before, &[]);
        wire.set_current(at, last.1);
        let at = at + Nanos(ahead);
        let (mut light, mut whole) = (wire.ahead_with_books(), wire.clone());
        let glanced = wire.ahead().glance(at).map(f64::to_bits);
        prop_assert_eq!(glanced, wire.glance(at).map(f64::to_bits));
        prop_assert_eq!(glanced, [whole.temperature(at), whole.tissue(at).0].map(f64::to_bits));
        // As text: what ran away has no numbers, and is alike all the same.
        let books = |wire: &mut Wire| format!("{:?} {:?} {:?}", wire.peaks(at), wire.energy(at), wire.dose(at));
        prop_assert_eq!(books(&mut light), books(&mut whole));
    }

    /// Of several wires the warmest is found, however little of the others is searched.
    #[test]
    fn a_floor_hides_no_maximum_of_all(p in histories(), s in tissues(), drives in [drives(), drives(), drives()]) {
        let one = Wire::new(&p, &s, 33.0).unwrap();
        let (mut long, mut short) = (Peaks::NONE, Peaks::NONE);
        let mut pairs: Vec<_> = drives.iter().map(|drive| {
            let mut pair = [one.clone(), one.clone()];
            for wire in &mut pair {
                run(wire, drive, &[]);
            }
            pair
        }).collect();
        let end = pairs.iter().map(|[wire, _]| wire.now()).max().unwrap();
        let (mut floor, mut all, mut above) = (Peaks::NONE, Peaks::NONE, Peaks::NONE);
        pairs.iter().for_each(|[wire, _]| floor.raise(&wire.solver().peaks_floor()));
        for [wire, _] in &pairs {
            all.raise(&wire.clone().peaks(end));
            above.raise(&wire.clone().peaks_above(end, &floor));
        }
        for [_, wire] in &mut pairs {
            short.raise(&wire.window_floor(end));
        }
        for [whole, quick] in &mut pairs {
            long.raise(&whole.window_peaks(end, &Peaks::NONE));
            short.raise(&quick.window_peaks(end, &short));
        }
        let since_start = pairs.iter_mut().map(|[_, quick]| quick.peaks(end).shallow_c);
        let since_start = since_start.fold(f64::NEG_INFINITY, f64::max);
        // In electrical runaway all of them are infinite.
        let alike = |a: f64, b: f64| a.to_bits() == b.to_bits() || (a - b).abs() < 1e-9;
        for (a, b) in [(all.wire_c, above.wire_c), (all.shallow_c, above.shallow_c), (all.deep_c, above.deep_c)] {
            prop_assert!(alike(a, b), "{all:?} {above:?}");
        }
        prop_assert!(alike(long.wire_c, short.wire_c), "{long:?} {short:?}");
        prop_assert!(alike(long.shallow_c, short.shallow_c), "{long:?} {short:?}");
        prop_assert!(alike(long.deep_c, short.deep_c), "{long:?} {short:?}");
        prop_assert!(alike(long.shallow_c, since_start), "{long:?} {since_start}");
    }

    /// Every joule into the wire is in the wire, in the tissue or gone by a named way.
    #[test]
    fn energy_balances(p in histories(), s in tissues(), start in 0.0..110.0_f64, drive in drives()) {
        // At another temperature a wire may not be able to rest.
        let Ok(mut w) = Wire::new(&p, &s, start) else {
            return Ok(());
        };
        let before = w.energy(Nanos::ZERO);
        let end = run(&mut w, &drive, &[]);
        let e = w.energy(end);
        let kept = e.stored_j - before.stored_j + e.latent_j - before.latent_j;
        let gone = e.air_j + e.ends_j + e.body_j;
        let size = e.wire_j.abs() + kept.abs() + e.air_j.abs() + e.ends_j.abs() + e.body_j.abs() + 1e-3 * e.stored_j.abs() + 1e-6;
        prop_assert!((e.wire_j - kept - gone).abs() <= 1e-9 * size, "{e:?}");
        prop_assert!(e.electrical_j >= e.wire_j - 1e-12);
    }

    /// No drive, no question and no parameter in range gives anything but a number, xi is a fraction,
    /// and maxima are what they say.
    #[test]
    fn numbers_stay_numbers(
        p in histories(), s in tissues(), start in -10.0..120.0_f64, drive in drives(), idle in 0..u64::MAX / 2,
    ) {
        // At another temperature a wire may not be able to rest.
        let Ok(mut w) = Wire::new(&p, &s, start) else {
            return Ok(());
        };
        let mut t = Nanos::ZERO;
        for &(span, amps) in &drive {
            w.set_current(t, amps);
            t = t + Nanos(span.min(30_000_000));
            let c = w.temperature(t);
            prop_assert!(c.is_finite());
            prop_assert!(c <= w.peaks(t).wire_c + 1e-9);
            prop_assert!((0.0..=1.0).contains(&w.fraction(t)));
            prop_assert!(w.tissue(t).0 <= w.peaks(t).shallow_c + 1e-9);
        }
        w.set_current(t, 0.0);
        let later = t + Nanos(idle);
        prop_assert!(w.temperature(later).is_finite());
        prop_assert!(w.energy(later).body_j.is_finite());
        prop_assert!((0.0..=1.0).contains(&w.fraction(later)));
    }

    /// A wire that was only ever heated from rest cools without a rise once its current is off.
    #[test]
    fn cooling_is_monotone(p in histories(), s in tissues(), drive in drives(), gaps in proptest::collection::vec(1..50_000_000_u64, 1..40)) {
        let s = TissueParameters { air_c: s.body_c, ..s };
        let mut w = Wire::new(&p, &s, 33.0).unwrap();
        let mut t = run(&mut w, &drive, &[]);
        w.set_current(t, 0.0);
        let mut last = w.temperature(t);
        for gap in gaps {
            t = t + Nanos(gap);
            let c = w.temperature(t);
            prop_assert!(c <= last + 1e-9, "{c} after {last}");
            last = c;
        }
    }
}

/// Steady current a little over what holds the wire where it was heated to: it warms, cools past the threshold where heating
/// went over into cooling before, warms again, and is back at that threshold to 1e-10 K when somebody looks. The second turn comes
/// after one that was taken as the beginning of the search.
#[test]
fn a_turn_after_a_turn_is_found() {
    let p = WireParameters {
        specific_heat: 444.617_643_923_619_5,
        latent_heat: 23_036.157_353_156_545,
        wire_share: 0.920_422_255_777_117_8,
        austenite_ratio: 1.146_169_963_051_024_7,
        resistance_per_kelvin: 0.0,
        bias_stress_pa: 172e6,
        reversible: 0.0,
        alloy: Alloy::HIGH,
        r_phase: None,
        ..WireParameters::FINAL
    };
    let s = TissueParameters {
        contact_h: 2_349.473_990_770_66,
        contact_fraction: 0.135_955_112_349_688_57,
        air_c: 6.367_453_383_892_058,
        ..TissueParameters::DEFAULT
    };
    let drive = [
        (344_714_191, 0.193_184_843_708_569_17),
        (61_329, 4.005_630_676_203_906),
        (124_000, 1.97),
        (7_089_332, 0.0),
        (137_586_576, 0.0),
        (1_500_399_740, 0.127_700_931_632_916_65),
    ];
    let mut whole = Wire::new(&p, &s, 33.0).and_then(|w| w.worn(&s)).unwrap();
    let mut cut = whole.clone();
    run(&mut whole, &drive, &[]);
    run(&mut cut, &drive, &[59]);
    let (a, b) = (whole.solver().nodes()[0], cut.solver().nodes()[0]);
    assert!((a - b).abs() < 1e-9, "{a} {b}");
}
