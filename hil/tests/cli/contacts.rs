//! `hil contacts`: the compression of chapter 4, checkable by hand.

use std::collections::BTreeSet;

use super::*;

const HEADER: &str = "frame,time_us,module,contact,x_mm,y_mm,intensity,level,members";

/// A header and rows of counts.
pub fn csv(taxels: usize, rows: impl Iterator<Item = Vec<u16>>) -> String {
    let names: Vec<_> = (1..=taxels)
        .map(|t| format!("txl{t}_x,txl{t}_y,txl{t}_z"))
        .collect();
    let mut text = names.join(",") + "\n";
    for row in rows {
        let row: Vec<_> = row.iter().map(|c| format!("{c}.0")).collect();
        text += &(row.join(",") + "\n");
    }
    text
}

/// Counts of one 4x4 module: noise of a count, and from row 20 on a bump that wanders over the pad.
pub fn pad(row: usize, shift: usize) -> Vec<u16> {
    let mut counts = Vec::new();
    for taxel in 0..16 {
        let (x, y) = ((taxel % 4) as f64, (taxel / 4) as f64);
        let phase = (row + shift) as f64 / 15.0;
        let (dx, dy) = (x - 1.5 - 1.4 * phase.sin(), y - 1.5 - 1.2 * phase.cos());
        let force = if row < 20 {
            0.0
        } else {
            1500.0 + 500.0 * (phase * 0.7).sin()
        };
        let press = force * (-(dx * dx + dy * dy) / 0.8).exp();
        let noise = |axis: usize| ((row * 7 + taxel * 3 + axis * 5) % 3) as f64;
        counts.push((49_000.0 + noise(0) + 0.2 * press) as u16);
        counts.push((16_500.0 + noise(1) - 0.1 * press) as u16);
        counts.push((37_000.0 + noise(2) + press) as u16);
    }
    counts
}

/// A recording of one module, without times.
pub fn recording(folder: &Folder, rows: usize) -> String {
    let text = csv(16, (0..rows).map(|row| pad(row, 0)));
    folder.write("recording.csv", &text).display().to_string()
}

/// The rows of the output as numbers.
pub fn rows(text: &str) -> Vec<[f64; 9]> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(HEADER));
    let number = |field: &str| field.parse::<f64>().unwrap_or_else(|_| panic!("`{field}`"));
    lines
        .map(|line| {
            let fields: Vec<_> = line.split(',').map(number).collect();
            fields.try_into().unwrap_or_else(|_| panic!("{line}"))
        })
        .collect()
}

pub fn contacts(file: &str, options: &[&str]) -> Vec<[f64; 9]> {
    let mut args = vec!["contacts", file, "--layout", "uskin-4x4", "--rate", "40"];
    args.extend(options);
    rows(&good(&args))
}

fn column(rows: &[[f64; 9]], index: usize) -> BTreeSet<u64> {
    rows.iter().map(|r| r[index] as u64).collect()
}

/// Levels by just noticeable differences are as many as fit between the weakest and the strongest contact.
#[test]
fn noticeable_levels_replace_k_i() {
    let folder = Folder::new("weber");
    let file = recording(&folder, 200);
    let found = contacts(&file, &["--weber", "0.1"]);
    let intensities = found.iter().map(|row| row[6]);
    let (least, most) =
        intensities.fold((f64::INFINITY, 0.0_f64), |(l, m), v| (l.min(v), m.max(v)));
    let steps = ((most / least).ln() / 1.1_f64.ln()).floor() as u64 + 1;
    let highest = column(&found, 7).last().copied().unwrap();
    assert!(
        (steps - 1..=steps).contains(&highest),
        "{highest} of {steps}"
    );
    refused(&["contacts", &file, "--weber", "0.1", "--ki", "4"]);
    // A stop so far away ends K-means after its first update.
    let early = contacts(&file, &["--kc", "4", "--stop-mm", "100"]);
    assert_ne!(early, contacts(&file, &["--kc", "4"]));
}

#[test]
fn columns_count_as_the_contract_says() {
    let folder = Folder::new("columns");
    let file = recording(&folder, 120);
    let all = contacts(&file, &["--threshold", "0"]);
    // The reference's ten rows count and emit nothing.
    assert_eq!(all[0][0] as u64, 10);
    assert_eq!(column(&all, 0), (10..120).collect());
    for row in &all {
        assert!((row[1] - row[0] * 25_000.0).abs() < 0.5, "{row:?}");
        assert!(row[2].abs() < 0.5, "module is zero-based: {row:?}");
        assert!((1.0..=10.0).contains(&row[7]) && row[7].fract().abs() < 1e-9);
        assert!((1.0..=16.0).contains(&row[8]));
        assert!(row[4].abs() <= 7.05 && row[5].abs() <= 7.05);
    }
    let pressed = contacts(&file, &["--threshold", "20"]);
    assert_eq!(column(&pressed, 0), (20..120).collect());
    assert_eq!(column(&pressed, 7), (1..=10).collect(), "levels 1 to K_I");
    assert_eq!(column(&pressed, 3), [1].into(), "one contact, one identity");
}

