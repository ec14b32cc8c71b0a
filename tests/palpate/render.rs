//! The renderer in the loop, as an emulated person feels it: guard and heat on, ten minutes where that is the point.

use std::collections::BTreeMap;

use palpate_core::contact::Levels;
use palpate_core::illusion::IllusionModel;
use palpate_core::projector::{Output, Projector};
use palpate_core::render::{Renderer, Style};
use palpate_files::{LevelsFrom, Scene, Setup};
use palpate_records::felt::felt_scores;
use palpate_records::trace::{Event, event};
use palpate_run::pass::set_passed;
use palpate_run::plan::plan;
use palpate_run::{Input, Outcome, run};

const PATHS: [&str; 4] = [
    "sphere-along",
    "sphere-across",
    "sphere-diagonal",
    "sphere-circle",
];

/// A scene on the default bench with the default law.
fn inverse(scene: &str) -> Setup {
    let mut setup = Setup::load(scene, "emulated").unwrap();
    setup.scene.value.illusion.model = IllusionModel::Inverse;
    setup
}

fn played(setup: &Setup) -> Outcome {
    run(setup, &Input::Scene, 1).unwrap()
}

/// Root mean squares of both centroids' errors, mm.
fn errors(outcome: &Outcome) -> [f64; 2] {
    felt_scores(&outcome.trace).map(|score| {
        score
            .errors
            .map_or(f64::INFINITY, |e| e.rmse_um as f64 * 1e-3)
    })
}

#[test]
fn on_every_path_both_centroids_are_nearer_than_those_of_the_balanced_law() {
    for scene in PATHS {
        for bench in ["emulated", "thesis"] {
            let of = |model| {
                let mut setup = Setup::load(scene, bench).unwrap();
                setup.scene.value.illusion.model = model;
                played(&setup)
            };
            let (ours, theirs) = (of(IllusionModel::Inverse), of(IllusionModel::Balanced));
            assert_eq!(ours.summary.limiter_events, 0, "{scene} on {bench}");
            // The typical person feels little of the other one by either law.
            if bench == "emulated" {
                let (ours, theirs) = (errors(&ours), errors(&theirs));
                let nearer = ours.iter().zip(theirs).all(|(o, t)| *o < t && *o < 1.0);
                assert!(nearer, "{scene}: {ours:?} mm against {theirs:?} mm");
            }
        }
    }
}

/// Law, pulses, table and full level to the bit, and the bench that the guard counts with.
#[test]
fn the_librarys_builder_has_by_default_what_the_program_has() {
    let mut setup = Setup::load("sphere-along", "emulated").unwrap();
    set_passed(&mut setup);
    let plan = plan(&setup, 1, Levels::Off).unwrap();
    let built = Output::builder(plan.display.clone()).build().unwrap();
    let program = Projector::new(plan).unwrap();
    assert_eq!(built.timing(), program.timing());
    assert_eq!(built.guard().plant(), program.guard().plant());
    let renderer = |of: Option<&Renderer>| format!("{:?}", of.unwrap());
    assert_eq!(renderer(built.renderer()), renderer(program.renderer()));
}

/// Levels of the onsets with a contact, thousandths of a decibel, and when they were.
fn levels(outcome: &Outcome) -> Vec<(u64, i32)> {
    let felt = |event: &Event| match event {
        Event::Felt(event::Felt { t_us, met, .. }) => Some((*t_us, met.as_ref()?.level_mdb)),
        _ => None,
    };
    outcome.trace.events.iter().filter_map(felt).collect()
}

#[test]
fn a_contact_that_rests_ten_minutes_keeps_its_level_and_its_place() {
    for scene in ["rest-on-wire", "rest-between", "rest-in-cell"] {
        for style in [Style::Smooth, Style::Tap] {
            let mut setup = inverse(scene);
            setup.scene.value.length_s = 600.0;
            setup.scene.value.touches[0].end_s = 600.0;
            setup.scene.value.illusion.render = style;
            let outcome = played(&setup);
            assert_eq!(outcome.summary.limiter_events, 0, "{scene} {style:?}");
            assert!(
                errors(&outcome).iter().all(|mm| *mm < 1.0),
                "{scene} {style:?}"
            );
            let levels = levels(&outcome);
            // Five seconds after the touch began, half a second about it.
            let near: Vec<i32> = levels
                .iter()
                .filter(|l| l.0.abs_diff(5_800_000) < 500_000)
                .map(|l| l.1)
                .collect();
            let settled = near.iter().sum::<i32>() / near.len() as i32;
            let later = levels
                .iter()
                .filter(|l| (6_300_000..599_500_000).contains(&l.0));
            let worst = later.map(|l| (l.1 - settled).abs()).max().unwrap();
            assert!(worst < 3000, "{scene} {style:?}: {worst} mdB off {settled}");
            assert!(settled > 0, "{scene} {style:?}: {settled} mdB");
        }
    }
}

#[test]
fn auto_taps_a_contact_that_rests_and_vibrates_one_that_moves() {
    let taps = |scene| {
        let mut setup = inverse(scene);
        setup.scene.value.illusion.render = Style::Auto;
        let outcome = played(&setup);
        let felt = outcome.trace.events.iter().filter_map(|event| match event {
            Event::Felt(event::Felt { met: Some(met), .. }) => Some(met.tap),
            _ => None,
        });
        let felt: Vec<bool> = felt.collect();
        (felt.iter().filter(|tap| **tap).count(), felt.len())
    };
    let (rest, all) = taps("rest-on-wire");
    assert!(rest > 8 * all / 10, "{rest} of {all}");
    let (moving, all) = taps("sphere-circle");
    assert!(moving < all / 10, "{moving} of {all}");
}

