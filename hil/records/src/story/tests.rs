//! A story's text fits a screen and is read back as the story it was.

use super::*;
use crate::synthetic;
use crate::trace::{Event, PlaceUm, event};

fn contacts_golden(trace: &Trace) -> String {
    Story::contacts(trace).text()
}

/// A surface of one point.
fn surface(trace: &Trace, point: [&str; 6]) -> Story {
    let mut story = Story::begun(GoldenKind::Surface, trace);
    story.table.rows.push(point.map(str::to_owned).into());
    story
}

fn readable(text: &str) {
    assert!(text.is_ascii());
    assert!(
        text.lines().count() <= LINES,
        "{} lines",
        text.lines().count()
    );
    for line in text.lines() {
        assert!(line.len() <= COLUMNS, "{line}");
    }
}

#[test]
fn goldens_stay_within_a_screen_whatever_the_length() {
    for seconds in [1, 10, 60] {
        let trace = synthetic::circle(seconds);
        for text in [contacts_golden(&trace), schedule_golden(&trace)] {
            readable(&text);
            assert!(text.contains("sphere-circle (emulated)"));
        }
    }
    let text = schedule_golden(&synthetic::circle(10));
    assert!(text.contains("196.888 Hz"), "{text}");
    assert!(text.contains("tau_d 35.000 ms, SOA 58.500 ms"));
    assert!(text.contains("wire-power"));
}

#[test]
fn empty_and_extreme_traces_still_make_goldens() {
    let mut trace = synthetic::empty();
    readable(&contacts_golden(&trace));
    readable(&schedule_golden(&trace));
    trace.header.taxels.clear();
    trace.header.wires.clear();
    trace.header.scene = "n\u{f6}\u{0}\n".repeat(90);
    trace.ledger.length_us = u64::MAX;
    trace.ledger.energy_uj = u64::MAX;
    trace.events.push(Event::Truth(event::Truth {
        t_us: u64::MAX,
        place: PlaceUm {
            x: i32::MAX,
            y: i32::MIN,
        },
        force_mn: 0,
    }));
    for text in [contacts_golden(&trace), schedule_golden(&trace)] {
        readable(&text);
        Story::read(&text).unwrap();
    }
}

#[test]
fn a_text_is_read_back_as_the_story_it_was() {
    // Short enough that every burst has its line.
    let trace = synthetic::circle(1);
    let energy_mj = "18446744073709551.615";
    let point = ["0.500", "7.050", "2.392", energy_mj, "-", "4294967295"];
    for story in [
        Story::schedule(&trace),
        Story::contacts(&trace),
        surface(&trace, point),
    ] {
        assert_eq!(Story::read(&story.text()).unwrap(), story);
    }
    // Of a long one, a text says as much as it shows.
    let long = Story::schedule(&synthetic::circle(60));
    let read = Story::read(&long.text()).unwrap();
    assert!(read.bursts_untold > 0 && read.happenings.len() <= long.happenings.len());
    assert_eq!(read.text(), long.text());
}

/// Git and editors of other systems leave a file like this.
#[test]
fn a_golden_behind_a_mark_with_lines_of_windows_is_the_same_golden() {
    let plain = schedule_golden(&synthetic::circle(1));
    let snapshot = format!("---\nsource: x\n---\n{plain}");
    for text in [&plain, &snapshot] {
        let windows = format!("\u{FEFF}{}", text.replace('\n', "\r\n"));
        assert_eq!(Story::read(&windows).unwrap(), Story::read(text).unwrap());
    }
}

#[test]
fn a_model_change_leaves_the_contact_golden_alone() {
    let trace = synthetic::circle(3);
    let mut other = trace.clone();
    other.ledger.energy_uj += 17;
    other.events.retain(|e| !matches!(e, Event::Wire(_)));
    assert_eq!(contacts_golden(&trace), contacts_golden(&other));
    assert_ne!(schedule_golden(&trace), schedule_golden(&other));
}

#[test]
fn a_surface_is_a_row_a_point() {
    let point = ["0.500", "7.050", "2.392", "17.000", "1.500", "3"];
    let text = surface(&synthetic::empty(), point).text();
    assert!(text.contains("7.050          2.392       17.000"), "{text}");
}

