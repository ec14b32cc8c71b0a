//! Whitened readings change equally in every direction; a folded network says of plain readings what it said of those.

use super::*;
use crate::training::tests::small;
use crate::training::{Plain, latents};

#[test]
fn changes_are_equally_strong_and_independent() {
    let (windows, split, _) = small();
    let whitening = Whitening::new(&windows, &split.train);
    let whitened = whitening.whitened(&windows);
    let mut sum = Array2::<f64>::zeros((4, 4));
    let mut count = 0.0;
    for &recording in &split.train {
        let rows = &whitened.recordings.all[recording].values;
        let rows: Vec<_> = rows.chunks_exact(4).skip(whitened.length).collect();
        for two in rows.windows(2) {
            let change = Array1::from_shape_fn(4, |f| f64::from(two[1][f] - two[0][f]));
            for (mut sums, &one) in sum.rows_mut().into_iter().zip(&change) {
                sums.scaled_add(one, &change);
            }
            count += 1.0;
        }
    }
    let found = sum / count;
    // Where two features nearly agree the ridge is much of what they are brought to one size with.
    let plain = whitening.back.dot(&found).dot(&whitening.back.t());
    let ridge = RIDGE * plain.diag().sum() / 4.0;
    let ridge = ridge * whitening.there.dot(&whitening.there.t());
    for ((row, column), whole) in (found + ridge).indexed_iter() {
        let wanted = if row == column { GAIN * GAIN } else { 0.0 };
        let off = (whole - wanted).abs();
        assert!(off < 1e-3 * GAIN * GAIN, "{row} {column} {off}");
    }
}

#[test]
fn a_folded_network_takes_plain_readings() {
    let (windows, split, _) = small();
    let whitening = Whitening::new(&windows, &split.train);
    let whitened = whitening.whitened(&windows);
    let network = Network::<Plain>::new(4, 3, 12, 5, &Default::default());
    let places = windows.places(&split.test, 3);
    let before = latents(&network, &whitened, &places);
    let decoded = |network: &Network<Plain>, windows: &Windows| -> Vec<f32> {
        let z = network.encode(windows.batch::<Plain>(&places, &Default::default()));
        network.decode(z, 12).into_data().into_vec().unwrap()
    };
    let rebuilt = decoded(&network, &whitened);
    let folded = whitening.folded(network);
    let after = latents(&folded, &windows, &places);
    for (before, after) in before.iter().flatten().zip(after.iter().flatten()) {
        assert!((before - after).abs() < 1e-4, "{before} {after}");
    }
    // what the folded decoder says, whitened, is what it said before
    let plain = decoded(&folded, &windows);
    for (plain, rebuilt) in plain.chunks_exact(4).zip(rebuilt.chunks_exact(4)) {
        let plain = Array1::from_iter(plain.iter().map(|v| f64::from(*v)));
        for (found, wanted) in whitening.there.dot(&plain).iter().zip(rebuilt) {
            assert!(
                (found - f64::from(*wanted)).abs() < 1e-3,
                "{found} {wanted}"
            );
        }
    }
}

#[test]
fn a_feature_that_never_changes_stays_quiet() {
    let (mut windows, split, _) = small();
    for recording in &mut windows.recordings.all {
        recording
            .values
            .iter_mut()
            .skip(2)
            .step_by(4)
            .for_each(|v| *v = 7.0);
    }
    windows.scale = Scale::new(&windows.recordings, &split.train);
    let whitened = Whitening::new(&windows, &split.train).whitened(&windows);
    for recording in &whitened.recordings.all {
        assert!(recording.values.iter().all(|v| v.is_finite()));
        // a triangle: the third feature mixes only those before it, of which it has nothing
        let dead = recording.values.iter().skip(2).step_by(4);
        assert!(dead.into_iter().all(|v| v.abs() < 1e-3));
    }
}
