//! The guard's rows of heat against the full model of the very wire that is guarded: nowhere below it, and hardly above the
//! linear programme's own rows for that wire.

use palpate_core::guard::{Guard, HARD, Memory, Plant, WireMemory, WornWire};
use palpate_core::physics::TissueParameters;
use palpate_core::random::RandomStream;
use palpate_core::units::Instant;

use super::kernel::{DECAYS, corners, envelope, fit, sized, sum, times};
use super::rig::pick;
use super::schedule::display;
use super::table::{LATENT_K, table_rates};

/// What the guard expects of a joule in a wire at each of some times, K/J, at 0.1 and at 0.4 mm. A memory whose decays have
/// faded so long says it.
fn rows(diameter_um: f64, length_mm: f64, times: &[f64]) -> [Vec<f64>; 2] {
    let wire = sized(diameter_um, length_mm);
    let worn = WornWire::new(&wire, &TissueParameters::DEFAULT);
    let mut guard = Guard::new(HARD, Plant::default(), &display(), worn).unwrap();
    let rates = table_rates();
    let mut at = |t: &f64| {
        let warm = WireMemory {
            energy_j: rates.map(|rate| libm::exp(-rate * t)),
            ..WireMemory::default()
        };
        let memory = Memory {
            wires: [warm].into(),
            ..Memory::default()
        };
        guard.remember(&memory, Instant::ZERO).unwrap();
        let used = guard.used(Instant::ZERO);
        let left = |limit_mc: u64, latent_k: f64| limit_mc as f64 * 1e-3 - 33.0 - latent_k;
        (
            used.skin_peak * left(HARD.skin_peak_mc, LATENT_K[0]),
            used.skin_deep * left(HARD.skin_deep_mc, LATENT_K[2]),
        )
    };
    let (shallow, deep) = times.iter().map(&mut at).unzip();
    [shallow, deep]
}

/// Least and largest ratio of rows to the largest response of any corner, the latter up to 100 s.
fn ratios(diameter_um: f64, length_mm: f64, times: &[f64]) -> [f64; 2] {
    let corners = corners(&sized(diameter_um, length_mm));
    let rows = rows(diameter_um, length_mm, times);
    let mut most = [f64::INFINITY, 0.0];
    for (depth, row) in rows.iter().enumerate() {
        let target = envelope(&corners, depth, times);
        for ((t, v), k) in times.iter().zip(&target).zip(row) {
            most[0] = f64::min(most[0], k / v);
            if *t < 100.0 {
                most[1] = f64::max(most[1], k / v);
            }
        }
    }
    most
}

/// At the ends of the table, beside the diameter at which the model's tissue jumps, and anywhere.
#[test]
fn no_wire_is_warmer_than_its_rows() {
    let count = std::env::var("PALPATE_SIZES").map_or(16, |n| n.parse().unwrap());
    let every_third: Vec<f64> = times().into_iter().step_by(3).collect();
    let mut s = RandomStream::new(1, "sizes of wires");
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    let ends = [(50.0, 3.0), (50.0, 20.0), (100.0, 3.0), (100.0, 20.0)];
    let jump = [(66.068, 5.0), (66.069, 5.0), (54.0, 5.0), (94.0, 5.0)];
    let drawn = (0..count).map(|_| {
        let um = pick(&mut s, 50_000.0, 100_000.0).round() / 1e3;
        (um, pick(&mut s, 3_000.0, 20_000.0).round() / 1e3)
    });
    for (um, mm) in ends.into_iter().chain(jump).chain(drawn) {
        let [low, high] = ratios(um, mm, &every_third);
        assert!(low >= 1.0, "{um} um x {mm} mm: {low} of the model");
        (least, most) = (least.min(low), most.max(high));
    }
    println!("rows are {least:.4} to {most:.4} of the largest response");
}

#[test]
fn rows_of_ten_wires_are_hardly_stricter_than_the_programme_s_own() {
    let (times, rates) = (times(), table_rates());
    let mut most = 0.0f64;
    for (um, mm) in [
        (50.0, 3.0),
        (50.0, 8.0),
        (58.0, 6.0),
        (66.0, 10.0),
        (70.0, 4.0),
        (75.0, 5.0),
        (75.0, 8.0),
        (81.0, 12.0),
        (100.0, 5.0),
        (100.0, 8.0),
    ] {
        let corners = corners(&sized(um, mm));
        let guarded = rows(um, mm, &times);
        for (depth, row) in guarded.iter().enumerate() {
            let target = envelope(&corners, depth, &times);
            let best: [f64; DECAYS] = fit(&rates, &times, &target);
            for (t, k) in times.iter().zip(row).take_while(|(t, _)| **t < 100.0) {
                let stricter = k / sum(&rates, &best, *t);
                assert!(stricter < 1.2, "{um} um x {mm} mm at {t} s: {stricter}");
                most = most.max(stricter);
            }
        }
    }
    println!("rows are at most {most:.4} of the programme's");
}

/// Values of the design, by another computation: 20 mW for 10 s, and 10 mJ within 35 ms; and of the page on the guard.
#[test]
fn wires_are_as_warm_as_computed_elsewhere() {
    let warmest = |(um, mm): (f64, f64), length_s: f64, joules: f64| {
        let after = |n: i32| f64::from(n) * 0.01;
        let peak = corners(&sized(um, mm)).iter().fold(0.0f64, |most, corner| {
            let of = (0..200).map(|n| corner.of_burst(0, joules, length_s, after(n)));
            of.fold(most, f64::max)
        });
        33.0 + peak
    };
    for (size, length_s, joules, expected, close) in [
        ((50.0, 8.0), 10.0, 0.2, 38.4, 0.1),
        ((50.0, 8.0), 0.035, 0.01, 37.3, 0.1),
        ((50.0, 3.0), 10.0, 0.2, 45.1, 0.05),
        ((75.0, 8.0), 10.0, 0.2, 38.0, 0.05),
    ] {
        let found = warmest(size, length_s, joules);
        println!("{size:?} um, mm, {joules} J in {length_s} s: {found:.2} C");
        assert!((found - expected).abs() < close, "{found} for {expected}");
    }
}
