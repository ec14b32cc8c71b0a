//! What a finger's contacts are held against, what a joint and a watcher do: several displays beyond their schedules.

use std::collections::BTreeMap;

use palpate_files::{Bench, Loaded, Overrides, Scene, Setup, Source, load_bench, load_scene};
use palpate_records::trace::{Event, Trace, event};
use palpate_records::verdict::Verdict;
use palpate_run::{Beginning, Failure, Host, Input, Keep, Outcome, TurnView, run, run_with};

use super::fingers::{entries, notes};

/// Two pads onto one thimble: a touch of the right one is felt on the right. The bench's other display is not built.
#[test]
fn merged_modules_drive_one_display_by_their_places() {
    let scene = "name = \"pads\"\ndescription = \"Two pads.\"\nlength_s = 4.0\nlayout = \"uskin-4x4-pair\"\n\
        fingers = [{ display = \"a\", modules = [0, 1], rule = \"merged\" }]\n\
        [[touches]]\nmodule = 1\nstart_s = 1.0\npath = { kind = \"hold\", points_mm = [[0.0, 0.0]] }\n\
        force_n = { mean = 0.8, amplitude = 0.0, period_s = 1.0 }\n";
    let source = Source::new("scene.toml", scene);
    let value = Scene::read(&source).unwrap();
    let scene = Loaded { value, source };
    let bench = "name = \"two\"\ndescription = \"Two.\"\nwire.kind = \"final-75um\"\ndrive.current_ma = 1970.0\n\
        displays = [{ name = \"a\", person = \"dull\" }, { name = \"b\" }]\n";
    let source = Source::new("bench.toml", bench);
    let value = Bench::read(&source).unwrap();
    let setup = Setup::join(scene, Loaded { value, source }).unwrap();
    let outcome = run(&setup, &Input::Scene, 1).unwrap();
    let [a] = &outcome.summary.displays[..] else {
        panic!("{:?}", outcome.summary.displays);
    };
    assert_eq!(
        (&*a.name, &*a.felt.person, &*a.modules),
        ("a", "dull", &[0, 1][..])
    );
    assert!(a.stimuli > 10, "{a:?}");
    let trace = &outcome.displays[0].outcome.trace;
    let right = |e: &Event| match e {
        Event::Felt(event::Felt { target, .. }) => Some(target.x > 0),
        _ => None,
    };
    assert!(trace.events.iter().filter_map(right).all(|right| right));
    let path = a.path_error_mm.expect("both pads lie in one plane");
    assert!(path.rmse < 1.0, "{path:?}");
}

/// `scope = "skin"` is for a bench with one display: a finger's contacts are held against touches of its own module.
#[test]
fn a_finger_knows_the_touches_of_its_own_module_alone() {
    let grasp = |scope: &str| {
        let mut overrides = Overrides::default();
        overrides
            .set("test", &format!("compression.scope={scope}"))
            .unwrap();
        let scene = load_scene("allegro-grasp")
            .unwrap()
            .with(&overrides)
            .unwrap();
        let mut setup = Setup::join(scene, load_bench("allegro-hand").unwrap()).unwrap();
        setup.scene.value.length_s = 6.0;
        run(&setup, &Input::Scene, 1).unwrap()
    };
    let (module, skin) = (grasp("module"), grasp("skin"));
    for (a, b) in module.summary.displays.iter().zip(&skin.summary.displays) {
        let (a, b) = (a.path_error_mm.unwrap(), b.path_error_mm.unwrap());
        assert!(
            a.rmse < 0.5 && (a.rmse - b.rmse).abs() < 0.05,
            "{a:?} {b:?}"
        );
    }
}

