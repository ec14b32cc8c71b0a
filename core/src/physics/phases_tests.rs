//! The law against published values, and what holds for every history.

use super::super::{
    Alloy, Bow, Curve, History, Mechanics, Mount, RPhase, SHARES, TissueParameters, WireParameters,
};
use super::*;
use proptest::prelude::*;

const COLD: History = History::COLD;
const PASSED: History = History {
    state: WireState::Passed,
    sag_state: WireState::Passed,
    coldest_c: None,
};

fn wire(history: History, sag_um: f64) -> WireParameters {
    WireParameters {
        length_m: 8e-3,
        mount: Mount {
            sag_m: sag_um * 1e-6,
            ..Mount::DEFAULT
        },
        history,
        reversible: 0.02,
        mechanics: Mechanics {
            transformation_strain: 0.01,
            ..Mechanics::DEFAULT
        },
        ..WireParameters::FINAL
    }
}

/// A bow that gives way at once: the stress is the bias stress.
fn constant(wire: &WireParameters, count: usize) -> Law {
    let bow = Bow::new(wire, &TissueParameters::DEFAULT).unwrap();
    let mut curve = Curve::new(&bow, wire);
    curve.pieces.truncate(1);
    let piece = &mut curve.pieces[0];
    (piece.high, piece.stiffness_pa, piece.stress_pa) = (f64::INFINITY, 0.0, 0.0);
    piece.tight = false;
    Law::with_shares(wire, curve, 33.0, count).unwrap()
}

/// The strain as it is written down, with the product of martensite and temperature.
fn plain_strain(law: &Law, [m, r]: [f64; 2], t: f64) -> f64 {
    (law.expansion + law.expansion_m * m) * (t - law.rest_c) + law.strain_m * m + law.strain_r * r
}

#[test]
fn fractions_and_strain_at_rest_are_the_published_ones() {
    let rows = [
        (46.1, 0.8582, 0.0192, 8695.8, 0.1218),
        (33.0, 0.8759, 0.1218, 8880.9, 0.1218),
        (50.0, 0.4760, 0.0, 4911.4, 0.0),
        (40.0, 0.4797, 0.2917, 5151.0, 0.5040),
        (36.0, 0.4877, 0.4877, 5391.4, 0.5040),
        (60.0, 0.0, 0.0, 297.0, 0.0),
        (33.0, 0.0177, 0.9800, 1157.1, 0.9800),
        (43.0, 0.0, 0.4573, 567.3, 0.4573),
        (38.0, 0.0077, 0.7513, 883.3, 0.7513),
        (25.0, 0.3980, 0.6020, 4508.0, 0.6020),
        (22.0, 0.6920, 0.3080, 7140.5, 0.3080),
        (46.0, 0.6720, 0.0612, 6885.8, 0.1633),
    ];
    let wire = wire(COLD, 170.0);
    let (law, single) = (constant(&wire, SHARES), constant(&wire, 1));
    let (mut phases, mut one) = (Phases::rest(&law).unwrap(), Phases::rest(&single).unwrap());
    for (t, m, r, ppm, single_r) in rows {
        phases.walk(&law, t);
        one.walk(&single, t);
        let found = phases.fractions(t);
        let strain = plain_strain(&law, found, t) * 1e6;
        assert!((found[0] - m).abs() < 1e-4, "{t}: {found:?}");
        assert!((found[1] - r).abs() < 1e-4, "{t}: {found:?}");
        assert!((strain - ppm).abs() < 0.1, "{t}: {strain} for {ppm}");
        let straight = (phases.strain() + law.rest_strain) * 1e6;
        assert!((straight - strain).abs() < 0.3, "{t}: {straight}, {strain}");
        let [_, other] = one.fractions(t);
        assert!((other - single_r).abs() < 1e-4, "{t}: {other}");
    }
}

