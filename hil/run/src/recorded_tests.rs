//! A recording shows what its run showed, at any moment, however that is reached.

use std::sync::{Arc, OnceLock};

use palpate_files::load_bench;
use palpate_records::mcap::{BusTraffic, McapRecording, write_mcap};

use super::*;
use crate::picture::Picture;
use crate::{Input, Keep, KeptReadings, attachments, run_with};

/// Four seconds of the circle, recorded.
fn bytes() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let scene = palpate_files::load_scene("sphere-circle").unwrap();
        let mut overrides = palpate_files::Overrides::default();
        overrides.set("--set", "length_s=4").unwrap();
        let scene = scene.with(&overrides).unwrap();
        let setup = Setup::join(scene, load_bench("emulated").unwrap()).unwrap();
        let keep = Keep {
            readings: KeptReadings::All,
            ..Keep::default()
        };
        let ran = run_with(&setup, &Input::Scene, 1, keep, &mut ()).unwrap();
        let mut bytes = Vec::new();
        let run = (&ran.trace, ran.readings.as_ref());
        let files = attachments(&setup);
        write_mcap(run, BusTraffic::default(), &files, &mut bytes).unwrap();
        bytes
    })
}

fn player() -> Player<&'static [u8], impl Fn(u64) -> &'static [u8]> {
    let recorded = Recorded::read("a.mcap", bytes()).unwrap();
    Player::new(Arc::new(recorded), |offset| &bytes()[offset as usize..])
}

#[test]
fn the_head_is_that_of_the_run() {
    let recorded = Recorded::read("a.mcap", bytes()).unwrap();
    let head = recorded.head();
    assert_eq!((head.scene.as_str(), head.seed), ("sphere-circle", 1));
    assert_eq!(head.source, "emulated");
    assert_eq!(head.scene_us, 4_000_000, "with the length that was set");
    assert_eq!(
        (head.wires_mm.len(), head.modules[0].taxels_mm.len()),
        (8, 16)
    );
    assert!(recorded.end_us() > 3_900_000, "{}", recorded.end_us());
    assert_eq!(recorded.damages(), [] as [String; 0]);
    assert_eq!(recorded.lacks(), [] as [&str; 0]);
}

#[test]
fn a_moment_is_the_same_however_it_is_reached() {
    let mut walked = player();
    let (mut reached, mut sofar) = (Vec::new(), Vec::new());
    for at_us in (0..4_000_000).step_by(100_000) {
        let Moment {
            picture, totals, ..
        } = walked.show(at_us).unwrap();
        sofar.push(totals);
        reached.push(picture);
    }
    assert!(sofar[39].stimuli > 50 && sofar[39].hottest_c.unwrap() > 30.0);
    assert!(reached.iter().any(|p| !p.felt.is_empty()));
    let mut reader = McapReader::of_run(bytes()).unwrap();
    let told = std::iter::from_fn(|| reader.told().unwrap());
    let is_frame = |told: &Told| {
        matches!(
            told,
            Told::Event(Event::Frame(event::Frame {
                t_us: ..=3_900_000,
                ..
            }))
        )
    };
    let all = told.filter(is_frame).count();
    assert_eq!(reached[39].frames as usize, all, "from the first on");
    for (number, expected) in reached.iter().enumerate().rev() {
        let mut fresh = player();
        let at_us = number as u64 * 100_000;
        let Moment {
            picture,
            past,
            totals,
        } = fresh.show(at_us).unwrap();
        assert_eq!(format!("{totals:?}"), format!("{:?}", sofar[number]));
        let past = past.unwrap();
        let now = |p: &Picture| {
            (
                p.now_us,
                p.frames,
                p.contacts.len(),
                format!("{:?}", p.warm),
            )
        };
        assert_eq!(now(&picture), now(expected));
        assert_eq!(picture.counts, expected.counts, "{at_us}");
        // What the last step brought is among what the page begins with.
        let bursts = |p: &Picture| {
            p.bursts
                .iter()
                .map(|b| (b.at_us, b.wire))
                .collect::<Vec<_>>()
        };
        let all = bursts(&picture);
        assert!(bursts(expected).iter().all(|b| all.contains(b)), "{at_us}");
        assert_eq!(past.from_us, 0);
        assert!(past.warm.is_sorted_by(|a, b| a.0 < b.0));
        assert!(
            past.warm.len() <= number + 2,
            "{} at {at_us}",
            past.warm.len()
        );
    }
    let there_and_back: Vec<_> = [3_000_000, 1_000_000, 3_000_000]
        .map(|at| walked.show(at).unwrap())
        .into_iter()
        .collect();
    assert!(there_and_back[0].past.is_some() && there_and_back[1].past.is_some());
    assert!(
        there_and_back[2].past.is_none(),
        "two seconds are gone on to"
    );
    assert_eq!(there_and_back[2].picture.counts, reached[30].counts);
}

#[test]
fn the_end_is_as_far_as_it_goes() {
    let mut player = player();
    let end = player.recorded.end_us();
    let last = player.show(u64::MAX).unwrap();
    assert_eq!(last.picture.now_us, end);
    let again = player.show(end).unwrap();
    assert!(again.past.is_none() && again.picture.bursts.is_empty());
}

#[test]
fn a_cut_recording_shows_what_is_there_and_says_so() {
    let cut = &bytes()[..bytes().len() * 3 / 5];
    let recorded = Recorded::read("a.mcap", cut).unwrap();
    assert!(
        recorded.damages()[0].contains("cut short"),
        "{:?}",
        recorded.damages()
    );
    assert!((500_000..3_900_000).contains(&recorded.end_us()));
    let mut player = Player::new(Arc::new(recorded), |offset| &cut[offset as usize..]);
    let last = player.show(u64::MAX).unwrap();
    assert!(last.picture.frames > 10);
}

#[test]
fn what_is_no_recording_of_a_run_is_refused_by_name() {
    let buses = McapRecording::of_buses(&["can0".into()], Vec::new()).unwrap();
    let buses = buses.finish().unwrap();
    for (bytes, words) in [
        (&b"hello"[..], ["a.mcap", "an MCAP file", "byte 0"]),
        (
            &bytes()[..200],
            ["a.mcap", "a recording of hil", "cut short"],
        ),
        (&buses, ["a recording of a run", "can0", "--replay a.mcap"]),
    ] {
        let said = Recorded::read("a.mcap", bytes).unwrap_err().to_string();
        for word in words {
            assert!(said.contains(word), "no `{word}` in: {said}");
        }
    }
}
