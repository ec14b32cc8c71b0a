//! Tests of `folder.rs`.

use palpate_study::{About, Answer, Noted, Played, Reply, Said, Session, Uptime, VERSION};

use super::*;

fn empty(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("palpate-study-{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&path);
    path
}

fn about(participant: u32) -> Line {
    Line::Session(About {
        version: VERSION,
        palpate: "0".into(),
        protocol: "thresholds".into(),
        protocol_digest: String::new(),
        participant,
        seed: 1,
        bench: "emulated".into(),
        source: "emulated".into(),
        limits_digest: String::new(),
        wires_mm: vec![[0.0, 0.0]],
        began: String::new(),
        began_unix_ms: 0,
        uptime: Uptime::default(),
        simulated: true,
        dose_planned: 0.0,
    })
}

fn begun(name: &str) -> (PathBuf, Folder, Loaded<Protocol>) {
    let path = empty(name);
    let protocol = load_protocol("thresholds").unwrap();
    let folder = Folder::make(&path, &protocol).unwrap();
    (path, folder, protocol)
}

/// The next trial's answer, as a session says it.
fn answer(session: &mut Session, writing: &Writing) -> Line {
    let Step::Trial(trial) = session.step().clone() else {
        panic!("no trial");
    };
    let reply = Reply::Answer(Answer::Interval(1));
    session.take(&reply).unwrap();
    Line::Reply(Said {
        at_ms: writing.stamp(7),
        reply,
        trial: Some(Played::new(&trial)),
    })
}

#[test]
fn a_number_is_taken_while_its_session_goes_on_and_after_it_is_over() {
    let (path, folder, protocol) = begun("taken");
    let mut writing = folder.participant(3, false).unwrap();
    let said = folder.participant(3, true).unwrap_err().to_string();
    assert!(said.contains("that goes on"), "{said}");
    writing.add(about(3)).unwrap();
    let mut session = Session::new(protocol.value.clone(), 3, 1);
    let line = answer(&mut session, &writing);
    writing.add(line).unwrap();
    drop(writing);
    let said = folder.participant(3, false).unwrap_err().to_string();
    assert!(
        said.contains("--participant 3") && said.contains("--resume"),
        "{said}"
    );
    let mut writing = folder.participant(3, true).unwrap();
    assert_eq!(writing.record.as_ref().unwrap().lines.len(), 1);
    while !matches!(session.step(), Step::Done) {
        let line = answer(&mut session, &writing);
        writing.add(line).unwrap();
    }
    drop(writing);
    let said = folder.participant(3, true).unwrap_err().to_string();
    assert!(said.contains("that is over"), "{said}");
    assert_eq!(folder.records().unwrap().len(), 1);
    fs::remove_dir_all(path).unwrap();
}

#[test]
fn a_line_that_was_being_written_when_the_program_died_is_cut_off() {
    let (path, folder, protocol) = begun("torn");
    let mut writing = folder.participant(1, false).unwrap();
    writing.add(about(1)).unwrap();
    let mut session = Session::new(protocol.value, 1, 1);
    let line = answer(&mut session, &writing);
    writing.add(line).unwrap();
    writing
        .add(Line::Note(Noted {
            at_ms: 9,
            text: "a note".into(),
        }))
        .unwrap();
    drop(writing);
    let file = path.join("records/participant-1.jsonl");
    let whole = fs::read(&file).unwrap();
    // Killed at any byte of the last line.
    let last = whole[..whole.len() - 1]
        .iter()
        .rposition(|b| *b == b'\n')
        .unwrap()
        + 1;
    for cut in [last, last + 1, whole.len() - 1] {
        fs::write(&file, &whole[..cut]).unwrap();
        let mut writing = folder.participant(1, true).unwrap();
        assert_eq!(writing.record.as_ref().unwrap().lines.len(), 1, "{cut}");
        writing
            .add(Line::Note(Noted {
                at_ms: 9,
                text: "a note".into(),
            }))
            .unwrap();
        drop(writing);
        assert_eq!(fs::read(&file).unwrap(), whole, "{cut}");
    }
    // Within a letter.
    fs::write(&file, [&whole[..], &[0xc3]].concat()).unwrap();
    drop(folder.participant(1, true).unwrap());
    assert_eq!(fs::read(&file).unwrap(), whole);
    fs::remove_dir_all(path).unwrap();
}

#[test]
fn a_record_is_that_of_the_participant_in_its_name() {
    let (path, folder, _) = begun("renamed");
    let mut writing = folder.participant(3, false).unwrap();
    writing.add(about(3)).unwrap();
    drop(writing);
    let file = |number: u32| path.join(format!("records/participant-{number}.jsonl"));
    fs::copy(file(3), file(4)).unwrap();
    for said in [
        folder.participant(4, true).unwrap_err().to_string(),
        folder.records().unwrap_err().to_string(),
    ] {
        assert!(said.contains("participant-4.jsonl: line 1"), "{said}");
        assert!(said.contains("found 3"), "{said}");
    }
    fs::remove_dir_all(path).unwrap();
}

#[test]
fn each_line_has_a_time_of_its_own() {
    let (path, folder, _) = begun("stamps");
    let mut writing = folder.participant(1, false).unwrap();
    assert_eq!(writing.stamp(0), 1);
    writing.add(about(1)).unwrap();
    for (now_ms, expected) in [(0, 1), (0, 2), (9, 9), (3, 10)] {
        let at_ms = writing.stamp(now_ms);
        assert_eq!(at_ms, expected);
        let text = "a note".to_owned();
        writing.add(Line::Note(Noted { at_ms, text })).unwrap();
    }
    drop(writing);
    assert_eq!(folder.records().unwrap()[0].lines.len(), 4);
    fs::remove_dir_all(path).unwrap();
}

#[test]
fn another_protocol_wants_a_folder_of_its_own() {
    let (path, _, _) = begun("other");
    let other = load_protocol("roughness").unwrap();
    let said = Folder::make(&path, &other).unwrap_err().to_string();
    assert!(said.contains("protocol.toml"), "{said}");
    fs::remove_dir_all(&path).unwrap();
    assert!(Folder::open(&path).is_err());
}

#[test]
fn a_full_disk_is_said_with_the_file() {
    let writing = OpenOptions::new().read(true).write(true).open("/dev/full");
    let Ok(file) = writing else {
        return; // a system without it
    };
    let mut writing = Writing {
        folder: Folder {
            path: PathBuf::new(),
        },
        participant: 1,
        path: "/dev/full".into(),
        file,
        record: None,
    };
    let failure = writing.add(about(1)).unwrap_err();
    assert_eq!(failure.status(), 3);
    assert!(
        failure
            .to_string()
            .contains("/dev/full: cannot be written: No space left"),
        "{failure}"
    );
    assert!(writing.record.is_none());
}