#[test]
fn every_option_does_what_it_says() {
    let folder = Folder::new("options");
    let file = recording(&folder, 120);
    let base = contacts(&file, &["--threshold", "20"]);
    let with = |options: &[&str]| {
        let mut all = vec!["--threshold", "20"];
        all.extend(options);
        contacts(&file, &all)
    };
    let fours = with(&["--kc", "4"]);
    assert_eq!(fours.iter().filter(|r| r[0] as u64 == 60).count(), 4);
    let free = with(&["--kc", "16"]);
    assert!(
        free.iter().all(|r| r[8] as u64 == 1),
        "passed through unchanged"
    );
    assert_eq!(column(&with(&["--ki", "3"]), 7), [1, 2, 3].into());
    assert_eq!(column(&with(&["--ki", "1"]), 7), [1].into());
    assert_eq!(
        column(&with(&["--reference-frames", "30"]), 0).first(),
        Some(&30)
    );
    assert!(contacts(&file, &["--threshold", "400"]).len() <= base.len());
    assert_eq!(contacts(&file, &["--threshold", "60000"]).len(), 0);
    assert_eq!(
        contacts(&file, &[]),
        contacts(&file, &["--threshold", "per-taxel", "--drift-s", "5"])
    );
    for option in [
        ["--weight-exponent", "2"],
        ["--weight-exponent", "0"],
        ["--norm", "l1"],
        ["--norm", "linf"],
        ["--axes", "z"],
    ] {
        assert_ne!(with(&option), base, "{option:?}");
    }
    for option in [
        ["--weight-exponent", "1"],
        ["--norm", "l2"],
        ["--axes", "xyz"],
        ["--replay-stale", "keep"],
        ["--seed", "9"],
    ] {
        // K_C = 1 draws nothing.
        assert_eq!(with(&option), base, "{option:?}");
    }
    let seeded = |seed: &str| with(&["--kc", "3", "--seed", seed]);
    assert_eq!(seeded("4"), seeded("4"));
    let args = ["contacts", &file, "--layout", "uskin-4x4", "--rate", "100"];
    assert!(
        rows(&good(&args))
            .iter()
            .all(|r| (r[1] - r[0] * 1e4).abs() < 0.5)
    );
}

/// A taxel is in contact strictly above the threshold, by the Euclidean norm whatever the weights' norm.
#[test]
fn the_threshold_is_strict_and_euclidean() {
    let folder = Folder::new("strict");
    let press = |z: u16, x: u16| {
        let mut counts = [1000u16; 48];
        counts[0] += x;
        counts[2] += z;
        counts.to_vec()
    };
    let frames = [press(0, 0), press(0, 0), press(4, 3), press(4, 3)];
    let file = folder
        .write("f.csv", &csv(16, frames.into_iter()))
        .display()
        .to_string();
    let found = |options: &[&str]| {
        let mut all = vec!["--reference-frames", "2"];
        all.extend(options);
        contacts(&file, &all).len()
    };
    assert_eq!(found(&["--threshold", "5"]), 0);
    for norm in ["l1", "l2", "linf"] {
        assert_eq!(found(&["--threshold", "4.9", "--norm", norm]), 2, "{norm}");
        assert_eq!(found(&["--threshold", "5", "--norm", norm]), 0, "{norm}");
    }
    assert_eq!(found(&["--threshold", "4", "--axes", "z"]), 0);
    assert_eq!(found(&["--threshold", "3.9", "--axes", "z"]), 2);
    let row = contacts(&file, &["--reference-frames", "2", "--threshold", "4"])[0];
    let top_left = [2.0, 50_000.0, 0.0, 1.0, -7.05, 7.05, 5.0, 1.0, 1.0];
    let agree = row.iter().zip(top_left).all(|(a, b)| (a - b).abs() < 1e-3);
    assert!(agree, "{row:?}");
}

