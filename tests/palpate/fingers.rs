//! Several displays: four fingertips of a hand on four thimbles, each felt and guarded alone.

use std::collections::{BTreeMap, BTreeSet};

use palpate_core::schedule::Entry;
use palpate_files::{Bench, Loaded, Overrides, Scene, Setup, Source, load_bench, load_scene};
use palpate_records::margin::Limited;
use palpate_records::schedule::write_schedule;
use palpate_records::story::Story;
use palpate_records::trace::{Event, Trace, event};
use palpate_run::{EmulatedSession, Input, Keep, Outcome, Policy, run, run_with};
use proptest::prelude::*;

use super::goldens::keep;

fn grasp() -> Outcome {
    let setup = Setup::load("allegro-grasp", "allegro-hand").unwrap();
    run(&setup, &Input::Scene, 1).unwrap()
}

/// The first six seconds of the grasp, with faults.
fn with(faults: &str) -> Outcome {
    let text = palpate_fixtures::scene("allegro-grasp").unwrap();
    let source = Source::new("scene.toml", format!("{text}\n{faults}"));
    let value = Scene::read(&source).unwrap();
    let scene = Loaded { value, source };
    let mut setup = Setup::join(scene, load_bench("allegro-hand").unwrap()).unwrap();
    setup.scene.value.length_s = 6.0;
    run(&setup, &Input::Scene, 1).unwrap()
}

pub fn entries(trace: &Trace) -> Vec<Entry> {
    let entry = |e: &Event| match e {
        Event::Schedule(entry) => Some(*entry),
        _ => None,
    };
    trace.events.iter().filter_map(entry).collect()
}

pub fn notes(trace: &Trace) -> Vec<&str> {
    let mut notes = Vec::new();
    for event in &trace.events {
        if let Event::Note(event::Note { text, .. }) = event {
            notes.push(text.as_str());
        }
    }
    notes
}

#[test]
fn four_fingertips_are_felt_at_once_within_the_limits() {
    let outcome = grasp();
    let s = &outcome.summary;
    assert!(outcome.failure.is_none(), "{:?}", outcome.failure);
    assert_eq!(
        (s.limiter_events, s.displays.len(), s.boards.len()),
        (0, 4, 15)
    );
    assert!(s.margins.iter().all(|m| m.used() <= 1.0), "{:?}", s.margins);
    for display in &s.displays {
        assert_eq!(
            (display.limiter_events, display.felt.breaks, display.stops),
            (0, Some(0), 0)
        );
        assert!(display.path_error_mm.unwrap().rmse < 0.5, "{display:?}");
        assert!(display.stimuli > 300, "{display:?}");
    }
    // The worst display heads the summary; sums are of all.
    let errors = s.displays.iter().map(|d| d.path_error_mm.unwrap().rmse);
    let worst = errors.fold(0.0, f64::max);
    assert!((s.path_error_mm.unwrap().rmse - worst).abs() < 1e-9);
    assert_eq!(s.stimuli, s.displays.iter().map(|d| d.stimuli).sum::<u64>());
    let supply = s.margins.iter().find(|m| m.of == Limited::SupplyCurrent);
    assert!((supply.unwrap().limit() - 4.0).abs() < 1e-9);
    assert!(s.peak_supply_a.unwrap() > 2.3, "{:?}", s.peak_supply_a);
    // Every pad is recorded, by its number in the skin.
    let mut touched: Vec<u16> = (outcome.trace.events.iter())
        .filter_map(|e| match e {
            Event::Contact(event::Contact { module, .. }) => Some(*module),
            _ => None,
        })
        .collect();
    touched.sort_unstable();
    touched.dedup();
    assert_eq!(touched, (0..15).collect::<Vec<u16>>());
}

#[test]
fn every_display_has_its_golden() {
    for display in grasp().displays {
        let name = format!("allegro-grasp-{}", display.name);
        keep(&name, "schedule", &Story::schedule(&display.outcome.trace));
    }
}

