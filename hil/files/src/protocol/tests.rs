//! What is no study is refused with its key.

use super::*;

fn refused(name: &str, change: (&str, &str)) -> String {
    let text = palpate_fixtures::protocol(name).unwrap();
    assert!(text.contains(change.0), "{}", change.0);
    let source = Source::new("t.toml", text.replacen(change.0, change.1, 1));
    Protocol::read(&source).unwrap_err().to_string()
}

#[test]
fn what_is_no_study_is_refused_with_its_key() {
    for (name, change, key, expected) in [
        (
            "thresholds",
            ("wires = [0, 1", "wires = [0, 0"),
            "absolute_threshold.wires[1]",
            "each wire once",
        ),
        (
            "thresholds",
            ("trials = 60", "trials = 0"),
            "absolute_threshold.trials",
            "1 to 1000",
        ),
        (
            "thresholds",
            ("trials = 60", "trials = 1000"),
            "t.toml",
            "at most 5000 trials",
        ),
        (
            "thresholds",
            ("mean = -14.0", "mean = 3.0"),
            "absolute_threshold.simulated.threshold_db.mean",
            "-40 to 0",
        ),
        (
            "thresholds",
            ("lapse = 0.04", "lapse = nan"),
            "absolute_threshold.simulated.lapse",
            "a finite number",
        ),
        (
            "thresholds",
            ("quest-plus", "quest"),
            "absolute_threshold.method",
            "quest-plus",
        ),
        (
            "roughness",
            ("[\"finger\", \"wires\"]]", "[\"finger\", \"wire\"]]"),
            "rating.compare[0][1]",
            "one of rating.conditions",
        ),
        (
            "roughness",
            ("present = ", "render = \"tap\"\npresent = "),
            "conditions[0]",
            "no change where nothing is played",
        ),
        (
            "felt-paths",
            ("conditions = [\"along", "conditions = [\"alonk"),
            "drawing.conditions[0]",
            "did you mean",
        ),
        (
            "felt-paths",
            ("name = \"across\"", "name = \"along\""),
            "conditions[1].name",
            "each name once",
        ),
        (
            "wearer",
            ("reference = 3", "reference = 0"),
            "matching.wires[0]",
            "another wire than the reference",
        ),
        (
            "wearer",
            ("choices = [\"left\", \"right\"]", "choices = [\"left\"]"),
            "questions[0].choices",
            "two choices at least",
        ),
    ] {
        let said = refused(name, change);
        assert!(said.contains(key) && said.contains(expected), "{said}");
    }
}

#[test]
fn trials_are_counted_with_their_practice() {
    let count = |name| {
        let source = Source::new("t.toml", palpate_fixtures::protocol(name).unwrap());
        Protocol::read(&source).unwrap().trials()
    };
    assert_eq!(count("thresholds"), 480);
    assert_eq!(count("roughness"), 20);
}