#[test]
fn stale_rows_are_kept_or_skipped_as_asked() {
    let folder = Folder::new("stale");
    let text = csv(16, (0..120).map(|row| pad(row / 2, 0)));
    let file = folder.write("f.csv", &text).display().to_string();
    let keep = contacts(&file, &["--threshold", "20"]);
    let skip = contacts(&file, &["--threshold", "20", "--replay-stale", "skip"]);
    assert_eq!(column(&keep, 0), (40..120).collect());
    // Data rows keep their numbers.
    assert_eq!(column(&skip, 0), (40..120).step_by(2).collect());
}

#[test]
fn several_modules_come_as_one_file_of_all_taxels() {
    let folder = Folder::new("modules");
    let both = |row: usize| [pad(row, 0), pad(row, 20)].concat();
    let text = csv(32, (0..120).map(both));
    let file = folder.write("f.csv", &text).display().to_string();
    let run = |options: &[&str]| {
        let mut args = vec![
            "contacts",
            &file,
            "--layout",
            "uskin-4x4-pair",
            "--rate",
            "40",
            "--threshold",
            "20",
        ];
        args.extend(options);
        rows(&good(&args))
    };
    let pair = run(&[]);
    assert_eq!(column(&pair, 2), [0, 1].into());
    assert_eq!(
        column(&pair, 3).len(),
        2,
        "identities are of the skin, not of a module"
    );
    // The first module alone is the same, places in its own coordinates.
    let alone = contacts(&recording(&folder, 120), &["--threshold", "20"]);
    let first: Vec<_> = pair.iter().filter(|r| r[2] < 0.5).collect();
    assert_eq!(first.len(), alone.len());
    for (a, b) in first.iter().zip(&alone) {
        assert_eq!(a[4..7], b[4..7]);
    }
    assert!(run(&["--kc", "2"]).len() > pair.len());
}

#[test]
fn times_come_from_the_file_where_it_has_them() {
    let folder = Folder::new("times");
    let untimed = csv(16, (0..60).map(|row| pad(row, 0)));
    let timed: String = untimed
        .lines()
        .enumerate()
        .map(|(i, line)| match i {
            0 => format!("time_us,{line}\n"),
            _ => format!("{},{line}\n", 1_000_000 + 7000 * i),
        })
        .collect();
    let file = folder.write("f.csv", &timed).display().to_string();
    let all = rows(&good(&[
        "contacts",
        &file,
        "--layout",
        "uskin-4x4",
        "--threshold",
        "0",
    ]));
    assert!((all[0][1] - 1_077_000.0).abs() < 0.5, "{:?}", all[0]);
    // A zero rate is refused, needed or not.
    refused_with(
        &["contacts", &file, "--layout", "uskin-4x4", "--rate", "0"],
        &["--rate", "expected"],
    );
}

#[test]
fn the_rate_may_stand_beside_the_recording() {
    let folder = Folder::new("meta");
    let file = recording(&folder, 60);
    let args = ["contacts", &file, "--layout", "uskin-4x4"];
    refused_with(&args, &["recording.csv:1", "time_us", "--rate HZ"]);
    folder.write("meta_data.csv", "object_name,frequency_hz\n7,50.0\n");
    let said = hil(&args);
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(
        said.err.starts_with("note: 50 rows a second, from "),
        "{}",
        said.err
    );
    assert!(
        rows(&said.out)
            .iter()
            .all(|r| (r[1] - r[0] * 2e4).abs() < 0.5)
    );
    let quiet = good(&["contacts", &file, "--layout", "uskin-4x4", "--quiet"]);
    assert_eq!(quiet, said.out);
    // What is typed wins.
    assert!((contacts(&file, &[])[0][1] / 25_000.0).fract().abs() < 1e-9);
    for (text, words) in [
        (
            "object_name\n7\n",
            [
                "meta_data.csv:1: frequency_hz: expected such a column",
                "--rate",
            ],
        ),
        (
            "frequency_hz\n",
            [
                "meta_data.csv:2: frequency_hz: expected a rate",
                "found nothing",
            ],
        ),
        (
            "frequency_hz\n0\n",
            [
                "meta_data.csv:2: frequency_hz: expected a rate above 0 Hz",
                "found `0`",
            ],
        ),
        (
            "frequency_hz\nNaN\n",
            [
                "meta_data.csv:2: frequency_hz: expected a rate above 0 Hz",
                "found `NaN`",
            ],
        ),
    ] {
        folder.write("meta_data.csv", text);
        refused_with(&args, &words);
    }
}