/// By the schedule, and by the pins: of each board one output at most is high.
#[test]
fn one_wire_of_a_board_is_on_at_a_time() {
    let outcome = grasp();
    let soa_us = outcome.trace.header.soa_us;
    let mut high: BTreeMap<u8, Vec<u8>> = BTreeMap::new();
    for event in &outcome.trace.events {
        match event {
            Event::Schedule(e) => {
                let turn = u64::from(e.channel.0 / 8);
                // The second board is written once the first one has been.
                let first = turn * soa_us / 2 + 1000 * u64::from(e.board.0);
                assert_eq!(e.at.as_micros() % soa_us, first, "{e:?}");
            }
            Event::Edge(event::Edge {
                board,
                channel,
                high: true,
                ..
            }) => {
                let on = high.entry(*board).or_default();
                on.push(*channel);
                assert_eq!(on.len(), 1, "{event:?} beside {on:?}");
            }
            Event::Edge(event::Edge { board, channel, .. }) => {
                high.entry(*board).or_default().retain(|c| c != channel);
            }
            _ => {}
        }
    }
    assert_eq!(high.len(), 2);
}

/// Both boards hang on one bus: no transfer begins before the last one has ended, and none is made to all boards at once.
#[test]
fn transfers_of_all_fingers_take_each_others_time() {
    let mut setup = Setup::load("allegro-grasp", "allegro-hand").unwrap();
    setup.scene.value.length_s = 4.0;
    let keep = Keep {
        i2c: true,
        ..Keep::default()
    };
    let outcome = run_with(&setup, &Input::Scene, 1, keep, &mut ()).unwrap();
    let of = |address: u8| outcome.i2c.iter().filter(|t| t.address == address).count();
    assert!(
        of(0x40) > 150 && of(0x41) > 150,
        "{} {}",
        of(0x40),
        of(0x41)
    );
    assert_eq!(of(0x40) + of(0x41), outcome.i2c.len());
    // Messages of one transaction have its time.
    let mut whole = outcome.i2c.clone();
    whole.dedup_by_key(|t| (t.start_ns, t.end_ns));
    for pair in whole.windows(2) {
        assert!(pair[0].end_ns <= pair[1].start_ns, "{pair:?}");
    }
    // A burst is written where it begins: nothing waits for another finger's.
    let writes = outcome.i2c.iter().filter(|t| t.data.len() > 4);
    let starts: BTreeSet<u64> = writes.map(|t| t.start_ns).collect();
    let driven = entries(&outcome.trace).into_iter().filter(|e| e.off > e.on);
    for entry in driven {
        let at = entry.at.as_micros() * 1000;
        assert!(starts.contains(&at), "{entry:?}");
    }
    // Each display's own record has the transfers to its boards.
    let index = &outcome.displays[0].outcome.i2c;
    assert!(index.len() == of(0x40) && index.iter().all(|t| t.address == 0x40));
}

/// A chip that falls back to reset values is one chip: both of its fingers notice, the other board's do not.
#[test]
fn a_board_that_browns_out_is_lost_to_both_of_its_fingers() {
    let (well, ill) = (
        with(""),
        with("[[faults]]\nat_s = 3.05\nkind = \"brown-out\"\nboard = 1"),
    );
    let [fault] = &ill.summary.faults[..] else {
        panic!("{:?}", ill.summary.faults);
    };
    assert_eq!((fault.kind, fault.count), ("brown-out", 1));
    assert!(ill.failure.is_none(), "{:?}", ill.failure);
    let told = notes(&ill.trace);
    let found = |name: &str| {
        let start = format!("{name}: actuators: board 1: register 0x00 reads");
        told.iter().any(|text| text.starts_with(&start))
    };
    // The one that finds out first starts the chip anew for both.
    assert!(found("ring") || found("thumb"), "{told:?}");
    assert!(!found("index") && !found("middle"), "{told:?}");
    for (number, (well, ill)) in well.displays.iter().zip(&ill.displays).enumerate() {
        if number < 2 {
            assert_eq!(entries(&well.outcome.trace), entries(&ill.outcome.trace));
        }
        let rises = |e: &&Event| matches!(e, Event::Edge(event::Edge { t_ns, high: true, .. }) if *t_ns > 4_000_000_000);
        assert!(ill.outcome.trace.events.iter().filter(rises).count() > 10);
    }
}

