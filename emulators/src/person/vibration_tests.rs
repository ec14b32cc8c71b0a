//! Tests of `vibration.rs`.

use super::*;

const PERSON: Person = Person {
    vibration_um: 0.2,
    flutter_um: 10.0,
    np2_um: None,
    growth: [0.9, 0.6],
};

/// Envelope of a sine that rises with a time constant until `end_s` and then falls with it, and the envelope's rate.
fn envelope(t: f64, rise_s: f64, end_s: f64) -> (f64, f64) {
    let risen = |t: f64| 1.0 - (-t / rise_s).exp();
    if t < end_s {
        return (risen(t), (1.0 - risen(t)) / rise_s);
    }
    let left = risen(end_s) * (-(t - end_s) / rise_s).exp();
    (left, -left / rise_s)
}

/// Level of the Pacinian channel for such a sine, by Runge and Kutta through the filter's own
/// equations: two resonances of quality 1 at 250 Hz, each driven by the rate of what comes before, and the leak.
fn stepped_db(hz: f64, rise_s: f64, end_s: f64) -> f64 {
    let w = core::f64::consts::TAU * 250.0;
    let omega = core::f64::consts::TAU * hz;
    let rate = |t: f64| {
        let (a, da) = envelope(t, rise_s, end_s);
        a * omega * (omega * t).cos() + da * (omega * t).sin()
    };
    // First stage and its rate, second stage and its rate, leaky energy.
    let slope = |t: f64, s: &[f64; 5]| {
        [
            s[1],
            w * rate(t) - w * s[1] - w * w * s[0],
            s[3],
            w * s[1] - w * s[3] - w * w * s[2],
            (2.0 * s[2] * s[2] - s[4]) / 0.2,
        ]
    };
    let step = 5e-6;
    let add = |s: &[f64; 5], k: &[f64; 5], by: f64| core::array::from_fn(|i| s[i] + by * k[i]);
    let (mut s, mut t, mut most) = ([0.0; 5], 0.0, 0.0_f64);
    while t < end_s + 4.0 * rise_s {
        let a = slope(t, &s);
        let b = slope(t + step / 2.0, &add(&s, &a, step / 2.0));
        let c = slope(t + step / 2.0, &add(&s, &b, step / 2.0));
        let d = slope(t + step, &add(&s, &c, step));
        for i in 0..5 {
            s[i] += step / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
        }
        t += step;
        most = most.max(s[4]);
    }
    10.0 * (most / (PERSON.vibration_um * PERSON.vibration_um)).log10()
}

#[test]
fn a_rising_sine_is_felt_as_its_filter_says() {
    for (hz, rise_s, end_s) in [(175.0, 0.03, 0.1), (235.0, 0.02, 0.05), (250.0, 0.01, 0.3)] {
        let mut feeler = Feeler::new(PERSON, &[(0.0, 0.0)]).unwrap();
        let step = 1e-3;
        let steps = ((end_s + 4.0 * rise_s) / step) as usize;
        for n in 0..steps {
            let t = (n as f64 + 0.5) * step;
            let shake = Shake {
                um: envelope(t, rise_s, end_s).0,
                hz,
                driven: true,
            };
            feeler.pass(&[shake], step);
        }
        let found = feeler.onset().unwrap().levels.vibration_db;
        let exact = stepped_db(hz, rise_s, end_s);
        assert!((found - exact).abs() < 0.3, "{hz} Hz: {found} {exact}");
    }
}

#[test]
fn a_long_sine_at_its_threshold_has_0_db() {
    let mut feeler = Feeler::new(PERSON, &[(0.0, 0.0)]).unwrap();
    let shake = Shake {
        um: 0.2,
        hz: 250.0,
        driven: true,
    };
    for _ in 0..3000 {
        feeler.pass(&[shake], 1e-3);
    }
    let felt = feeler.onset().unwrap();
    assert!(felt.levels.vibration_db.abs() < 1e-3);
    assert!((felt.seconds - 3.0).abs() < 1e-9);
    assert!((felt.skin_um - 0.4).abs() < 1e-12);
}

#[test]
fn places_are_centroids_of_energy_and_of_amplitude() {
    let mut feeler = Feeler::new(PERSON, &[(0.0, 0.0), (9.0, 3.0)]).unwrap();
    let of = |um: f64| Shake {
        um,
        hz: 200.0,
        driven: true,
    };
    feeler.pass(&[of(2.0), of(1.0)], 0.01);
    let felt = feeler.onset().unwrap();
    // Energies 4 to 1, amplitudes 2 to 1.
    assert!((felt.energy_mm.0 - 1.8).abs() < 1e-9 && (felt.energy_mm.1 - 0.6).abs() < 1e-9);
    assert!((felt.amplitude_mm.0 - 3.0).abs() < 1e-9);
    assert_eq!(feeler.onset(), None);
}

#[test]
fn two_contactors_add_3_db() {
    let level = |count: usize| {
        let places = vec![(0.0, 0.0); count];
        let mut feeler = Feeler::new(PERSON, &places).unwrap();
        let shake = Shake {
            um: 1.0,
            hz: 250.0,
            driven: true,
        };
        feeler.pass(&vec![shake; count], 0.05);
        feeler.onset().unwrap().levels.vibration_db
    };
    assert!((level(2) - level(1) - 10.0 * 2.0_f64.log10()).abs() < 1e-9);
}

#[test]
fn a_person_without_thresholds_is_refused() {
    let bad = Person {
        vibration_um: f64::NAN,
        ..PERSON
    };
    assert_eq!(Feeler::new(bad, &[]).unwrap_err().name, "vibration_um");
}
