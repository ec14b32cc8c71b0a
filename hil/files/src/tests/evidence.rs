//! Priors and evidence that are refused, each with its line.

use crate::{EvidenceFile, FileError, PriorsFile, Source, load_evidence, load_priors};

/// The error of a shipped file in which one text stands in place of another, behind its place.
fn refused<T>(
    text: &str,
    (from, to): (&str, &str),
    read: fn(&Source) -> Result<T, FileError>,
) -> String {
    assert!(text.contains(from), "{from}");
    let changed = text.replacen(from, to, 1);
    match read(&Source::new("mine.toml", changed)) {
        Ok(_) => panic!("`{to}` is taken"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn what_ships_is_read() {
    assert_eq!(load_evidence("published").unwrap().value.row.len(), 3);
    load_priors("default").unwrap();
}

#[test]
fn rows_without_unit_source_or_tolerance_are_refused() {
    let text = palpate_fixtures::evidence("published").unwrap();
    for (from, to, words) in [
        (
            "unit = \"um\"\n",
            "",
            "mine.toml:5: row[0].unit: expected \"um\", the unit of stroke, found nothing",
        ),
        (
            "unit = \"um\"",
            "unit = \"mm\"",
            "mine.toml:8: row[0].unit: expected \"um\", the unit of stroke, found \"mm\"",
        ),
        (
            "unit = \"um\"",
            "unit = \"\"",
            "mine.toml:8: row[0].unit: expected \"um\"",
        ),
        (
            "source = \"thesis: both subjects felt the final module\"\n",
            "",
            "mine.toml:22: row[1].source: expected the publication or measurement that the value comes from, found nothing",
        ),
        (
            "source = \"thesis: both subjects felt the final module\"",
            "source = \" \"",
            "row[1].source: expected the publication or measurement",
        ),
        (
            "tolerance = [4.0, 4.0]\n",
            "",
            "row[1]: expected `tolerance` or `factor`",
        ),
        (
            "tolerance = [4.0, 4.0]",
            "tolerance = [4.0, -4.0]",
            "row[1].tolerance[1]: expected a number from ",
        ),
        (
            "tolerance = [4.0, 4.0]",
            "tolerance = [4.0, 4.0]\nfactor = [2.0, 2.0]",
            "and not both",
        ),
        (
            "quantity = \"stroke\"",
            "quantity = \"strok\"",
            "did you mean `stroke`?",
        ),
        (
            "value = 10.0",
            "value = -10.0",
            "row[0].value: expected a number from 0.001 to 10000 um, found -10.0",
        ),
        (
            "bursts = 10",
            "bursts = 0",
            "row[0].drive.bursts: expected a number from 1 to 100",
        ),
        (
            "every_ms = 468.0",
            "every_ms = 20.0",
            "row[0].drive.every_ms: expected at least 30.6",
        ),
    ] {
        let said = refused(text, (from, to), EvidenceFile::read);
        assert!(said.contains(words), "{from:?} to {to:?}: {said}");
    }
}

#[test]
fn priors_turned_round_and_ambiguous_ones_are_refused() {
    let text = palpate_fixtures::priors("default").unwrap();
    for (from, to, words) in [
        (
            "[35, 55]",
            "[55, 35]",
            "mine.toml:11: prior.r_start.uniform: expected the lower end first: more than 55 behind it, found [55, 35]",
        ),
        (
            "log_uniform = [2, 40]",
            "log_uniform = [0, 40]",
            "prior.stress.log_uniform[0]: expected a number from 0.000000001 to 1000 MPa",
        ),
        (
            "{ uniform = [35, 55] }",
            "{ uniform = [35, 55], known = 45 }",
            "prior.r_start: expected one of uniform",
        ),
        (
            "{ uniform = [35, 55] }",
            "{}",
            "prior.r_start: expected one of uniform",
        ),
        (
            "{ normal = [30.5, 2.0] }",
            "{ normal = [30.5, 0] }",
            "prior.finger.normal[1]: expected a number from ",
        ),
        (
            "finger = { normal = [30.5, 2.0] }",
            "",
            "prior: expected a prior of `finger`, found none",
        ),
        (
            "taut = 0.2",
            "taut = 1.2",
            "taut: expected a number from 0 to 1",
        ),
        ("skin =", "skins =", "skin"),
    ] {
        let said = refused(text, (from, to), PriorsFile::read);
        assert!(said.contains(words), "{from:?} to {to:?}: {said}");
    }
}