#[test]
fn the_schedule_says_which_outputs_are_whose() {
    let mut text = Vec::new();
    write_schedule(&grasp().trace, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    let header: serde_json::Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    let thumb = &header["displays"][3];
    assert_eq!(
        (&thumb["name"], &thumb["modules"]),
        (&"thumb".into(), &[12, 13, 14][..].into())
    );
    assert_eq!(thumb["outputs"][7], serde_json::json!([1, 15]));
    let starts = text.lines().filter(|l| l.contains("\"all_off\":\"start\""));
    assert_eq!(starts.count(), 2, "one per board");
}

/// Fingers without a common board, and fingers with one.
#[test]
fn a_display_whose_bus_is_dead_ends_alone() {
    let bench = load_bench("allegro-hand").unwrap();
    let bus = |display: &str, bus: u8, channels: std::ops::Range<u8>| {
        let output = |c| format!("{{ bus = {bus}, board = 0x40, channel = {c} }}");
        let outputs: Vec<String> = channels.map(output).collect();
        format!(
            "[[displays]]\nname = \"{display}\"\noutputs = [{}]\n",
            outputs.join(", ")
        )
    };
    let text = bench.source.text();
    let head = &text[..text.find("[[displays]]").unwrap()];
    let displays = [
        bus("index", 0, 0..8),
        bus("middle", 0, 8..16),
        bus("ring", 1, 0..8),
        bus("thumb", 1, 8..16),
    ];
    let source = Source::new("bench.toml", format!("{head}{}", displays.concat()));
    let value = Bench::read(&source).unwrap();
    let scene = |faults: &str| {
        let text = palpate_fixtures::scene("allegro-grasp").unwrap();
        let source = Source::new("scene.toml", format!("{text}\n{faults}"));
        let value = Scene::read(&source).unwrap();
        Loaded { value, source }
    };
    let played = |faults: &str| {
        let bench = Loaded {
            value: value.clone(),
            source: source.clone(),
        };
        let mut setup = Setup::join(scene(faults), bench).unwrap();
        setup.scene.value.length_s = 6.0;
        run(&setup, &Input::Scene, 1).unwrap()
    };
    let (well, ill) = (
        played(""),
        played("[[faults]]\nat_s = 3.0\nkind = \"i2c-stuck\"\nbus = 1"),
    );
    let failure = ill.failure.as_ref().unwrap();
    assert_eq!(failure.status(), 3);
    assert!(
        failure.to_string().starts_with("display `ring`: board 1: "),
        "{failure}"
    );
    for (display, (well, ill)) in ill
        .summary
        .displays
        .iter()
        .zip(well.displays.iter().zip(&ill.displays))
    {
        let dead = ["ring", "thumb"].contains(&&*display.name);
        assert_eq!(display.failure.is_some(), dead, "{display:?}");
        let same = entries(&well.outcome.trace) == entries(&ill.outcome.trace);
        assert_eq!(same, !dead, "{}", display.name);
    }
    let last = entries(&ill.displays[2].outcome.trace).last().unwrap().at;
    assert!(last.as_micros() < 3_117_000, "{last:?}");
    assert!(
        ill.summary.margins.iter().all(|m| !m.over()),
        "wires that are off cool"
    );
    assert!(super::faults::outputs_are_off(&ill));
}

/// A burst of the middle finger is under way when its input becomes stale: its guard stops it, and lets it go on when
/// frames come again. The others hear their own modules.
#[test]
fn a_finger_that_hears_nothing_is_stopped_alone() {
    let well = with("");
    let ill = with("[[faults]]\nat_s = 3.05\nuntil_s = 4.0\nkind = \"board-reboot\"\nmodule = 4");
    let stops: Vec<u64> = ill.summary.displays.iter().map(|d| d.stops).collect();
    assert_eq!(stops, [0, 1, 0, 0]);
    assert!(ill.failure.is_none());
    let told = notes(&ill.trace);
    assert!(told.contains(&"middle: stopped: stale-input"), "{told:?}");
    assert!(told.contains(&"fault: board-reboot module 4"), "{told:?}");
    for (number, (well, ill)) in well.displays.iter().zip(&ill.displays).enumerate() {
        let same = entries(&well.outcome.trace) == entries(&ill.outcome.trace);
        assert_eq!(same, number != 1, "{}", ill.name);
    }
    let after = entries(&ill.displays[1].outcome.trace);
    assert!(
        after.iter().any(|e| e.at.as_micros() > 4_500_000),
        "it is felt again"
    );
}

/// What is done to one finger, and which that is; the last are done to both on a board.
fn fault() -> impl Strategy<Value = (String, Vec<usize>)> {
    let skin = (
        0..15_usize,
        prop::sample::select(vec!["board-reboot", "wrong-model", "bus-off"]),
    );
    let skin = skin.prop_map(|(m, kind)| (format!("kind = \"{kind}\"\nmodule = {m}"), vec![m / 4]));
    let wire = (
        0..32_usize,
        prop::sample::select(vec!["open-wire", "amplifier-stuck-on"]),
    );
    let wire = wire.prop_map(|(w, kind)| (format!("kind = \"{kind}\"\nwire = {w}"), vec![w / 8]));
    let board = (0..2_usize).prop_map(|b| {
        (
            format!("kind = \"brown-out\"\nboard = {b}"),
            vec![2 * b, 2 * b + 1],
        )
    });
    prop_oneof![skin, wire, board]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    /// Whatever befalls a finger, no other one's schedule changes by a tick.
    #[test]
    fn fingers_fail_alone((fault, met) in fault(), at_ms in 2500..5000_u32) {
        let at_s = f64::from(at_ms) * 1e-3;
        let (well, ill) = (with(""), with(&format!("[[faults]]\nat_s = {at_s}\n{fault}")));
        for number in (0..4).filter(|n| !met.contains(n)) {
            let (well, ill) = (&well.displays[number].outcome, &ill.displays[number].outcome);
            prop_assert_eq!(entries(&well.trace), entries(&ill.trace));
            let edges = |t: &Trace| t.events.iter().filter(|e| matches!(e, Event::Edge(_))).cloned().collect::<Vec<_>>();
            prop_assert_eq!(edges(&well.trace), edges(&ill.trace));
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let message = |set: &[&str]| {
        let mut overrides = Overrides::default();
        set.iter()
            .for_each(|text| overrides.set("test", text).unwrap());
        let scene = load_scene("allegro-grasp")
            .unwrap()
            .with(&overrides)
            .unwrap();
        let bench = load_bench("allegro-hand")
            .unwrap()
            .with(&overrides)
            .unwrap();
        let setup = Setup::join(scene, bench).unwrap();
        run(&setup, &Input::Scene, 1).unwrap_err().to_string()
    };
    let close = message(&[
        "illusion.model=balanced",
        "illusion.soa_ms=60",
        "illusion.tau_d_ms=38",
    ]);
    assert!(
        close.contains("displays: expected at most 1 per board"),
        "{close}"
    );
    // Four fingertips of one hand share its power evenly.
    let mut setup = Setup::load("allegro-grasp", "allegro-hand").unwrap();
    setup.limits.value.limits.hand_60s_uw = 100_000;
    let weak = run(&setup, &Input::Scene, 1).unwrap_err();
    let expected = "hand_power.over_60s_mw: expected at least 120 mW: 4 displays on one hand with a moving contact of 30 mW each, found 100 mW";
    assert!(weak.to_string().contains(expected), "{weak}");
    assert_eq!(weak.status(), 2);
    // What runs one display says so.
    let setup = Setup::load("allegro-grasp", "allegro-hand").unwrap();
    let one = EmulatedSession::scene(&setup, 1, Policy::EMULATED)
        .err()
        .unwrap();
    assert!(
        one.to_string().contains("displays: expected one display"),
        "{one}"
    );
}