/// The published values are of a curve whose pieces may lie 0.05 um beside the bow.
#[test]
fn a_wire_without_martensite_pulls_its_bow_as_published() {
    let r_alloy = WireParameters {
        alloy: Alloy {
            austenite_start_c: -9.0,
            austenite_finish_c: 1.0,
            martensite_start_c: -25.0,
            martensite_finish_c: -35.0,
            reference_stress_pa: 0.0,
            ..Alloy::LOW
        },
        reversible: 0.0,
        ..wire(PASSED, 170.0)
    };
    let law = Law::new(&r_alloy, &TissueParameters::DEFAULT, 33.0).unwrap();
    let mut phases = Phases::rest(&law).unwrap();
    let [m, r] = phases.fractions(33.0);
    assert!(m <= 0.0 && (r - 1.0).abs() < 1e-15);
    phases.walk(&law, 42.0);
    let [m, r] = phases.fractions(42.0);
    let kappa = law.curve.pieces[phases.piece].stiffness_pa * 1e-9;
    let found = [
        (r, 0.5919, 3e-4),
        (phases.strain() * 1e6, -309.1, 0.3),
        (phases.stress_pa(&law, 42.0) * 1e-6, 13.787, 0.03),
        (phases.u_m(&law, 42.0) * 1e6, 13.823, 0.05),
        // Of the piece there, which is 8 um long.
        (kappa, 13.14, 0.3),
        (phases.line_on().strain * 1e6, -81.83, 0.3),
    ];
    assert!(m <= 0.0);
    for (found, expected, close) in found {
        assert!((found - expected).abs() < close, "{found} for {expected}");
    }
    // What holds without tables: the play, the strain and the bow's own balance.
    let stress = phases.stress_pa(&law, 42.0);
    assert!((r - (47.0 - 42.0 + stress / 15e6) / 10.0).abs() < 1e-12);
    assert!((phases.strain() - (11e-6 * 9.0 + 1e-3 * (r - 1.0))).abs() < 1e-15);
}

/// An hour of bursts, or of rest in a changing room, and a pass: nothing but the history is left.
#[test]
fn nothing_drifts() {
    for sag_um in [170.0, 500.0] {
        let wire = wire(COLD, sag_um);
        let law = Law::new(&wire, &TissueParameters::DEFAULT, 33.0).unwrap();
        let mut phases = Phases::rest(&law).unwrap();
        phases.walk(&law, 120.0);
        phases.walk(&law, 33.0);
        let passed = phases;
        for n in 0..31_000_u32 {
            phases.walk(&law, 35.0 + 14.0 * f64::from(n % 17) / 17.0);
            phases.walk(&law, 32.2);
        }
        // What a bow pulls back to martensite at rest goes with another pass.
        phases.walk(&law, 120.0);
        phases.walk(&law, 33.0);
        assert!((phases.strain() - passed.strain()).abs() < 1e-15);
        for (a, b) in phases.parts.iter().zip(&passed.parts) {
            assert!((a.m - b.m).abs() < 1e-12 && (a.x - b.x).abs() < 1e-11);
        }
        phases.walk(&law, COLDEST_C);
        phases.walk(&law, 33.0);
        let cold = Phases::rest(&law).unwrap();
        assert!((phases.strain() - cold.strain()).abs() < 1e-15);
        let bits = |phases: &Phases| phases.fractions(33.0).map(f64::to_bits);
        assert_eq!(bits(&phases), bits(&cold));
    }
}

#[test]
fn a_rest_that_cannot_be_is_refused_by_name() {
    let of = |state, sag_state, sag_um, (mpa_k, strain_m)| {
        let history = History {
            state,
            sag_state,
            coldest_c: None,
        };
        let mut wire = wire(history, sag_um);
        wire.alloy = Alloy {
            stress_per_kelvin: mpa_k * 1e6,
            ..wire.alloy.under(0.0)
        };
        wire.mechanics.transformation_strain = strain_m;
        if strain_m > 0.01 {
            wire.r_phase = None;
        }
        let law = Law::new(&wire, &TissueParameters::DEFAULT, 33.0);
        let rest = law.and_then(|law| {
            let rest = Phases::rest(&law)?;
            Ok((rest.stress_pa(&law, 33.0), rest.fractions(33.0)[0]))
        });
        rest.map_err(|e| e.name)
    };
    use WireState::{Cold, Passed};
    assert_eq!(of(Cold, Passed, 170.0, (7.0, 0.01)), Err("bias_stress_pa"));
    // Bands that stress hardly moves: nothing gives way.
    assert_eq!(of(Passed, Cold, 20.0, (100.0, 0.03)), Err("mount.sag_m"));
    let (cold_pa, _) = of(Cold, Cold, 170.0, (7.0, 0.01)).unwrap();
    assert!((cold_pa - 10e6).abs() < 100.0);
    // A slack of 1114 ppm for a strain of 8800: the wire pulls tight, and martensite returns.
    let (passed_pa, returned) = of(Passed, Cold, 170.0, (7.0, 0.01)).unwrap();
    assert!(
        passed_pa > 3.0 * cold_pa && returned > 0.2,
        "{passed_pa} {returned}"
    );
}

