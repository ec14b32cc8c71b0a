//! Tests of `check.rs`.

use super::*;

fn told(text: &str) -> Vec<String> {
    let checked = check_source(Source::new("f.toml", text));
    checked.errors.iter().map(ToString::to_string).collect()
}

#[test]
fn every_shipped_file_is_recognised_and_right() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    for kind in FileKind::ALL {
        for name in kind.names() {
            let path = root.join(kind.folder()).join(format!("{name}.toml"));
            let found = check(&path);
            let wanted = (Some(kind), vec![], true);
            let found = (found.kind, found.errors, found.complete);
            assert_eq!(found, wanted, "{}", path.display());
        }
    }
}

#[test]
fn all_errors_of_a_scene_come_at_once() {
    let text = "\
name = \"Mine\"
description = \"d\"
lenght_s = 5.0
layout = \"uskin-4x5\"
generation = \"2020\"
compression.kc = 0
noise_lsb = [\"a\", 2.0]
[illusion]
model = \"phantm\"
alpha = 1.5
person = \"typicl\"
[[touches]]
start_s = \"soon\"
path = { kind = \"line\", points_mm = [[0.0, \"x\"], [1.0, 1.0]] }
force_n = { maen = 0.5 }
[[touches]]
start_s = 0.9
module = 7
path = { kind = \"cirle\", radius_mm = 3.0 }
force_n = { mean = 50.0 }
";
    let said = told(text);
    let starts = [
        "f.toml:1: name: expected lower-case",
        "f.toml:3: lenght_s: expected one of the keys",
        "f.toml:4: layout: expected a layout (",
        "f.toml:5: generation: expected one of `2019`",
        "f.toml:6: compression.kc: expected a number from 1 to 1024, found 0",
        "f.toml:7: noise_lsb[0]: expected a number, found \"a\"",
        "f.toml:9: illusion.model: expected one of `phantom`",
        "f.toml:10: illusion.alpha: expected a number from 0 to 1, found 1.5",
        "f.toml:11: illusion.person: expected a person (back, dull, sensitive, typical) or a file, found \"typicl\"; did you mean `typical`?",
        "f.toml:13: touches[0].start_s: expected a number, found \"soon\"",
        "f.toml:14: touches[0].path.points_mm[0][1]: expected a number, found \"x\"",
        "f.toml:15: touches[0].force_n.maen: expected one of the keys",
        "f.toml:18: touches[1].module: expected a module of `uskin-4x4`, 0 to 0, found 7",
        "f.toml:19: touches[1].path.kind: expected one of `hold`",
        "f.toml:20: touches[1].force_n.mean: expected a number from 0 to 20 N, found 50.0",
    ];
    let all = said.join("\n");
    assert_eq!(said.len(), starts.len(), "\n{all}");
    for (one, start) in said.iter().zip(starts) {
        assert!(one.starts_with(start), "{one}\nnot {start}");
    }
    for question in ["length_s", "uskin-4x4", "2021", "phantom", "mean", "circle"] {
        assert!(
            all.contains(&format!("did you mean `{question}`?")),
            "{question}\n{all}"
        );
    }
}

#[test]
fn all_errors_of_a_real_bench_come_at_once() {
    let text = "\
#:schema bench.json
name = \"b\"
description = \"d\"
kind = \"real\"
limits = \"defalt\"
[real]
can = []
i2c = [\"/dev/i2c-1\"]
heartbeat_ms = 4
[drive]
current_ma = 9000.0
[[outputs]]
board = 0x20
channel = 16
";
    let said = told(text);
    for start in [
        "f.toml:1: display: expected a value: no default stands for a real bench's hardware",
        "f.toml:1: wire.kind: expected a value",
        "f.toml:1: wire.alloy: expected a value",
        "f.toml:10: drive.supply_limit_ma: expected a value",
        "f.toml:5: limits: expected a limit table (default) or a file",
        "f.toml:7: real.can: expected a number from 1 to 16 interfaces",
        "f.toml:9: real.heartbeat_ms: expected a number from 5",
        "f.toml:11: drive.current_ma: expected a number from 1 to 5000 mA",
        "f.toml:13: outputs[0].board: expected 0x40 to 0x77",
        "f.toml:14: outputs[0].channel: expected a number from 0 to 15",
        "f.toml:12: outputs: expected 8 outputs",
    ] {
        let found = said.iter().any(|s| s.starts_with(start));
        assert!(found, "no `{start}` in\n{}", said.join("\n"));
    }
    assert_eq!(said.len(), 11, "{}", said.join("\n"));
}

#[test]
fn what_lies_under_a_mistyped_key_is_checked_too() {
    let text = "name = \"a\"\ndescription = \"d\"\nlenght_s = -5\n[compresion]\nkc = 0\nki = \"many\"\n\
                [[touchs]]\nstart_s = 1\npath = { kind = \"hold\", points_mm = [[0, 0]] }\nforce_n = { mean = 30 }\n";
    let said = told(text);
    let starts = [
        "f.toml:3: lenght_s",
        "f.toml:3: length_s: expected a number from",
        "f.toml:4: compresion",
        "f.toml:5: compression.kc: expected a number from 1 to 1024, found 0",
        "f.toml:6: compression.ki: expected a whole number",
        "f.toml:7: touchs",
        "f.toml:10: touches[0].force_n.mean: expected a number from 0 to 20 N, found 30",
    ];
    assert_eq!(said.len(), starts.len(), "{}", said.join("\n"));
    for (one, start) in said.iter().zip(starts) {
        assert!(one.starts_with(start), "{one}\nnot {start}");
    }
}

#[test]
fn the_other_kinds_say_everything_too() {
    let heading = "name = \"a\"\ndescription = \"d\"\n";
    for (text, starts) in [
        (
            "pulse.width_us = 300\nburst.length_ms = 0\nskin.peak = 40\n",
            &[
                "f.toml:3: pulse.width_us",
                "f.toml:4: burst.length_ms",
                "f.toml:5: skin.peak:",
            ][..],
        ),
        (
            "gain = [1.0, 2.0]\nthreshold = [3.0, 0.1]\n",
            &["f.toml:3: gain[1]", "f.toml:4: threshold[0]"],
        ),
        (
            "kind = \"sensor\"\naxes = 2\n[[modules]]\nname = \"m\"\ngrid = { rows = 0, columns = 4, pitch = 1.0 }\n",
            &[
                "f.toml:4: axes",
                "f.toml:7: modules[0].grid.rows",
                "f.toml:7: modules[0].grid.pitch:",
            ],
        ),
        (
            "kind = \"display\"\nspacing_mm = [0.0, 5.0]\nwires_mm = [[0.0, 0.0], [0.1, 0.0]]\n",
            &["f.toml:4: spacing_mm[0]", "f.toml:5: wires_mm[1]"],
        ),
        (
            "vibration = 3\nflutter = \"x\"\n",
            &["f.toml:3: vibration", "f.toml:4: flutter"],
        ),
        (
            "diameter_um = 1\nlength_mm = 5\nelectrical = 3\n",
            &[
                "f.toml:3: diameter_um",
                "f.toml:5: electrical",
                "f.toml:1: mechanical",
                "f.toml:1: sag_state",
                "f.toml:1: thermal",
            ],
        ),
    ] {
        let said = told(&format!("{heading}{text}"));
        for start in starts {
            let found = said.iter().any(|s| s.starts_with(start));
            assert!(found, "no `{start}` in\n{}", said.join("\n"));
        }
        assert_eq!(said.len(), starts.len(), "{}", said.join("\n"));
    }
}

#[test]
fn syntax_errors_come_together_and_what_is_no_settings_file_is_refused() {
    let said = told("name = \"a\"\ndescription =\nlength_s = = 3\nrate_hz 4\n");
    assert!(said.len() >= 2, "{said:?}");
    assert!(
        said.iter().all(|s| s.contains("expected valid TOML")),
        "{said:?}"
    );
    let other = told("[package]\nedition = \"2024\"\n");
    assert!(
        other[0].contains("`#:schema scene.json`") && other[0].contains("package"),
        "{other:?}"
    );
    let schema = told("#:schema ../x/bench.json\nname = \"a\"\ndescription = \"d\"\n");
    assert_eq!(schema, [""; 0]);
}

#[test]
fn a_quarantine_is_known_by_its_key() {
    let good = "[[quarantine]]\ntrial = \"t\"\nreason = \"r\"\n";
    let checked = check_source(Source::new("q.toml", good));
    assert_eq!(checked.kind, Some(FileKind::Quarantine));
    assert_eq!(checked.errors, []);
    assert_eq!(
        told("[[quarantine]]\ntrail = \"t\"\nreason = \" \"\n").len(),
        2
    );
}

#[test]
fn a_recipe_is_known_by_its_kind() {
    let text = "kind = \"recording\"\nname = \"r\"\ndescription = \"A recipe.\"\nlayout = \"uskin-4x4\"\nmodules = []\n";
    let checked = check_source(Source::new("r.toml", text));
    assert_eq!(checked.kind, Some(FileKind::Recording));
    assert!(
        checked.errors[0]
            .to_string()
            .contains("at least one module"),
        "{:?}",
        checked.errors
    );
}
