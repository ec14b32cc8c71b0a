//! The policy of a real bench, tried against emulated devices in virtual time: the same session that drives
//! hardware, with the same values, and a clock that a test moves by hand.

use palpate_core::guard::Cause;
use palpate_core::units::Instant;
use palpate_files::{BenchKind, Loaded, Scene, Setup, Source, load_bench};
use palpate_records::trace::{Event, event};
use palpate_run::{EmulatedSession, Input, Policy, TaxelTable, Turn, press, run};

/// A rolling sphere with one fault.
fn setup(fault: &str) -> Setup {
    let text = palpate_fixtures::scene("sphere-along").unwrap();
    let source = Source::new("scene.toml", format!("{text}\n[[faults]]\n{fault}"));
    let value = Scene::read(&source).unwrap();
    Setup::join(Loaded { value, source }, load_bench("emulated").unwrap()).unwrap()
}

fn session(fault: &str, policy: Policy) -> EmulatedSession {
    let mut session = EmulatedSession::scene(&setup(fault), 1, policy).unwrap();
    session.start(Instant::ZERO).unwrap();
    session
}

const fn at(ms: u64) -> Instant {
    Instant::from_micros(ms * 1000)
}

fn note(event: &Event) -> Option<&str> {
    match event {
        Event::Note(event::Note { text, .. }) => Some(text),
        _ => None,
    }
}

fn notes(events: &[Event]) -> Vec<&str> {
    events.iter().filter_map(note).collect()
}

/// Pulses that began in a stretch of time.
fn pulses(events: &[Event], from: Instant, to: Instant) -> usize {
    let (from, to) = (from.as_micros() * 1000, to.as_micros() * 1000);
    let rises = |e: &&Event| matches!(e, Event::Edge(event::Edge { t_ns, high: true, .. }) if (from..to).contains(t_ns));
    events.iter().filter(rises).count()
}

/// A skin that falls silent while a wire is driven stops the run until a person has looked; the emulated bench
/// goes on by itself.
#[test]
fn a_stop_stays_on_a_real_bench_and_ends_on_an_emulated_one() {
    // A burst begins at 2.106 s, while the skin is not yet stale.
    let silent = "at_s = 2.06\nuntil_s = 2.6\nkind = \"frames-lost\"\nrate = 1.0";
    let run = |policy| {
        let mut session = session(silent, policy);
        assert!(matches!(session.advance(at(4000)).unwrap(), Turn::Next(_)));
        let latched = session.projector().guard().latched();
        let failure = session.failure().map(|f| (f.status(), f.to_string()));
        (session.drain().0, latched, failure)
    };
    let (events, latched, failure) = run(Policy::REAL);
    assert_eq!(latched, Some(Cause::StaleInput));
    let (status, text) = failure.unwrap();
    assert!(status == 4 && text.contains("no sensor frame"), "{text}");
    assert!(pulses(&events, at(1000), at(2000)) > 20);
    assert_eq!(pulses(&events, at(2200), at(4000)), 0);
    // The skin is still read: its frames are there after the stop.
    let late =
        |e: &&Event| matches!(e, Event::Frame(event::Frame { t_us, .. }) if *t_us > 3_000_000);
    assert!(events.iter().filter(late).count() > 90);

    let (events, latched, failure) = run(Policy::EMULATED);
    assert!(latched.is_none() && failure.is_none(), "{failure:?}");
    assert!(notes(&events).iter().any(|n| n.contains("stop ended")));
    assert!(pulses(&events, at(3000), at(4000)) > 10);
}