#[test]
fn damage_is_named_by_its_line() {
    let text = schedule_golden(&synthetic::circle(1));
    let lines: Vec<&str> = text.lines().collect();
    let line_of = |start: &str| lines.iter().position(|l| l.starts_with(start)).unwrap() + 1;
    let without = |n: usize| {
        let mut left = lines.clone();
        left.remove(n - 1);
        left.join("\n")
    };
    let mut row = lines.clone();
    row[line_of("ledger")] = "  stimuli                         many";
    for (text, line, word) in [
        (String::new(), 1, "the end of the file"),
        ("---\nsource: x".to_owned(), 3, "the end of the file"),
        (without(1), 1, "palpate schedule of"),
        (without(line_of("events:")), lines.len(), "events:"),
        (without(line_of("ledger")), line_of("ledger"), "ledger"),
        (row.join("\n"), line_of("ledger") + 1, "many"),
        (lines[..20].join("\n"), 21, "events:"),
        (without(lines.len()), lines.len(), "digest 2 of trace"),
        (
            format!("{text}\nmore"),
            lines.len() + 2,
            "the end of the file",
        ),
        (
            text.replace("bursts: ", "bursts: 1"),
            line_of("digest 2 of schedule"),
            "bursts above",
        ),
    ] {
        let damage = Story::read(&text).unwrap_err();
        assert_eq!(damage.line, line, "{damage}");
        assert!(damage.to_string().contains(word), "{word}: {damage}");
    }
}

/// A golden whose digests are of other bytes opens, and they are held against nothing.
#[test]
fn digests_of_an_earlier_version_are_not_compared() {
    let text = schedule_golden(&synthetic::circle(1));
    let old = text.replace("digest 2 of", "digest of");
    let (old, new) = (Story::read(&old).unwrap(), Story::read(&text).unwrap());
    assert!(old.digests.is_empty() && new.digests.len() == 2);
    let old = Story {
        digests: new.digests.clone(),
        ..old
    };
    assert_eq!(old, new);
}

/// A text says nothing but what its story holds, so that what is compared is all that it says.
#[test]
fn what_no_golden_has_there_is_refused() {
    let trace = synthetic::circle(1);
    let text = schedule_golden(&trace);
    let with = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    };
    let mut bursts = text.lines().skip_while(|line| !line.starts_with("bursts:"));
    let burst = bursts.nth(1).unwrap();
    let zeroed = format!("  0{}", burst.trim_start());
    for (text, word) in [
        (with("seed 7", "sead 7"), "`seed ..` in the header"),
        (with("tau_d 35", "tau-d 35"), "`tau_d ..` in the header"),
        (with("value   ", "valua   "), "value"),
        (with(" %\n", " &\n"), "%"),
        (with("0.500 s ", "0.500..0.500 s "), "0.500 s"),
        (
            with("it is not 35", "it is not 36"),
            "where it is not 35.000 ms",
        ),
        (with(burst, &zeroed), "an onset"),
        (
            with("\n     1     0:1", "\n     0     0:1"),
            "each row once",
        ),
        (
            with("  hottest wire    ", "  energy          "),
            "each figure once",
        ),
    ] {
        let damage = Story::read(&text).unwrap_err();
        assert!(damage.to_string().contains(word), "{word}: {damage}");
    }
}

/// Before units stood in their own column, the ledger had another heading and contacts were told in words.
#[test]
fn goldens_of_an_earlier_version_open_with_what_has_not_changed() {
    let trace = synthetic::circle(1);
    let text = schedule_golden(&trace);
    let start = text.find("ledger ").unwrap();
    let end = text.find("bursts: ").unwrap();
    let old = "ledger                          value           limit\n  stimuli   0   -\n\nwire  output\n\n";
    let old = Story::read(&format!("{}{old}{}", &text[..start], &text[end..])).unwrap();
    let new = Story::read(&text).unwrap();
    assert!(old.partial && !new.partial);
    assert_eq!((&old.bursts, &old.chart), (&new.bursts, &new.chart));
    assert!(!old.digests.contains_key("trace") && new.digests.contains_key("trace"));
    let text = contacts_golden(&trace);
    let start = text.find("  contact  from").unwrap();
    let end = text.find("digest 2 of").unwrap();
    let old = format!(
        "{}contacts: 1\n  0/1  0.8..9.9 s\n{}",
        &text[..start],
        &text[end..]
    );
    assert!(Story::read(&old).unwrap().partial);
}