#[test]
fn contacts_go_into_a_folder_or_come_as_json() {
    let folder = Folder::new("contacts-out");
    let file = recording(&folder, 60);
    let args = ["contacts", &file, "--layout", "uskin-4x4", "--rate", "40"];
    let csv = good(&args);
    let out = folder.path("new").display().to_string();
    assert_eq!(good(&[&args[..], &["--out", &out]].concat()), "");
    assert_eq!(folder.text("new/contacts.csv"), csv);
    let json = good(&[&args[..], &["--json"]].concat());
    let objects: Vec<serde_json::Value> = serde_json::from_str(&json).unwrap();
    let rows = rows(&csv);
    assert_eq!(objects.len(), rows.len());
    for (object, row) in objects.iter().zip(rows) {
        for (name, value) in HEADER.split(',').zip(row) {
            let found = object[name].as_f64().unwrap();
            assert!((found - value).abs() < 1e-9, "{name}: {found} {value}");
        }
    }
}

#[test]
fn bad_options_are_refused() {
    let folder = Folder::new("bad-options");
    let file = recording(&folder, 30);
    for (option, value) in [
        ("--kc", "0"),
        ("--kc", "-1"),
        ("--kc", "70000"),
        ("--kc", "many"),
        ("--ki", "0"),
        ("--reference-frames", "0"),
        ("--reference-frames", "99999999999"),
        ("--threshold", "-1"),
        ("--threshold", "NaN"),
        ("--threshold", "inf"),
        ("--threshold", "car"),
        ("--weight-exponent", "-1"),
        ("--weight-exponent", "NaN"),
        ("--weight-exponent", "17"),
        ("--norm", "l3"),
        ("--axes", "xy"),
        ("--rate", "0"),
        ("--rate", "-40"),
        ("--rate", "NaN"),
        ("--rate", "inf"),
        ("--rate", "1e300"),
        ("--rate", "1e-300"),
        ("--seed", "x"),
        ("--seed", "-1"),
        ("--ki", "257"),
        ("--replay-stale", "maybe"),
    ] {
        let mut args = vec!["contacts", &file, "--layout", "uskin-4x4", option, value];
        if option != "--rate" {
            args.extend(["--rate", "40"]);
        }
        refused_with(&args, &[option, value]);
    }
    let rate = ["contacts", &file, "--rate", "40"];
    refused_with(&rate, &["--layout"]);
    for (layout, words) in [
        (
            "nowhere",
            &["uskin-4x4", "allegro", "expected a layout"][..],
        ),
        ("thimble-8", &["--layout", "\"sensor\"", "display"]),
        (
            "allegro",
            &["recording.csv:1", "720 taxel columns", "found 48"],
        ),
    ] {
        refused_with(&[&rate[..], &["--layout", layout]].concat(), words);
    }
    let long = [
        &rate[..],
        &["--layout", "uskin-4x4", "--reference-frames", "30"],
    ]
    .concat();
    refused_with(&long, &["recording.csv", "at least 31 rows", "found 30"]);
}

/// Tells whether the program's remarks on a recording say that the reference was not at rest, by `hil contacts` and `hil run`.
fn says_not_at_rest(file: &str) -> [bool; 2] {
    let said = [
        hil(&["contacts", file, "--layout", "uskin-4x4"]).err,
        hil(&["run", "--replay", file, "--layout", "uskin-4x4"]).out,
    ];
    said.map(|text| {
        text.replace("\n    ", " ")
            .contains("reference not at rest")
    })
}

#[test]
fn a_run_says_as_contacts_do_that_the_skin_was_not_at_rest() {
    let folder = Folder::new("not-at-rest");
    let write = |name: &str, force: &dyn Fn(usize) -> u16| {
        let rows = (0..400).map(|row| {
            let pressed = [5, 6, 9].map(|taxel| 3 * taxel + 2);
            let mut counts = pad(row % 20, 0);
            pressed.into_iter().for_each(|i| counts[i] += force(row));
            counts
        });
        let timed: String =
            csv(16, rows)
                .lines()
                .enumerate()
                .fold(String::new(), |all, (row, line)| match row {
                    0 => format!("time_us,{line}\n"),
                    _ => format!("{all}{},{line}\n", 10_000 * row),
                });
        folder.write(name, &timed).display().to_string()
    };
    let rested = write("rested.csv", &|row| {
        600 * u16::from((200..300).contains(&row))
    });
    assert_eq!(says_not_at_rest(&rested), [false, false]);
    let moved = write("moved.csv", &|row| match row {
        0..80 => (row % 16) as u16 * 60,
        row => 600 * u16::from((200..300).contains(&row)),
    });
    assert_eq!(says_not_at_rest(&moved), [true, true]);
    let touched = write("touched.csv", &|row| 600 * u16::from(row < 150));
    assert_eq!(says_not_at_rest(&touched), [true, true]);
}
