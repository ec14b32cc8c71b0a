//! What a texture is must show in the counts, in the order in which the textures have it.

use super::*;

fn texture(stiffness: f64, relief_mm: f64, friction: f64) -> SurfaceTexture {
    SurfaceTexture {
        name: "test".into(),
        stiffness_n_per_mm: stiffness,
        relief_mm,
        wavelength_mm: 2.5,
        octaves: 1.0,
        friction,
    }
}

/// Signed change of each axis of each taxel between two rows.
fn change(
    from: &[palpate_core::codec::uskin::Reading],
    to: &[palpate_core::codec::uskin::Reading],
) -> Vec<[f64; 3]> {
    let less = |a: u16, b: u16| f64::from(a) - f64::from(b);
    let pair = from.iter().zip(to);
    pair.map(|(f, t)| [less(t.x, f.x), less(t.y, f.y), less(t.z, f.z)])
        .collect()
}

/// Root mean square of second differences of an axis over the sliding part: what moves fast.
fn buzz(recording: &Recording, axis: usize) -> f64 {
    let rows = &recording.rows[60..];
    let (mut sum, mut n) = (0.0, 0.0);
    for three in rows.windows(3) {
        let (a, b) = (change(&three[0], &three[1]), change(&three[1], &three[2]));
        for (a, b) in a.iter().zip(&b) {
            sum += (b[axis] - a[axis]).powi(2);
            n += 1.0;
        }
    }
    (sum / n).sqrt()
}

/// Sum of x and of z over the module at one row, less the first row, which is in the air.
fn load(recording: &Recording, row: usize) -> (f64, f64) {
    let change = change(&recording.rows[0], &recording.rows[row]);
    (
        change.iter().map(|c| c[0]).sum(),
        change.iter().map(|c| c[2]).sum(),
    )
}

fn five(texture: &SurfaceTexture) -> Vec<Recording> {
    let mut explorer = Explorer::new(Habits::default(), None, 3);
    (0..5).map(|n| explorer.stroke(texture, n)).collect()
}

fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn a_rougher_surface_buzzes_more_in_shear_and_in_pressure() {
    for axis in [0, 2] {
        let buzz = |relief: f64| {
            mean(
                five(&texture(20.0, relief, 0.6))
                    .iter()
                    .map(|r| buzz(r, axis)),
            )
        };
        let (smooth, middle, rough) = (buzz(0.002), buzz(0.08), buzz(0.25));
        assert!(
            smooth < middle && middle < rough,
            "axis {axis}: {smooth} {middle} {rough}"
        );
        assert!(rough > 2.0 * smooth, "axis {axis}: {smooth} {rough}");
    }
}

#[test]
fn friction_is_the_shear_of_a_load() {
    for friction in [0.3, 0.8, 1.5] {
        let ratio = five(&texture(20.0, 0.0, friction));
        let ratio = mean(ratio.iter().flat_map(|r| {
            (80..190).map(|row| {
                let (x, z) = load(r, row);
                -x / z
            })
        }));
        // the pad's edge adds shear of its own, and slips take some away
        assert!((ratio / friction - 1.0).abs() < 0.2, "{friction}: {ratio}");
    }
}

#[test]
fn a_hard_surface_answers_at_once_and_shakes_more() {
    let rise = |stiffness: f64| {
        mean(five(&texture(stiffness, 0.0, 0.5)).iter().map(|r| {
            let full = mean((60..200).map(|row| load(r, row).1));
            let past = |share: f64| (0..200).find(|&row| load(r, row).1 > share * full);
            past(0.8).unwrap() as f64 - past(0.1).unwrap() as f64
        }))
    };
    let shake = |stiffness: f64| {
        mean(
            five(&texture(stiffness, 0.0, 0.5))
                .iter()
                .map(|r| buzz(r, 2)),
        )
    };
    assert!(rise(1.5) > rise(8.0) + 1.0, "{} {}", rise(1.5), rise(8.0));
    assert!(
        shake(60.0) > 1.2 * shake(4.0),
        "{} {}",
        shake(60.0),
        shake(4.0)
    );
}

#[test]
fn silicone_drowns_what_is_fast_and_small() {
    let mut stream = palpate_core::random::RandomStream::new(1, "relief");
    let relief = Relief::new(&texture(20.0, 0.1, 0.5), 0.005, &mut stream);
    let power =
        |speed: f64| mean((0..500).map(|i| relief.height(f64::from(i) * 0.37, 0.0, speed).powi(2)));
    assert!(power(20.0) > power(80.0) && power(80.0) > power(300.0));
    let fine = SurfaceTexture {
        wavelength_mm: 0.4,
        ..texture(20.0, 0.1, 0.5)
    };
    let mut stream = palpate_core::random::RandomStream::new(1, "relief");
    let fine = Relief::new(&fine, 0.005, &mut stream);
    let fine = mean((0..500).map(|i| fine.height(f64::from(i) * 0.37, 0.0, 80.0).powi(2)));
    assert!(fine < 0.1 * power(80.0), "{fine} {}", power(80.0));
}

#[test]
fn seeds_reproduce_and_differ() {
    let of =
        |seed| Explorer::new(Habits::default(), Some(6), seed).stroke(&texture(20.0, 0.1, 0.5), 4);
    assert_eq!(of(1), of(1));
    assert_ne!(of(1), of(2));
    let recording = of(1);
    assert_eq!(
        (recording.rows.len(), recording.rows[0].len()),
        (SAMPLES, 16)
    );
    assert!(
        recording
            .rows
            .iter()
            .all(|row| row[6] == recording.rows[0][6]),
        "the dead taxel"
    );
    assert!((0..16).filter(|&t| t != 6).all(|t| {
        recording
            .rows
            .iter()
            .any(|row| row[t] != recording.rows[0][t])
    }));
}

#[test]
fn numbers_that_are_none_are_survived() {
    for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e308] {
        for place in 0..5 {
            let mut odd = texture(20.0, 0.1, 0.5);
            let fields = [
                &mut odd.stiffness_n_per_mm,
                &mut odd.relief_mm,
                &mut odd.wavelength_mm,
                &mut odd.octaves,
                &mut odd.friction,
            ];
            *fields.into_iter().nth(place).unwrap() = bad;
            let explorer = Explorer::new(Habits::default(), None, 1);
            let recording = explorer.with_accelerometer().stroke(&odd, 0);
            assert_eq!(recording.rows.len(), SAMPLES);
            assert_eq!(recording.acceleration.len(), 6000);
        }
    }
}
