//! Tests of `in_loop.rs`.

use palpate_records::trace::FeltAt;

use super::*;

/// What was met of an onset, and when.
fn onset(event: &Event) -> Option<(u64, FeltAt)> {
    match *event {
        Event::Felt(event::Felt { t_us, met, .. }) => Some((t_us, met?)),
        _ => None,
    }
}

#[test]
fn a_person_feels_what_the_probes_meet_less_the_thresholds() {
    let case = Case {
        law: IllusionModel::Phantom,
        drive: DRIVES[2],
        wires: "final-75um",
        scene: "sphere-across",
    };
    let played = case.play(1).unwrap();
    for name in PERSONS {
        let mut setup = case.setup().unwrap();
        setup.person = load_person(name).unwrap();
        let outcome = run(&setup, &Input::Scene, 1).unwrap();
        let theirs: Vec<_> = outcome.trace.events.iter().filter_map(onset).collect();
        let person = person(name, &setup).unwrap();
        let ours = played.onsets.iter().map(|o| met(o, &person));
        let ours: Vec<_> = ours.filter_map(|e| onset(&e)).collect();
        assert_eq!(ours.len(), theirs.len());
        assert!(ours.len() > 100);
        for ((at, mut a), (then, b)) in ours.into_iter().zip(theirs) {
            // Three roundings to a thousandth of a decibel.
            assert!(
                a.level_mdb.abs_diff(b.level_mdb) <= 2,
                "{name}: {a:?} {b:?}"
            );
            a.level_mdb = b.level_mdb;
            assert_eq!((at, a), (then, b), "{name}");
        }
    }
}

#[test]
fn own_scenes_are_felt_and_the_worst_seed_is_kept() {
    for scene in ["rest", "press"] {
        let case = Case {
            law: IllusionModel::Balanced,
            drive: DRIVES[2],
            wires: "final-75um",
            scene,
        };
        let setup = case.setup().unwrap();
        let persons = persons(&setup).unwrap();
        let map = *build(&setup, 1, Levels::Off).unwrap().map();
        let of = |seed| Figures::of(&case.play(seed).unwrap(), &persons, (&case, &map));
        let [one, two] = [1, 2].map(of);
        let worst = one.worse(two);
        let [one, two, worst] = [one, two, worst].map(|f| {
            assert!(f.skin_c > 30.0 && f.energy_mj > 10.0, "{scene}");
            (f.by[1].worst_mm(), f.by[1].level_db.unwrap()[1])
        });
        assert_eq!(worst, (one.0.max(two.0), one.1.min(two.1)), "{scene}");
    }
}
