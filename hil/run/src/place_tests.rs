//! Seats of wires, by the display that has them, and what is felt of them.

use palpate_core::schedule::Entry;
use palpate_files::{Overrides, Seat};

use super::*;
use crate::{Input, run};

fn seat(wire: usize, part: f64) -> Seat {
    Seat {
        wire,
        points_s_part: vec![[0.0, part]],
    }
}

#[test]
fn each_display_has_the_seats_of_its_own_wires() {
    let mut setup = Setup::load("allegro-grasp", "allegro-hand").unwrap();
    let wires = setup.bench.value.outputs.len();
    setup.scene.value.seats = (0..wires).map(|wire| seat(wire, 0.5)).collect();
    let all = fingers(&setup);
    assert_eq!(all.len(), 4);
    for (place, alone) in &all {
        let found: Vec<usize> = alone.scene.value.seats.iter().map(|s| s.wire).collect();
        assert_eq!(found, (0..place.wires).collect::<Vec<_>>());
    }
    setup.scene.value.seats = vec![seat(all[2].0.first_wire + 3, 0.5)];
    let own = |(_, alone): &(Place, Setup)| alone.scene.value.seats.clone();
    let found: Vec<_> = fingers(&setup).iter().map(own).collect();
    assert_eq!(found, [vec![], vec![], vec![seat(3, 0.5)], vec![]]);
}

/// By another way than the run's: motion of a part p is felt as 20 log10(p) dB, while the law and the wires stay what they are.
#[test]
fn wires_that_lie_on_the_finger_by_half_are_felt_six_decibels_less() {
    let mut overrides = Overrides::default();
    overrides.scene("a test", "length_s", 2.0);
    let setup = Setup::load("sphere-along", "emulated").unwrap();
    let setup = setup.with(&overrides).unwrap();
    let played = |seats: Vec<Seat>| {
        let mut setup = setup.clone();
        setup.scene.value.seats = seats;
        let outcome = run(&setup, &Input::Scene, 1).unwrap();
        (outcome.summary.felt, outcome.trace.each::<Entry>().count())
    };
    let (even, entries) = played(Vec::new());
    let (half, same) = played((0..8).map(|wire| seat(wire, 0.5)).collect());
    assert_eq!(entries, same);
    let (even_db, half_db) = (even.level_db.unwrap().median, half.level_db.unwrap().median);
    assert!((even_db - half_db - 20.0 * 2.0_f64.log10()).abs() < 2e-3);
    let (even_um, half_um) = (even.skin_um.unwrap().median, half.skin_um.unwrap().median);
    assert!((even_um / half_um - 2.0).abs() < 1e-3);
}
