//! The bow against the published figures.

use super::*;

fn bow(sag_um: f64, ends: Ends) -> Bow {
    let mount = Mount {
        sag_m: sag_um * 1e-6,
        ends,
        ..Mount::DEFAULT
    };
    let wire = WireParameters {
        mount,
        ..WireParameters::FINAL
    };
    Bow::new(&wire, &TissueParameters::DEFAULT).unwrap()
}

fn close(found: f64, expected: f64, part: f64) {
    assert!(
        (found / expected - 1.0).abs() < part,
        "{found} for {expected}"
    );
}

/// 75 um, clamped, E 28 GPa, tissue of 100 kPa: gain, and gain without skin.
#[test]
fn gains_are_the_published_ones() {
    let rows = [
        (20.0, 3.4, 6.3),
        (43.0, 5.84, 9.3),
        (75.0, 6.76, 9.0),
        (100.0, 6.49, 7.9),
        (200.0, 4.44, 4.7),
        (400.0, 2.45, 2.5),
    ];
    for (sag, gain, free) in rows {
        let bow = bow(sag, Ends::Clamped);
        close(bow.gain, gain, 0.01);
        close(bow.free_gain, free, 0.01);
        close(bow.line_n_per_m, 180.3, 0.01);
        close(bow.parting_m, -5.55e-6, 0.01);
    }
    close(bow(170.0, Ends::Clamped).gain, 5.0, 0.01);
}

#[test]
fn freer_ends_and_softer_skin_move_more() {
    let [clamped, pinned, buckled] =
        [Ends::Clamped, Ends::Pinned, Ends::Buckled].map(|ends| bow(75.0, ends));
    assert!(clamped.free_gain < pinned.free_gain && pinned.free_gain < buckled.free_gain);
    // Nothing but the geometry: half the parabola's sqrt is not in it.
    close(buckled.free_gain, 2.0 * 5e-3 / (PI * PI * 75e-6), 1e-12);
    for (modulus_pa, line) in [(30e3, 54.0), (300e3, 540.0)] {
        let tissue = TissueParameters {
            modulus_pa,
            ..TissueParameters::DEFAULT
        };
        let found = Bow::new(&WireParameters::FINAL, &tissue).unwrap();
        close(found.line_n_per_m, line, 0.01);
    }
    let thick = Bow::new(&WireParameters::FIRST, &TissueParameters::DEFAULT).unwrap();
    let thin = Bow::new(&WireParameters::FINAL, &TissueParameters::DEFAULT).unwrap();
    assert!(thick.gain < thin.gain, "the thicker wire bends less easily");
}

/// Skin, thimble and bow in balance, found without the formula: the bow goes where its own force equals the one that tissue and
/// thimble give back.
#[test]
fn a_soft_thimble_takes_its_part_of_the_motion() {
    let rigid = bow(170.0, Ends::Clamped);
    for um_per_mn in [0.0, 1.0, 10.0, 100.0] {
        let wire = WireParameters {
            mount: Mount {
                compliance_m_per_n: um_per_mn * 1e-3,
                ..Mount::DEFAULT
            },
            ..WireParameters::FINAL
        };
        let found = Bow::new(&wire, &TissueParameters::DEFAULT).unwrap();
        // Of a free bow 1 m goes; `own` is its stiffness against the middle, which the rigid seat tells.
        let free = rigid.free_gain;
        let own = 3.0 / 8.0 * rigid.line_n_per_m * rigid.gain / (free - rigid.gain);
        let (mut low, mut high) = (0.0, free);
        for _ in 0..80 {
            let skin = f64::midpoint(low, high);
            let thimble = um_per_mn * 1e-3 * rigid.line_n_per_m * skin;
            let pushes = own * (free - skin - thimble);
            let resists = 3.0 / 8.0 * rigid.line_n_per_m * skin;
            (low, high) = if pushes > resists {
                (skin, high)
            } else {
                (low, skin)
            };
        }
        close(found.gain, low, 1e-9);
        close(found.free_gain, free, 1e-12);
        close(found.parting_m, rigid.parting_m, 1e-12);
    }
}

#[test]
fn no_bow_without_a_sag_or_deeper_than_shallow() {
    for sag_m in [0.0, -1e-6, 1.1e-3, f64::NAN] {
        let mount = Mount {
            sag_m,
            ..Mount::DEFAULT
        };
        let wire = WireParameters {
            mount,
            ..WireParameters::FINAL
        };
        let error = Bow::new(&wire, &TissueParameters::DEFAULT).unwrap_err();
        assert_eq!(error.name, "mount.sag_m");
    }
}