prop_compose! {
    fn wires()(
        strain_m in 0.0..0.03_f64, part in 0.0..=1.0_f64, sag_um in 43.0..600.0_f64,
        stress in prop_oneof![0.0..60e6_f64, 0.0..=200e6_f64],
        slope_m in 3e6..20e6_f64, slope_r in 3e6..20e6_f64, reversible in prop_oneof![Just(0.0), 0.0..0.3_f64],
        thick in 50.0..100.0_f64, [passed, sag_passed, r] in any::<[bool; 3]>(),
        coldest_c in proptest::option::of(-60.0..60.0_f64),
    ) -> WireParameters {
        let of = |passed| if passed { WireState::Passed } else { WireState::Cold };
        let history = History { state: of(passed), sag_state: of(sag_passed), coldest_c };
        let mut wire = wire(history, sag_um);
        wire.diameter_m = thick * 1e-6;
        wire.mechanics.transformation_strain = strain_m;
        if strain_m > 0.01 {
            wire.r_phase = None;
        }
        wire.bias_stress_pa = stress;
        wire.reversible = reversible;
        wire.alloy = Alloy { stress_per_kelvin: slope_m, ..wire.alloy.under(0.0) };
        let bands = Alloy { stress_per_kelvin: slope_r, ..RPhase::LOW.bands };
        let play = RPhase { bands, strain: strain_m * part, ..RPhase::LOW };
        wire.r_phase = r.then_some(play);
        wire
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Over random histories and temperatures, and the stresses of random bows: every share and every sum in [0, 1], no step
    /// where an event is, plays on or between their branches, and heat that warms.
    #[test]
    fn phases_share_the_wire(wire in wires(), turns in proptest::collection::vec(-60.0..160.0_f64, 1..40)) {
        // Only strains that would make the temperature jump are refused.
        let law = match Law::new(&wire, &TissueParameters::DEFAULT, 33.0) {
            Err(e) => {
                prop_assert_eq!(e.name, "r_phase.strain");
                return Ok(());
            }
            Ok(law) => law,
        };
        let mut phases = Phases::through(&law, law.history.state, law.history.coldest_c);
        for to in turns {
            let up = to > phases.at_c;
            phases.commit(&law, phases.at_c, up);
            let mut events = 0;
            loop {
                let line = phases.line;
                let event = if up { line.high.min(to) } else { line.low.max(to) };
                let before = (phases.strain_at(event), phases.stress_pa(&law, event), phases.fractions(event));
                prop_assert!(wire.heat_capacity() + line.latent > 0.0, "{line:?}");
                prop_assert!(if up { event >= phases.at_c } else { event <= phases.at_c }, "{line:?}");
                phases.commit(&law, event, up);
                let [m, r] = phases.sums(&law);
                prop_assert!(m >= -1e-12 && r >= -1e-12 && m + r <= 1.0 + 1e-12, "{m} {r}");
                let [m, r] = phases.fractions(event);
                prop_assert!(m >= 0.0 && r >= 0.0 && m + r <= 1.0, "{m} {r}");
                let after = phases.sums(&law);
                prop_assert!((before.2[0] - after[0]).abs() < 1e-10 && (before.2[1] - after[1]).abs() < 1e-10);
                prop_assert!((before.0 - phases.strain()).abs() < 1e-12);
                prop_assert!((before.1 - phases.stress_pa(&law, event)).abs() < 1.0);
                let [theta_m, theta_r] = phases.thetas(&law);
                for (share, part) in law.shares.iter().zip(&phases.parts) {
                    within(&share.band, part.m, theta_m)?;
                    let r = phases.rho.min(1.0 - part.m);
                    prop_assert!((0.0..=1.0).contains(&r) && r + part.m <= 1.0, "{r} {}", part.m);
                }
                within(&law.r, phases.rho, theta_r)?;
                let piece = &law.curve.pieces[phases.piece];
                prop_assert!(phases.strain > piece.low - 1e-11 && phases.strain < piece.high + 1e-11);
                events += 1;
                prop_assert!(events < 2000, "no end of events");
                if event.to_bits() == to.to_bits() {
                    break;
                }
            }
        }
    }
}

/// Whether a play stands on its branches or between them.
fn within(band: &Band, p: f64, theta: f64) -> Result<(), TestCaseError> {
    prop_assert!((0.0..=1.0).contains(&p), "{p}");
    prop_assert!(
        p <= 0.0 || theta <= band.up(p) + 1e-8,
        "{p} at {theta}: {band:?}"
    );
    prop_assert!(
        p >= 1.0 || theta >= band.down(p) - 1e-8,
        "{p} at {theta}: {band:?}"
    );
    Ok(())
}