/// Holds the pulses that every entry says against the rising edges of its channel; how many entries there were.
fn count_pulses(outcome: &Outcome) -> usize {
    let trace = &outcome.trace;
    let period_ns = trace.header.pre_scale.period_ns();
    let mut rises = BTreeMap::<(u8, u8), Vec<u64>>::new();
    for event in &trace.events {
        if let Event::Edge(event::Edge {
            t_ns,
            board,
            channel,
            high: true,
        }) = event
        {
            rises.entry((*board, *channel)).or_default().push(*t_ns);
        }
    }
    let mut checked = 0;
    for event in &trace.events {
        if let Event::Schedule(entry) = event {
            let (from, to) = (entry.at.as_micros() * 1000, entry.until.as_micros() * 1000);
            let of_channel = rises.get(&(entry.board.0, entry.channel.0));
            let rose = of_channel.map_or(0, |rises| {
                rises.partition_point(|t| *t < to + period_ns)
                    - rises.partition_point(|t| *t < from)
            });
            assert_eq!(rose as u64, entry.pulses(period_ns), "{entry:?}");
            checked += 1;
        }
    }
    checked
}

/// Whatever the law and the channels, whose pulses stand later in the period.
#[test]
fn a_stimulus_has_the_pulses_that_its_entry_says() {
    use IllusionModel::{Balanced, Inverse};
    for (law, first) in [(Inverse, 0), (Inverse, 8), (Balanced, 0), (Balanced, 8)] {
        let mut setup = inverse("sphere-along");
        setup.scene.value.illusion.model = law;
        assert_eq!(setup.bench.value.outputs.len(), 8);
        for (output, channel) in setup.bench.value.outputs.iter_mut().zip(first..) {
            output.channel = channel;
        }
        assert!(count_pulses(&played(&setup)) > 100, "{law:?}");
    }
    for scene in [
        "brush-strokes",
        "two-finger-press",
        "rest-between",
        "sphere-along-wood",
        "texture-sponge1",
    ] {
        let setup = Setup::load(scene, "emulated").unwrap();
        assert!(count_pulses(&played(&setup)) >= 8, "{scene}");
    }
}

/// Median of the felt levels between two times, dB.
fn median_db(outcome: &Outcome, [from_s, to_s]: [f64; 2]) -> f64 {
    let within = |t_us: u64| (from_s..to_s).contains(&(t_us as f64 * 1e-6));
    let mut mdb: Vec<i32> = levels(outcome)
        .into_iter()
        .filter(|(t_us, _)| within(*t_us))
        .map(|(_, mdb)| mdb)
        .collect();
    mdb.sort_unstable();
    f64::from(mdb[mdb.len() / 2]) * 1e-3
}

/// Smallest difference in intensity that was just noticeable on an index pad, dB (Israr 2006).
const NOTICED_DB: f64 = 1.65;

#[test]
fn how_hard_a_contact_presses_is_heard_as_steps_that_can_be_noticed() {
    for weber in [0.4, 0.45] {
        let mut setup = Setup::load("press-levels", "emulated").unwrap();
        setup.scene.value.illusion.weber = Some(weber);
        let outcome = played(&setup);
        assert_eq!(outcome.summary.limiter_events, 0, "{weber}");
        // Without the ramps and the first onsets, when wires are cold.
        let presses = setup.scene.value.touches.iter();
        let felt: Vec<f64> = presses
            .map(|touch| median_db(&outcome, [touch.start_s + 0.6, touch.end_s - 0.3]))
            .collect();
        // The lightest press is near the threshold of the typical person, the others are above it.
        assert!(felt[1..].iter().all(|db| *db > 0.0), "{weber}: {felt:?}");
        let steps = felt.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(
            felt.len() == 3 && steps.clone().all(|step| step > NOTICED_DB),
            "{weber}: {felt:?}"
        );
    }
}

#[test]
fn the_strongest_contact_of_a_frame_has_the_top_level_where_levels_are_dynamic() {
    let spent = |scene: &str, change: &dyn Fn(&mut Scene)| {
        let mut setup = Setup::load(scene, "emulated").unwrap();
        setup.scene.value.illusion.intensity_floor = 0.5;
        change(&mut setup.scene.value);
        played(&setup).trace.ledger.energy_uj
    };
    let dynamic = |scene: &mut Scene| scene.compression.levels = LevelsFrom::Dynamic;
    let without = |scene: &mut Scene| scene.illusion.intensity = false;
    // A single one is always the strongest.
    assert_eq!(
        spent("sphere-along", &dynamic),
        spent("sphere-along", &without)
    );
    // Of two, one is a level lower: by the Weber fraction, or down to the floor. Without heat as a bound, under which a
    // lower level has the power that it saves.
    let cool = |scene: &mut Scene| {
        scene.length_s = 3.0;
        scene.illusion.level_db = Some(4.0);
    };
    let top = |scene: &mut Scene| {
        cool(scene);
        without(scene);
    };
    let coarse = |scene: &mut Scene| {
        cool(scene);
        dynamic(scene);
        scene.illusion.weber = Some(0.35);
    };
    let lowest = |scene: &mut Scene| {
        cool(scene);
        dynamic(scene);
        scene.compression.ki = 2;
    };
    let [both, weaker, weakest] = [
        spent("two-finger-press", &top),
        spent("two-finger-press", &coarse),
        spent("two-finger-press", &lowest),
    ];
    assert!(
        both > weaker && weaker > weakest,
        "{both} {weaker} {weakest} uJ"
    );
}
