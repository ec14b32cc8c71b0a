//! A contact's load is spread, its fast changes are not, and each taxel hears them a sample after the one before.

use alloc::vec::Vec;

use super::*;

const REST: [u16; 3] = [1000, 2000, 3000];

fn at_rest(_: usize) -> [f64; 3] {
    REST.map(f64::from)
}

/// Four taxels of which one is not read: at rest, then one under a load that goes up and down by `change` each sample.
fn gathered(load: u16, change: u16, samples: usize) -> (Gathering, Vec<[f32; 4]>) {
    let mut gathering = Gathering::new([0, 1, 3].into(), 4);
    let mut counts = [REST; 4];
    for _ in 0..10 {
        gathering.push(&counts, false, at_rest);
    }
    let mut told = Vec::new();
    for sample in 0..samples {
        counts[1][2] = 3000 + load + if sample % 2 == 0 { change } else { 0 };
        // what is not read counts nothing
        counts[2] = [9000; 3];
        gathering.push(&counts, true, at_rest);
        told.push([0, 1, 2, 3].map(|taxel| gathering.reading(taxel, 2)));
    }
    (gathering, told)
}

#[test]
fn a_steady_load_is_spread_over_the_face() {
    let (gathering, told) = gathered(300, 0, 20);
    assert_eq!(told[19], [3100.0; 4]);
    assert_eq!(
        [gathering.reading(0, 0), gathering.reading(3, 1)],
        [1000.0, 2000.0]
    );
}

#[test]
fn fast_changes_are_as_large_as_on_the_contacts_own_taxel_and_pass_one_after_another() {
    let (_, told) = gathered(300, 20, 40);
    let spread = |of: &[f32]| {
        let most = of.iter().fold(f32::MIN, |a, b| a.max(*b));
        most - of.iter().fold(f32::MAX, |a, b| a.min(*b))
    };
    let last: Vec<_> = told[20..].iter().map(|t| t[0]).collect();
    // up and down by 20 about means of five, 8 to 12, a third of which is spread
    assert!(
        (spread(&last) - (16.0 + 4.0 / 3.0)).abs() < 0.01,
        "{last:?}"
    );
    for pair in told[20..].windows(2) {
        let [before, after] = [pair[0], pair[1]];
        let fast = |t: [f32; 4], taxel: usize| t[taxel] - (t[0] + t[1]) / 2.0;
        for taxel in 0..3 {
            assert!(
                (fast(before, taxel) - fast(after, taxel + 1)).abs() < 1.0,
                "{pair:?}"
            );
        }
    }
}

#[test]
fn shear_is_turned_to_where_training_drags_it_whichever_way_it_goes() {
    for (x, y) in [(300, 0), (0, 300), (-300, 0), (0, -300)] {
        let mut gathering = Gathering::new([0, 1].into(), 2);
        let mut dragged = [REST; 2];
        dragged[0][0] = (1000 + x) as u16;
        dragged[0][1] = (2000 + y) as u16;
        gathering.push(&dragged, true, at_rest);
        assert_eq!(
            [gathering.reading(0, 0), gathering.reading(1, 1)],
            [850.0, 2000.0]
        );
    }
}

#[test]
fn nothing_is_fast_while_nothing_is_touched() {
    let mut gathering = Gathering::new([0].into(), 1);
    for sample in 0..20 {
        gathering.push(
            &[[0, 0, if sample % 2 == 0 { 65535 } else { 0 }]],
            false,
            at_rest,
        );
        let told = gathering.reading(0, 2);
        let slow = gathering.means[2];
        assert_eq!(told, slow);
    }
}
