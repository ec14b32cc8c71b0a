//! Tests of records: what is read and what is refused, and what a program that goes on takes over.

use palpate_files::load_protocol;
use serde_json::json;

use super::*;
use crate::session::Answer;

const KILLED: &str = "killed";

fn protocol() -> Protocol {
    load_protocol("thresholds").unwrap().value
}

fn uptime(start: &str, ms: u64) -> Uptime {
    Uptime {
        start: Some(start.into()),
        ms,
    }
}

fn about() -> About {
    About {
        version: VERSION,
        palpate: "0".into(),
        protocol: "thresholds".into(),
        protocol_digest: "p".into(),
        participant: 1,
        seed: 1,
        bench: "emulated".into(),
        source: "emulated".into(),
        limits_digest: "l".into(),
        wires_mm: vec![[0.0, 1.0]; 8],
        began: String::new(),
        began_unix_ms: 0,
        uptime: uptime("a", 50_000),
        simulated: false,
        dose_planned: 0.5,
    }
}

/// Half a second from when it begins, in which a wire is on for 35 ms.
fn interval(began_ms: u64) -> Interval {
    Interval {
        stimulus: Some(Stimulus::Wire {
            wire: 1,
            level_db: -3.0,
        }),
        began_ms,
        path: vec![[0.0, 1.0, 2.0]],
        bursts: vec![[1, 465_000, 500_000, 2_500_000]],
        ..Interval::default()
    }
}

/// A session of so many trials, ten seconds each: booked, played, answered.
fn lines(trials: u64) -> Vec<Line> {
    let mut session = Session::new(protocol(), 1, 1);
    let mut lines = vec![Line::Session(about())];
    for began_ms in (0..trials).map(|n| 1000 + 10_000 * n) {
        let Step::Trial(trial) = session.step().clone() else {
            panic!("no trial");
        };
        let interval = interval(began_ms);
        let reply = Reply::Answer(Answer::Interval(1));
        session.take(&reply).unwrap();
        lines.push(Line::Playing(Playing {
            at_ms: began_ms,
            number: trial.number,
            attempt: trial.attempt,
            interval: interval.clone(),
        }));
        lines.push(Line::Reply(Said {
            at_ms: began_ms + 5000,
            reply,
            trial: Some(Played {
                intervals: vec![interval],
                asked_ms: began_ms + 2000,
                ..Played::new(&trial)
            }),
        }));
    }
    lines
}

fn text(lines: &[Line]) -> String {
    let line = |line: &Line| serde_json::to_string(line).unwrap() + "\n";
    lines.iter().map(line).collect()
}

fn read(lines: &[Line]) -> Record {
    Record::read(&text(lines)).unwrap()
}

/// Whether a session goes on from them.
fn goes_on(lines: &[Line]) -> bool {
    let record = Record::read(&text(lines));
    record.is_ok_and(|record| record.resumed(protocol()).is_ok())
}

#[test]
fn a_line_that_is_missing_or_stands_there_twice_is_found() {
    let all = lines(4);
    assert!(goes_on(&all));
    for at in 0..all.len() {
        let mut twice = all.clone();
        twice.insert(at, all[at].clone());
        assert!(!goes_on(&twice), "line {} twice", at + 1);
        let mut later = all.clone();
        later.push(all[at].clone());
        assert!(!goes_on(&later), "line {} again at the end", at + 1);
        let mut fewer = all.clone();
        let gone = fewer.remove(at);
        let is_needed = matches!(gone, Line::Session(_) | Line::Reply(_)) && at + 1 < all.len();
        assert_eq!(goes_on(&fewer), !is_needed, "without line {}", at + 1);
    }
    let mut swapped = all;
    swapped.swap(2, 4);
    assert!(!goes_on(&swapped));
}

#[test]
fn a_number_beyond_its_bounds_is_found_by_its_line() {
    let all = lines(2);
    let whole: Vec<Value> = all
        .iter()
        .map(|l| serde_json::to_value(l).unwrap())
        .collect();
    let burst = "/reply/trial/intervals/0/bursts/0";
    let booked = "/playing/interval/bursts/0";
    for (line, place, number) in [
        (
            0,
            "/session/participant".to_owned(),
            json!(4_000_000_000_u32),
        ),
        (0, "/session/began_unix_ms".into(), json!(u64::MAX)),
        (0, "/session/uptime/ms".into(), json!(u64::MAX)),
        (0, "/session/dose_planned".into(), json!(1e300)),
        (0, "/session/wires_mm/3/1".into(), json!(-1e300)),
        (1, "/playing/at_ms".into(), json!(u64::MAX)),
        (1, "/playing/number".into(), json!(u32::MAX)),
        (1, "/playing/attempt".into(), json!(u32::MAX)),
        (1, "/playing/interval/began_ms".into(), json!(u64::MAX)),
        (1, format!("{booked}/0"), json!(8)),
        (1, format!("{booked}/2"), json!(u64::MAX)),
        (2, "/reply/at_ms".into(), json!(u64::MAX)),
        (2, "/reply/trial/number".into(), json!(u32::MAX)),
        (2, "/reply/trial/attempt".into(), json!(u32::MAX)),
        (2, "/reply/trial/right".into(), json!(3)),
        (2, "/reply/trial/asked_ms".into(), json!(u64::MAX)),
        (2, "/reply/trial/level_db".into(), json!(-1e9)),
        (
            2,
            "/reply/trial/intervals/0/stimulus/wire/wire".into(),
            json!(8),
        ),
        (
            2,
            "/reply/trial/intervals/0/stimulus/wire/level_db".into(),
            json!(1e9),
        ),
        (
            2,
            "/reply/trial/intervals/0/began_ms".into(),
            json!(u64::MAX),
        ),
        (2, "/reply/trial/intervals/0/path/0/2".into(), json!(1e300)),
        (2, format!("{burst}/0"), json!(u64::MAX)),
        (2, format!("{burst}/1"), json!(u64::MAX)),
        (2, format!("{burst}/2"), json!(u64::MAX)),
        (2, format!("{burst}/3"), json!(u64::MAX)),
    ] {
        let mut changed = whole.clone();
        *changed[line].pointer_mut(&place).unwrap() = number;
        let text: String = changed.iter().map(|line| format!("{line}\n")).collect();
        match Record::read(&text) {
            Err(RecordError::Line { line: found, .. }) => assert_eq!(found, line + 1, "{place}"),
            other => panic!("{place}: {other:?}"),
        }
    }
    let mut many = all;
    let Some(Line::Reply(Said {
        trial: Some(of), ..
    })) = many.get_mut(2)
    else {
        panic!("no reply");
    };
    of.intervals = vec![interval(0); 3];
    assert!(Record::read(&text(&many)).is_err());
}

