//! Tests of `in_loop.rs`.

use super::*;

/// What of an onset two accounts must have in common: when, level, whether it is felt and where.
fn met(event: &Event) -> Option<(u64, i32, Option<palpate_records::trace::FeltAt>)> {
    match *event {
        Event::Felt {
            t_us,
            level_mdb,
            felt,
            ..
        } => Some((t_us, level_mdb?, felt)),
        _ => None,
    }
}

#[test]
fn a_person_feels_what_the_probes_meet_less_the_thresholds() {
    let case = Case {
        law: IllusionModel::Phantom,
        bench: BENCHES[2],
        wires: Some("loose"),
        scene: "sphere-across",
    };
    let played = case.play(1).unwrap();
    for name in PERSONS {
        let mut setup = case.setup().unwrap();
        setup.person = load_person(name).unwrap();
        let outcome = run(&setup, &Input::Scene, 1).unwrap();
        let theirs: Vec<_> = outcome.trace.events.iter().filter_map(met).collect();
        let person = person(name).unwrap();
        let ours = played.onsets.iter().map(|o| as_felt(o, Some(&person)));
        let ours: Vec<_> = ours.filter_map(|e| met(&e)).collect();
        assert_eq!(ours.len(), theirs.len());
        assert!(ours.len() > 100);
        for (a, b) in ours.iter().zip(&theirs) {
            assert!(a.0 == b.0 && a.1.abs_diff(b.1) <= 2, "{name}: {a:?} {b:?}");
            // Two thousandths of a decibel around the threshold may fall on either side.
            assert!(a.2 == b.2 || b.1.abs() <= 2, "{name}: {a:?} {b:?}");
        }
    }
}

#[test]
fn own_scenes_are_felt_and_the_worst_seed_is_kept() {
    let [a, b, c] = PERSONS;
    let persons = [a, b, c].map(|name| person(name).unwrap());
    for scene in ["rest", "press"] {
        let case = Case {
            law: IllusionModel::Balanced,
            bench: BENCHES[2],
            wires: Some("loose"),
            scene,
        };
        let [one, two] = [1, 2].map(|seed| Figures::of(&case.play(seed).unwrap(), &persons));
        let worst = one.worse(two);
        assert!(worst.off.worst_mm() == one.off.worst_mm().max(two.off.worst_mm()));
        let levels = [one, two, worst].map(|f| f.by[1].level_db.unwrap()[1]);
        assert_eq!(levels[2], levels[0].min(levels[1]));
        assert!(worst.skin_c > 33.0 && worst.energy_mj > 10.0, "{scene}");
    }
}
