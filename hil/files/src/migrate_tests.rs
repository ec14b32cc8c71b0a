//! Tests of `migrate.rs`.

use super::*;
use crate::check_source;

const HEADING: &str = "name = \"mine\"\ndescription = \"d\" # a remark\n";

fn texts(body: &str) -> (String, usize) {
    let source = Source::new("f.toml", format!("{HEADING}{body}"));
    let found = migrated(&source, None).unwrap().unwrap();
    let checked = check_source(Source::new("f.toml", &*found.text));
    assert_eq!(checked.errors, [], "{}", found.text);
    assert!(found.text.starts_with(HEADING), "{}", found.text);
    (found.text, found.changes.len())
}

#[test]
fn a_key_that_went_becomes_a_comment_wherever_it_stands() {
    for body in [
        "length_s = 2.0\n[illusion]\nsmallest_step = 0.2 # felt\nmodel = \"energy\"\n",
        "length_s = 2.0\nillusion.smallest_step = 0.2\n",
        "length_s = 2.0\nillusion = { smallest_step = 0.2, model = \"energy\" }\n",
        "length_s = 2.0\nillusion = { model = \"energy\", smallest_step = 0.2 }\n",
    ] {
        let (text, changes) = texts(body);
        assert_eq!(changes, 1, "{text}");
        let energy = |text: &str| text.contains("model = \"energy\"");
        assert_eq!(energy(&text), energy(body), "{text}");
    }
    let (text, _) = texts("length_s = 2.0\nillusion.smallest_step = 0.2\n");
    assert!(
        text.ends_with("\n# illusion.smallest_step = 0.2\n"),
        "{text}"
    );
}

/// A wire as an earlier version wrote it.
fn old() -> String {
    let wire = palpate_fixtures::wire("final-75um").unwrap();
    let kept = wire.lines().filter(|line| !line.contains("state = "));
    let kept: Vec<&str> = kept.collect();
    kept.join("\n").replace("[r_phase]", "[[plays]]") + "\n"
}

#[test]
fn a_wire_of_an_earlier_version_says_its_state_and_its_r_phase() {
    for (law, changes) in [
        ("", 2),
        ("hysteresis = { law = \"cosine\", pieces = 8 }\n", 3),
        ("hysteresis.law = \"plays\"\nhysteresis.count = 8\n", 3),
    ] {
        for state in [WireState::Cold, WireState::Passed] {
            let source = Source::new("w.toml", format!("{law}{}", old()));
            assert!(!check_source(source.clone()).errors.is_empty());
            let found = migrated(&source, Some(state)).unwrap().unwrap();
            assert_eq!(found.changes.len(), changes, "{:?}", found.changes);
            let now = Source::new("w.toml", found.text);
            assert_eq!(check_source(now.clone()).errors, []);
            let wire = crate::WireFile::read(&now).unwrap();
            assert_eq!((wire.sag_state, wire.state), (state, WireState::Cold));
            assert!(wire.r_phase.is_some());
            assert_eq!(migrated(&now, None), Ok(None));
        }
    }
}

#[test]
fn a_wire_of_an_earlier_version_is_not_guessed_at() {
    let said = |text: String| {
        let source = Source::new("w.toml", text);
        migrated(&source, None).unwrap_err().to_string()
    };
    assert_eq!(
        said(old()),
        "w.toml:1: sag_state: expected --sag-state cold or passed: in which of them the bench's sag was measured, no file of an earlier version says, found neither"
    );
    let two = old().replace("[[plays]]", "[[plays]]\nstrain = 0.001\n[[plays]]");
    assert!(said(two).contains("plays: expected one [[plays]], the R phase"));
}
