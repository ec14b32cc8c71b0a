//! Recipes of recordings: one file says what options would, for `hil contacts`, `hil run` and `hil texture encode`.

use super::texture::ground;
use super::*;

/// A recording in semicolons: the pad's counts as newtons under the names of its maker, mounted upside down.
fn recording(folder: &Folder) {
    let names: Vec<String> = (0..16)
        .flat_map(|t| ["x", "y", "z"].map(|axis| format!("f{axis}_{t}")))
        .collect();
    let mut text = format!("clock;{}\n", names.join(";"));
    for row in 0..60 {
        let counts = contacts::pad(row, 0);
        // Half a turn: the last taxel first, x and y the other way.
        let taxels = counts.chunks(3).rev();
        let value = |count: f64| format!("{:.3}", (count - 30_000.0) / 1000.0).replace('.', ",");
        let values: Vec<String> = taxels
            .flat_map(|t| {
                let [x, y, z] = [t[0], t[1], t[2]].map(f64::from);
                [60_000.0 - x, 60_000.0 - y, z]
            })
            .map(value)
            .collect();
        text += &format!("{};{}\n", row * 10, values.join(";"));
    }
    folder.write("press.csv", &text);
    folder.write("press.toml", RECIPE);
}

const RECIPE: &str = r#"#:schema recording.json
kind = "recording"
name = "press"
description = "A press on a pad that is mounted upside down."
recording = "press.csv"
layout = "uskin-4x4"
time = { column = "clock", unit = "ms" }
unit = "N"
gain = 1000.0
offset = 30000.0

[[modules]]
prefix = "f"
turned_deg = 180
"#;

#[test]
fn a_recipe_says_what_a_maker_left_open() {
    let folder = Folder::new("recipes");
    recording(&folder);
    let own = contacts::recording(&folder, 60);
    let expected = good(&["contacts", &own, "--layout", "uskin-4x4", "--rate", "100"]);
    assert!(expected.lines().count() > 30);
    let [file, recipe] =
        ["press.csv", "press.toml"].map(|name| folder.path(name).display().to_string());
    // Named, found beside, and standing for its recording.
    for args in [
        vec!["contacts", &file, "--recipe", &recipe],
        vec!["contacts", &file],
        vec!["contacts", &recipe],
    ] {
        let said = hil(&args);
        assert_eq!(said.status, Some(0), "{args:?}: {}", said.err);
        assert_eq!(said.out, expected, "{args:?}");
        let is_noted = said.err.contains("read by the recipe");
        assert_eq!(is_noted, args.len() == 2 && args[1] == file, "{}", said.err);
    }
    let played = |args: &[&str]| {
        let said = hil(&[&["run", "--json", "--replay"], args].concat());
        assert_eq!(said.status, Some(0), "{args:?}: {}", said.err);
        let json: serde_json::Value = serde_json::from_str(&said.out).unwrap();
        (json["contacts"].clone(), json["stimuli"].clone())
    };
    let run = played(&[&own, "--layout", "uskin-4x4", "--rate", "100"]);
    assert_eq!(played(&[&recipe]), run);
    assert_eq!(played(&[&file, "--recipe", &recipe]), run);
    assert_eq!(hil(&["check", &recipe]).status, Some(0));
}

#[test]
fn a_recipe_that_does_not_fit_is_refused_with_its_line() {
    let folder = Folder::new("recipes-refused");
    recording(&folder);
    let file = folder.path("press.csv").display().to_string();
    for (from, to, expected) in [
        (
            "turned_deg = 180",
            "turned_deg = 30",
            ["r.toml:14", "0, 90, 180 or 270"],
        ),
        (
            "\"f\"",
            "\"g\"",
            ["48 columns (modules[0] of the recipe)", "press.csv:1"],
        ),
        ("\"clock\"", "\"when\"", ["a column when", "press.csv:1"]),
        ("1000.0", "100000.0", ["a value from", "press.csv:2"]),
        (
            "uskin-4x4",
            "uskin-4x4-pair",
            ["none for `right`", "r.toml:12"],
        ),
    ] {
        let recipe = folder.write("r.toml", &RECIPE.replace(from, to));
        refused_with(
            &["contacts", &file, "--recipe", &recipe.display().to_string()],
            &expected,
        );
    }
    let checked = folder.write("r.toml", &RECIPE.replace("uskin-4x4", "uskin-5x5"));
    let said = hil(&["check", &checked.display().to_string()]);
    assert_eq!(said.status, Some(1), "{}", said.out);
    assert!(said.out.contains("r.toml:6: layout"), "{}", said.out);
    let alone = folder.write(
        "alone.toml",
        &RECIPE.replace("recording = \"press.csv\"\n", ""),
    );
    refused_with(
        &["contacts", &alone.display().to_string()],
        &["recording: expected the recording's path"],
    );
    refused_with(
        &["contacts", &contacts::recording(&folder, 30)],
        &["--layout", "or a recipe"],
    );
}

const STRIP: &str = "name = \"strip\"\ndescription = \"Five taxels\"\nkind = \"sensor\"\naxes = 1\n\n[[modules]]\n\
                      name = \"strip\"\ngrid = { rows = 1, columns = 5, pitch_mm = 2.0 }\n";
const STROKE: &str = "kind = \"recording\"\nname = \"stroke\"\ndescription = \"A stroke over five taxels\"\n\
                      recording = \"stroke.csv\"\nlayout = \"strip.toml\"\ntime = { column = \"clock\", unit = \"ms\" }\n\n\
                      [[modules]]\ncolumns = [\"a\", \"b\", \"c\", \"d\", \"e\"]\n";

#[test]
fn a_recipe_says_how_the_texture_encoder_reads() {
    let (folder, model, rows) = ground("texture-recipe");
    let expected = good(&["texture", "encode", &model, &rows]);
    // The same in milliseconds, under another heading and with the last column first.
    let mut text = String::from("e;clock;a;b;c;d\n");
    for line in folder.text("rows.csv").lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [us, a, b, c, d, e] = fields[..] else {
            panic!("{line}");
        };
        let ms = us.parse::<u64>().unwrap() / 1000;
        text += &format!("{e};{ms};{a};{b};{c};{d}\n");
    }
    let file = folder.write("stroke.csv", &text).display().to_string();
    folder.write("strip.toml", STRIP);
    let recipe = folder.write("stroke.toml", STROKE).display().to_string();
    for read in [
        vec![&*recipe],
        vec![&*file],
        vec![&*file, "--recipe", &*recipe],
    ] {
        let args = [&["texture", "encode", &model][..], &read].concat();
        let said = hil(&args);
        assert_eq!((said.status, &said.out), (Some(0), &expected), "{args:?}");
        let is_noted = said.err.contains("read by the recipe");
        assert_eq!(is_noted, read == [&*file], "{}", said.err);
    }
    folder.write("strip.toml", &STRIP.replace("columns = 5", "columns = 4"));
    let four = STROKE.replace(", \"e\"", "");
    folder.write("stroke.toml", &four);
    refused_with(
        &["texture", "encode", &model, &recipe],
        &["a recipe of 5 readings", "found 4"],
    );
}
