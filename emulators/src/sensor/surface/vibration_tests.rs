//! The accelerometer against an integration of its equation, and what surfaces must show in it.

use super::super::{Explorer, Habits, Recording, SurfaceTexture};
use super::*;

const STEP_S: f64 = 1e-6;

/// Acceleration at the end of `seconds` of m x'' + c x' + k x = F sin(rate t), from rest, by small steps.
fn integrated(stiffness_n_per_mm: f64, newtons: f64, rate: f64, seconds: f64) -> f64 {
    let k = 1000.0 * stiffness_n_per_mm;
    let c = 2.0 * DAMPING * (k * MASS_KG).sqrt();
    let (mut x, mut v, mut a) = (0.0, 0.0, 0.0);
    for step in 0..(seconds / STEP_S).round() as usize {
        let t = (step + 1) as f64 * STEP_S;
        a = (newtons * (rate * t).sin() - c * v - k * x) / MASS_KG;
        v += STEP_S * a;
        x += STEP_S * v;
    }
    a
}

#[test]
fn ripples_shake_as_the_equation_says() {
    for stiffness in [0.9, 6.0, 10.7] {
        for hz in [12.0, 90.0, 400.0] {
            let rate = core::f64::consts::TAU * hz;
            let seconds = 0.5 + 0.3 / hz;
            let found = Riding::on(stiffness).shaken(0.05, rate * seconds, rate);
            let expected = integrated(stiffness, 0.05, rate, seconds);
            assert!(
                (found - expected).abs() < 0.01,
                "{stiffness} N/mm, {hz} Hz: {found} {expected}"
            );
        }
    }
}

fn texture(stiffness: f64, relief_mm: f64, wavelength_mm: f64) -> SurfaceTexture {
    SurfaceTexture {
        name: "test".into(),
        stiffness_n_per_mm: stiffness,
        relief_mm,
        wavelength_mm,
        octaves: 1.0,
        friction: 0.6,
    }
}

fn recorded(texture: &SurfaceTexture) -> Vec<Recording> {
    let mut explorer = Explorer::new(Habits::default(), None, 3).with_accelerometer();
    (0..5).map(|n| explorer.stroke(texture, n)).collect()
}

/// The second of sliding, towards the module, milli-g.
fn sliding(recording: &Recording) -> Vec<f64> {
    let second = &recording.acceleration[recording.acceleration.len() / 2..];
    second.iter().map(|a| milli_g(a[2])).collect()
}

fn mean_over(recordings: &[Recording], of: impl Fn(&[f64]) -> f64) -> f64 {
    let all = recordings.iter().map(|r| of(&sliding(r)));
    all.sum::<f64>() / recordings.len() as f64
}

fn strength(signal: &[f64]) -> f64 {
    (signal.iter().map(|a| a * a).sum::<f64>() / signal.len() as f64).sqrt()
}

/// How often the signal changes sign, its means over 3 ms, in which noise hardly counts.
fn crossings(signal: &[f64]) -> f64 {
    let sums: Vec<f64> = signal.windows(9).map(|w| w.iter().sum()).collect();
    sums.windows(2).filter(|w| w[0] * w[1] < 0.0).count() as f64
}

#[test]
fn a_rougher_surface_shakes_more_and_a_finer_one_faster() {
    let strength = |relief| mean_over(&recorded(&texture(20.0, relief, 2.0)), strength);
    let (smooth, middle, rough) = (strength(0.0), strength(0.1), strength(0.3));
    // noise alone, 4.1 counts of 3.9 mg
    assert!((smooth - 16.0).abs() < 1.0, "{smooth}");
    assert!(
        2.0 * smooth < middle && 2.0 * middle < rough,
        "{middle} {rough}"
    );
    let crossings = |wavelength| mean_over(&recorded(&texture(20.0, 0.3, wavelength)), crossings);
    let (coarse, fine) = (crossings(4.0), crossings(0.8));
    assert!(fine > 1.5 * coarse, "{coarse} {fine}");
}

#[test]
fn a_harder_surface_rings_faster_when_it_is_met() {
    let samples_up = |stiffness| {
        let recording = &recorded(&texture(stiffness, 0.0, 2.0))[0];
        let z: Vec<f64> = recording
            .acceleration
            .iter()
            .map(|a| milli_g(a[2]))
            .collect();
        let met = z.iter().position(|a| *a > 200.0).expect("an impact");
        let after = &z[met..met + 60];
        after.iter().position(|a| *a < 0.0).expect("it swings back")
    };
    let (soft, hard) = (samples_up(2.0), samples_up(100.0));
    assert!(hard < soft, "{hard} {soft}");
}

#[test]
fn an_accelerometer_changes_no_taxel_and_there_is_none_unless_asked_for() {
    let surface = texture(20.0, 0.1, 2.0);
    let with = recorded(&surface);
    let mut plain = Explorer::new(Habits::default(), None, 3);
    for recording in &with {
        let other = plain.stroke(&surface, recording.number);
        assert_eq!(other.rows, recording.rows);
        assert!(other.acceleration.is_empty());
        assert_eq!(recording.acceleration.len(), 6000);
    }
    assert_eq!(with, recorded(&surface));
}

#[test]
fn it_tells_no_more_than_its_range() {
    let mut noise = RandomStream::new(1, "noise");
    let [most, least, rest] = told([1e9, -1e9, f64::NAN], &mut noise);
    assert_eq!((most, least, rest), (4095, -4096, 0));
}