#[test]
fn what_was_booked_and_has_no_reply_is_open() {
    let mut all = lines(3);
    assert!(read(&all).open().is_empty());
    all.pop();
    let began_ms = 21_000;
    assert_eq!(read(&all).open(), [interval(began_ms)]);
    // It stays so however often a program begins again and is killed.
    for n in 1..3 {
        all.push(Line::Resumed(Resumed {
            at_ms: began_ms + 1000 * n,
            palpate: "0".into(),
            uptime: uptime("a", 0),
        }));
        assert_eq!(read(&all).open(), [interval(began_ms)]);
    }
    let record = read(&all);
    let Step::Trial(trial) = record.resumed(protocol()).unwrap().step().clone() else {
        panic!("no trial");
    };
    all.push(Line::Reply(Said {
        at_ms: began_ms + 9000,
        reply: Reply::Void(KILLED.into()),
        trial: Some(Played {
            intervals: record.open(),
            ..Played::new(&trial)
        }),
    }));
    assert!(goes_on(&all) && read(&all).open().is_empty());
}

#[test]
fn time_passes_by_the_uptime_of_one_start_alone() {
    let mut all = lines(2);
    let now = |all: &[Line], uptime: Uptime| read(all).now_ms(&uptime);
    // The last line is at 16 s; the session began 50 s after the computer.
    assert_eq!(now(&all, uptime("a", 66_000)), 16_000);
    assert_eq!(now(&all, uptime("a", 90_000)), 40_000);
    // A computer that was started anew, another one, and one that does not say.
    assert_eq!(now(&all, uptime("b", 9_000_000)), 16_000);
    assert_eq!(now(&all, uptime("a", 3)), 16_000);
    let unknown = Uptime {
        start: None,
        ms: 9_000_000,
    };
    assert_eq!(now(&all, unknown.clone()), 16_000);
    // What was begun last is not over before its last burst.
    all.pop();
    assert_eq!(now(&all, unknown.clone()), 11_500);
    // From a start on that is known, time goes on.
    all.push(Line::Resumed(Resumed {
        at_ms: 12_000,
        palpate: "0".into(),
        uptime: uptime("b", 7_000),
    }));
    assert_eq!(now(&all, uptime("b", 17_000)), 22_000);
    assert_eq!(now(&all, uptime("a", 90_000)), 12_000);
    // Two that do not know their start have none in common.
    assert_eq!(unknown.since(&unknown), None);
}

#[test]
fn another_session_does_not_go_on_with_a_record() {
    let own = about();
    assert_eq!(own.differs(&own), None);
    let later = About {
        palpate: "1".into(),
        began: "later".into(),
        began_unix_ms: 7,
        uptime: Uptime::default(),
        dose_planned: 0.1,
        ..about()
    };
    assert_eq!(own.differs(&later), None);
    type Change = fn(&mut About);
    let changes: [(&str, Change); 8] = [
        ("protocol", |of| of.protocol_digest = "q".into()),
        ("participant", |of| of.participant = 2),
        ("seed", |of| of.seed = 2),
        ("bench", |of| of.bench = "thesis".into()),
        ("kind of bench", |of| of.source = "real".into()),
        ("limits", |of| of.limits_digest = "m".into()),
        ("places of wires", |of| of.wires_mm[2][0] = 0.5),
        ("person", |of| of.simulated = true),
    ];
    for (what, change) in changes {
        let mut other = about();
        change(&mut other);
        let said = own.differs(&other).unwrap();
        let expected = format!("expected the {what} with which");
        assert!(said.starts_with(&expected), "{what}: {said}");
    }
}

#[test]
fn a_record_of_another_version_is_refused_by_its_version() {
    let mut head = serde_json::to_value(Line::Session(about())).unwrap();
    head["session"]["version"] = json!(1);
    head["session"].as_object_mut().unwrap().remove("uptime");
    let read = Record::read(&format!("{head}\n{{\"resumed\":{{}}}}\n"));
    assert_eq!(read, Err(RecordError::Version(1)));
}
