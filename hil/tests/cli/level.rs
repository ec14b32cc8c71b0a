//! Levels in decibels, from a scene and a wearer to what is felt.

use serde_json::Value;

use super::*;

/// The summary of a run that ends well.
fn summary(args: &[&str]) -> Value {
    let all = [&["run", "--json"], args].concat();
    serde_json::from_str(&good(&all)).unwrap()
}

/// Every contact at the top level, with these changes.
fn at_the_top<'a>(scene: &'a str, changes: &[&'a str]) -> Vec<&'a str> {
    let mut args = vec![scene, "--set", "illusion.intensity=false"];
    args.extend(changes.iter().flat_map(|change| ["--set", *change]));
    args
}

fn median(summary: &Value) -> f64 {
    summary["felt"]["level_db"]["median"].as_f64().unwrap()
}

/// A wearer of the default display with these thresholds.
fn wearer(folder: &Folder, thresholds: &str) -> String {
    let each = |value: &str| [value; 8].join(", ");
    let text = format!(
        "name = \"w\"\ndescription = \"one of a test\"\n{thresholds}\ngain = [{}]\nthreshold = [{}]\n",
        each("1.0"),
        each("0.0")
    );
    folder.write("w.toml", &text).display().to_string()
}

#[test]
fn a_contact_is_felt_at_the_level_asked_for_with_less_heat() {
    for scene in ["sphere-along", "sphere-circle"] {
        let mut energy = 0.0;
        for level in [2.0, 3.0, 4.0] {
            let asked = format!("illusion.level_db={level}");
            let summary = summary(&at_the_top(scene, &[&asked]));
            let felt = median(&summary);
            // A wire that has just been rolled over is warm, and makes more of a pulse than a cold one.
            assert!((felt - level).abs() < 2.0, "{scene}, {level} dB: {felt} dB");
            assert_eq!(summary["felt"]["asked"]["weaker"], 0, "{scene}, {level} dB");
            let spent = summary["energy_mj"].as_f64().unwrap();
            assert!(spent > energy, "{scene}, {level} dB: {spent} mJ");
            energy = spent;
        }
        let most = summary(&at_the_top(scene, &[]));
        assert!(most["energy_mj"].as_f64().unwrap() > energy, "{scene}");
        assert_eq!(most["felt"]["asked"], Value::Null);
    }
}

#[test]
fn a_level_that_heat_does_not_sustain_comes_with_the_one_that_it_does() {
    let args = at_the_top(
        "rest-on-wire",
        &[
            "illusion.level_db=3",
            "bench.drive.current_ma=1000",
            "bench.tissue.rest_c=33",
        ],
    );
    let smooth = [&args[..], &["--render", "smooth", "--set", "length_s=60"]].concat();
    let summary = summary(&smooth);
    let why = summary["why"][0].as_str().unwrap();
    let asked = &summary["felt"]["asked"];
    let resting = asked["resting_db"].as_f64().unwrap();
    let text =
        format!("illusion.level_db = 3: for ten minutes one wire bears {resting:+.1} dB at rest");
    assert!(why.starts_with(&text), "{why}");
    // The arithmetic is what a minute comes to.
    assert!((median(&summary) - resting).abs() < 1.0, "{summary}");
    assert!(asked["weaker"].as_u64().unwrap() > 400, "{asked}");
    let said = good(&[&["run", "--long"], &smooth[..]].concat());
    let last = said.lines().last().unwrap();
    assert!(last.starts_with("OK: illusion.level_db = 3: "), "{said}");
    assert!(
        said.contains("  asked           +3.0 dB over threshold, heat left less to "),
        "{said}"
    );
}

#[test]
fn a_level_that_no_wire_has_is_refused() {
    let refuses = |bench: &str, change: &str, words: &[&str]| {
        refused_with(
            &["run", "sphere-along", "--bench", bench, "--set", change],
            words,
        );
    };
    let ever = "the most that one wire of bench `emulated` ever has within the limits, found 30";
    refuses(
        "emulated",
        "illusion.level_db=30",
        &["illusion.level_db: expected at most 5.3 dB", ever],
    );
    let weak = ["--set", "bench.drive.current_ma=100"];
    let args = ["run", "sphere-along", "--set", "illusion.level_db=3"];
    refused_with(
        &[&args[..], &weak].concat(),
        &["illusion.level_db: expected nothing: at the limits one wire of bench `emulated` is "],
    );
}

#[test]
fn the_wearer_is_believed_and_not_the_person() {
    let folder = Folder::new("level");
    // A sixth more than the threshold of typical: 1.3 dB.
    let named = format!(
        "illusion.wearer={}",
        wearer(&folder, "vibration_um = 0.7\nflutter_um = 5.84")
    );
    let plain = summary(&at_the_top("sphere-along", &["illusion.level_db=2"]));
    let believed = summary(&at_the_top(
        "sphere-along",
        &["illusion.level_db=2", &named],
    ));
    let more = median(&believed) - median(&plain);
    assert!((0.8..2.5).contains(&more), "{more} dB more");
    // Who feels it changes nothing that is driven.
    let dull = at_the_top(
        "sphere-along",
        &["illusion.level_db=2", "illusion.person=dull"],
    );
    let dull = summary(&dull);
    assert_eq!(dull["energy_mj"], plain["energy_mj"]);
    assert_eq!(dull["felt"]["asked"], plain["felt"]["asked"]);
}

#[test]
fn who_feels_nothing_at_the_limits_is_told_so() {
    let folder = Folder::new("numb");
    for (thresholds, key) in [
        (
            "vibration_um = 9.0\nflutter_um = 500.0",
            "w.toml:3: vibration_um",
        ),
        (
            "vibration_um = 1000.0\nflutter_um = 1000.0",
            "w.toml:3: vibration_um",
        ),
    ] {
        let named = format!("illusion.wearer={}", wearer(&folder, thresholds));
        let words = [
            key,
            "expected a wearer who feels one wire of bench `emulated` at the limits: ",
            " dB are missing",
        ];
        refused_with(&["run", "sphere-along", "--set", &named], &words);
    }
    // The renderer is not told of the emulated person: the run is done, and says why nothing came of it.
    let taut = good(&[
        "run",
        "sphere-along",
        "--bench",
        "thesis",
        "--person",
        "dull",
    ]);
    let words: Vec<&str> = taut.split_whitespace().collect();
    let taut = words.join(" ");
    let head = "also: person `dull` feels nothing: one wire at the limits is ";
    assert!(taut.contains(head), "{taut}");
    let file = "dB below the threshold (fixtures/persons/dull.toml: vibration.threshold_um)";
    assert!(taut.contains(file), "{taut}");
    assert!(
        taut.ends_with("NOT FELT: person `dull` feels 0 of 76 onsets"),
        "{taut}"
    );
}