/// A plug that is pulled for a second: a real bench waits for it, an emulated one gives up.
#[test]
fn a_real_bench_waits_longer_for_a_dead_actuator_bus() {
    let pulled = "at_s = 1.5\nuntil_s = 2.5\nkind = \"i2c-stuck\"";
    let mut real = session(pulled, Policy::REAL);
    assert!(matches!(real.advance(at(4000)).unwrap(), Turn::Next(_)));
    assert!(real.failure().is_none());
    let (events, _) = real.drain();
    assert!(notes(&events).iter().any(|n| n.contains("started anew")));
    assert_eq!(pulses(&events, at(1600), at(2500)), 0);
    assert!(pulses(&events, at(3000), at(4000)) > 10);

    let mut emulated = session(pulled, Policy::EMULATED);
    assert_eq!(emulated.advance(at(4000)).unwrap(), Turn::Last);
    assert_eq!(emulated.failure().unwrap().status(), 3);
    assert!(emulated.now() < at(1800));
}

/// A bus that is dead when the run begins: a person has to hear of it at once.
#[test]
fn a_real_bench_refuses_to_start_without_its_boards() {
    let dead = "at_s = 0.0\nkind = \"i2c-stuck\"";
    let mut real = EmulatedSession::scene(&setup(dead), 1, Policy::REAL).unwrap();
    assert!(real.start(Instant::ZERO).is_err());
}

/// A chip that falls back to reset values is found by reading registers back, by the same line on every bench.
#[test]
fn a_brown_out_is_found_by_the_real_policy() {
    let mut real = session("at_s = 1.52\nkind = \"brown-out\"\nboard = 0", Policy::REAL);
    real.advance(at(4000)).unwrap();
    let (events, _) = real.drain();
    let found = |n: &&str| n.contains("register 0x00 reads 0x11, expected 0x21");
    assert!(notes(&events).iter().any(found));
    assert!(real.failure().is_none() && pulses(&events, at(2500), at(4000)) > 10);
}

/// A hand's session: what is touched is felt, it can be held and moved to another thread between two turns, and it
/// stays as large as it is.
#[test]
fn a_hand_is_felt_and_a_session_has_no_end() {
    let setup = Setup::load("idle", "emulated").unwrap();
    let (mut session, hands) = EmulatedSession::touched(&setup, 1).unwrap();
    session.start(Instant::ZERO).unwrap();
    session.advance(at(1000)).unwrap();
    hands[0].press(&[press(1.0, -2.0, 1.0, 10.0)]);
    let (events, _) = std::thread::spawn(move || {
        session.advance(at(3000)).unwrap();
        session.drain()
    })
    .join()
    .unwrap();
    let felt = |e: &Event| match e {
        Event::Felt(event::Felt {
            met: Some(met),
            target,
            ..
        }) => Some((met.energy, *target)),
        _ => None,
    };
    let all: Vec<_> = events.iter().filter_map(felt).collect();
    assert!(all.len() > 12, "{}", all.len());
    for (felt, target) in all {
        let off = f64::from(felt.x - target.x).hypot(f64::from(felt.y - target.y));
        assert!(off < 5000.0, "{felt:?} for {target:?}");
    }
}

#[test]
fn events_that_nothing_drains_are_dropped_and_counted() {
    let setup = Setup::load("allegro-four-buses", "emulated").unwrap();
    let mut session = EmulatedSession::scene(&setup, 1, Policy::EMULATED).unwrap();
    session.start(Instant::ZERO).unwrap();
    session.advance(at(20_000)).unwrap();
    let held = session.recorder().events.len();
    session.advance(at(400_000)).unwrap();
    let (events, dropped) = session.drain();
    assert!(events.len() <= 1 << 16, "{held} then {}", events.len());
    assert!(dropped > 0, "{held} then {}", events.len());
}

/// A skin without boards is touched like any other.
#[test]
fn a_camera_is_felt_under_a_scene_and_under_a_hand() {
    let setup = Setup::load("digit-circle", "emulated").unwrap();
    let mut scene = EmulatedSession::scene(&setup, 1, Policy::EMULATED).unwrap();
    let (mut touched, hands) = EmulatedSession::touched(&setup, 1).unwrap();
    for session in [&mut scene, &mut touched] {
        session.start(Instant::ZERO).unwrap();
        // Thirty pictures make the reference.
        session.advance(at(1500)).unwrap();
    }
    hands[0].press(&[press(0.0, 0.0, 0.3, 4.0)]);
    for session in [&mut scene, &mut touched] {
        session.advance(at(4000)).unwrap();
        let (events, _) = session.drain();
        let contact = |e: &&Event| matches!(e, Event::Contact(_));
        assert!(events.iter().filter(contact).count() > 50);
        assert!(pulses(&events, at(2000), at(4000)) > 10);
    }
}