/// A finger is felt while its joint says so; its contacts are found all the time, and no other finger takes notice.
#[test]
fn a_joint_lets_its_finger_be_felt() {
    let gated = |when: &str| {
        let text = palpate_fixtures::scene("allegro-grasp").unwrap();
        let index = "modules = [0, 1, 2, 3]\nrule = \"first\"\n";
        let joint = "[[joints]]\nname = \"index_mcp\"\npoints_s_deg = [[3.0, 0.0], [5.0, 40.0]]\n";
        let text = text.replacen(index, &format!("{index}{when}\n"), 1);
        let source = Source::new("scene.toml", format!("{text}\n{joint}"));
        let value = Scene::read(&source).unwrap();
        let mut setup = Setup::join(
            Loaded { value, source },
            load_bench("allegro-hand").unwrap(),
        )
        .unwrap();
        setup.scene.value.length_s = 6.0;
        run(&setup, &Input::Scene, 1).unwrap()
    };
    let [always, bent] = ["", "when = { joint = \"index_mcp\", above_deg = 20 }"].map(gated);
    let trace = |outcome: &Outcome, n: usize| outcome.displays[n].outcome.trace.clone();
    let times = |trace: &Trace| {
        entries(trace)
            .iter()
            .map(|e| e.at.as_micros())
            .collect::<Vec<_>>()
    };
    // Twenty degrees are passed at 4 s.
    let index = trace(&bent, 0);
    assert!(times(&index).iter().all(|t| *t >= 4_000_000) && times(&index).len() > 20);
    assert!(times(&trace(&always, 0)).iter().any(|t| *t < 3_000_000));
    let contacts = |trace: &Trace| {
        let contact = |e: &&Event| matches!(e, Event::Contact(_));
        trace.events.iter().filter(contact).count()
    };
    assert_eq!(contacts(&index), contacts(&trace(&always, 0)));
    assert!((1..4).all(|n| entries(&trace(&bent, n)) == entries(&trace(&always, n))));
    let felt: Vec<_> = notes(&bent.trace)
        .into_iter()
        .filter(|n| n.contains("joint"))
        .collect();
    assert_eq!(
        felt,
        [
            "index: not felt: joint index_mcp",
            "index: felt: joint index_mcp"
        ]
    );
    let angles = |e: &Event| match e {
        Event::Joint(event::Joint { milli_deg, .. }) => Some(*milli_deg),
        _ => None,
    };
    let angles: Vec<i32> = bent.trace.events.iter().filter_map(angles).collect();
    // Once per frame of one finger, however many fingers there are.
    assert!((500..=600).contains(&angles.len()), "{}", angles.len());
    assert!(angles.is_sorted() && angles.last() == Some(&40_000));
}

/// Looks on, and ends the run after two seconds.
#[derive(Default)]
struct Watcher {
    began: usize,
    seen: BTreeMap<usize, usize>,
}

impl Host for Watcher {
    fn looks_on(&self) -> bool {
        true
    }

    fn begin(&mut self, _: &Beginning<'_>) -> Result<(), Failure> {
        self.began += 1;
        Ok(())
    }

    fn turn(&mut self, seen: &TurnView<'_>) -> bool {
        assert!(seen.counts.len() <= 4 * 24);
        *self.seen.entry(seen.display).or_insert(0) = seen.events.len();
        seen.now.as_micros() >= 2_000_000
    }
}

#[test]
fn every_display_can_be_looked_at_and_the_run_ended() {
    let setup = Setup::load("allegro-grasp", "allegro-hand").unwrap();
    let mut watcher = Watcher::default();
    let outcome = run_with(&setup, &Input::Scene, 1, Keep::default(), &mut watcher).unwrap();
    assert_eq!(watcher.began, 4);
    assert!(watcher.seen.len() == 4 && watcher.seen.values().all(|events| *events > 100));
    assert_eq!(outcome.summary.conclusion.verdict, Verdict::Stopped);
    let stopped = "stopped by the person who watched";
    let mut told = notes(&outcome.trace);
    // The wires were passed first, which each display tells.
    told.retain(|note| !note.contains("hot pass: "));
    assert_eq!(told, [stopped]);
    assert!(outcome.trace.ledger.length_us < 2_100_000);
}
