//! Tests of `felt.rs`.

use super::*;
use crate::synthetic;
use crate::trace::EnergyPermille;

fn felt(t_us: u64, target: i32, felt: Option<(i32, i32, i32)>) -> Event {
    let at = |x| PlaceUm { x, y: 0 };
    Event::Felt(event::Felt {
        t_us,
        target: at(target),
        inside: true,
        met: felt.map(|(energy, amplitude, level_mdb)| FeltAt {
            energy: at(energy),
            amplitude: at(amplitude),
            level_mdb,
            skin_nm: 1_000 * i32::from(energy == 3_000) + 2_000,
            tap: t_us == 0,
        }),
        energy: EnergyPermille {
            requested: 500,
            applied: 400,
            felt: 900,
        },
    })
}

#[test]
fn both_centroids_are_scored_apart() {
    let mut trace = synthetic::empty();
    trace.events = vec![
        felt(0, 0, Some((3_000, 0, 3_000))),
        felt(58_500, 1_000, Some((3_000, 1_000, 3_000))),
        // The energy centroid goes 3 mm where the contact goes 1 mm: 1.9 mm would be felt.
        felt(117_000, 2_000, Some((6_000, 2_000, 3_000))),
        felt(175_500, 3_000, None),
        // Below the threshold: a break, at a place all the same.
        felt(234_000, 4_000, Some((4_000, 6_000, -1))),
        // After a break nothing can jump.
        felt(292_500, 5_000, Some((9_000, 9_000, 3_000))),
    ];
    let [energy, amplitude] = felt_scores(&trace);
    assert_eq!((energy.breaks, energy.jumps), (2, 1));
    assert_eq!((amplitude.breaks, amplitude.jumps), (2, 0));
    assert_eq!(energy.errors.unwrap().max_um, 4_000);
    assert_eq!(energy.everywhere, energy.errors);
    // 0, 0, 0, nothing where no wire moved, 2 mm, 4 mm.
    assert_eq!(amplitude.errors.unwrap().rmse_um, 2_000);
    let energies = energies(&trace).unwrap();
    assert_eq!(energies[0], ("requested", (500, 500)));
    assert_eq!(energies[2], ("felt", (900, 900)));
    let level = felt_level(&trace).unwrap();
    assert_eq!((level.median_mdb, level.p5_mdb), (3_000, -200_000));
    assert_eq!(level.taps, 1);
    // Two of 3 um, three of 2 um, and an onset without motion.
    assert_eq!((level.skin_median_nm, level.skin_most_nm), (2_000, 3_000));
    assert!((decibels(500) + 3.01).abs() < 0.01);
}

#[test]
fn nothing_felt_is_no_score() {
    let [energy, _] = felt_scores(&synthetic::empty());
    assert_eq!((energy.errors, energy.breaks, energy.jumps), (None, 0, 0));
    assert_eq!(energies(&synthetic::empty()), None);
    assert_eq!(felt_level(&synthetic::empty()), None);
}

#[test]
fn an_onset_outside_the_display_counts_for_the_error_over_all_alone() {
    let mut trace = synthetic::empty();
    let mut outside = felt(58_500, 0, Some((6_000, 6_000, 3_000)));
    if let Event::Felt(felt) = &mut outside {
        felt.inside = false;
    }
    trace.events = vec![felt(0, 0, Some((0, 0, 3_000))), outside];
    let [energy, _] = felt_scores(&trace);
    let (inside, everywhere) = (energy.errors.unwrap(), energy.everywhere.unwrap());
    assert_eq!((inside.count, inside.max_um), (1, 0));
    assert_eq!((everywhere.count, everywhere.max_um), (2, 6_000));
}