/// Readings of a skin without boards enter as they are.
#[test]
fn pushed_readings_are_felt() {
    use palpate_core::skin::ModuleScan;

    let setup = Setup::load("idle", "emulated").unwrap();
    let mut session = EmulatedSession::fed(&setup, 1).unwrap();
    session.start(Instant::ZERO).unwrap();
    let mut counts = [[30_000_u16; 3]; 16];
    for scan in 1..400_u64 {
        let now = at(10 * scan);
        // A flicker of one count: a skin that stands still is ill.
        for (taxel, c) in counts.iter_mut().enumerate() {
            c[2] = 30_000 + ((scan + taxel as u64) % 3) as u16;
        }
        if scan > 100 {
            counts[5][2] += 900;
        }
        session.push(&ModuleScan::whole(0, now, &counts)).unwrap();
        session
            .advance(now + palpate_core::units::Duration::from_millis(10))
            .unwrap();
    }
    assert!(session.push(&ModuleScan::whole(3, at(0), &counts)).is_err());
    assert!(
        session
            .push(&ModuleScan::whole(0, at(0), &counts[..4]))
            .is_err()
    );
    let (events, dropped) = session.drain();
    assert_eq!(dropped, 0);
    let contact = |e: &&Event| matches!(e, Event::Contact(_));
    assert!(events.iter().filter(contact).count() > 250);
    assert!(pulses(&events, at(1500), at(4000)) > 10);
}

/// Hardware is the program's: emulators that record `source: real` would be believed.
#[test]
fn a_bench_of_hardware_is_refused_by_every_emulated_session() {
    let mut setup = Setup::load("idle", "emulated").unwrap();
    setup.bench.value.kind = BenchKind::Real;
    let refused = [
        run(&setup, &Input::Scene, 1).err(),
        EmulatedSession::scene(&setup, 1, Policy::REAL).err(),
        EmulatedSession::touched(&setup, 1).err(),
        EmulatedSession::fed(&setup, 1).err(),
    ];
    for failure in refused {
        let failure = failure.unwrap();
        let text = failure.to_string();
        assert!(
            failure.status() == 2 && text.contains("found \"real\""),
            "{text}"
        );
    }
}

/// Tables from an array are checked as files are: a short one must not hang, a clock that goes back not panic.
#[test]
fn tables_that_are_none_are_refused() {
    let setup = Setup::load("idle", "emulated").unwrap();
    let table = |times: Vec<u64>, counts: usize, columns: usize| TaxelTable {
        time_us: times,
        counts: vec![30_000; counts],
        columns,
    };
    let up = || (0..80_u64).map(|row| row * 10_000).collect::<Vec<_>>();
    let mut back = up();
    back[79] = 3;
    for (tables, expected) in [
        (vec![], "expected 1 tables"),
        (
            vec![table(up(), 80 * 48, 47)],
            "expected 48 columns, found 47",
        ),
        (
            vec![table(up(), 79 * 48, 48)],
            "expected 80 rows of 48 counts",
        ),
        (
            vec![table(back, 80 * 48, 48)],
            "expected a time from 780000 us on in row 79",
        ),
        (
            vec![table(up()[..9].to_vec(), 9 * 48, 48)],
            "reference rows, found 9",
        ),
    ] {
        let failure = run(&setup, &Input::tables(tables), 1).unwrap_err();
        assert!(failure.to_string().contains(expected), "{failure}");
    }
    let good = Input::tables(vec![table(up(), 80 * 48, 48)]);
    assert!(run(&setup, &good, 1).unwrap().failure.is_none());
}
