//! `hil contacts` with intensities along each axis, and along the skin of a hand.

use super::contacts::{contacts, csv, recording, rows};
use super::*;

/// (4.9) to (4.15): the norm of a vector is at most the interpolated magnitude, and levels follow from directions too.
#[test]
fn vectors_give_intensities_and_levels_along_each_axis() {
    let folder = Folder::new("vectors");
    let file = recording(&folder, 200);
    let plain = contacts(&file, &["--kc", "2"]);
    let vectors = contacts(&file, &["--kc", "2", "--vectors"]);
    assert_eq!(plain.len(), vectors.len());
    for (one, other) in plain.iter().zip(&vectors) {
        assert_eq!(one[..6], other[..6]);
        assert!(other[6] <= one[6] + 0.01, "{one:?} {other:?}");
    }
    let other_level = plain.iter().zip(&vectors).filter(|(a, b)| a[7] != b[7]);
    assert!(other_level.count() > 0);
    let args = [
        "contacts",
        &file,
        "--layout",
        "uskin-4x4",
        "--rate",
        "40",
        "--json",
    ];
    let json = good(&[&args[..], &["--vectors"]].concat());
    let list: Vec<serde_json::Value> = serde_json::from_str(&json).unwrap();
    for one in &list {
        let vector = one["vector"].as_array().unwrap();
        let norm = vector
            .iter()
            .map(|v| v.as_f64().unwrap().powi(2))
            .sum::<f64>()
            .sqrt();
        assert!(
            (norm - one["intensity"].as_f64().unwrap()).abs() < 2e-3,
            "{one}"
        );
    }
    assert!(!good(&args).contains("vector"));
    refused(&["contacts", &file, "--weber", "0.1", "--vectors"]);
}

/// On the drawing of a hand two fingertips lie side by side; along the skin one of them is nearer to its own finger.
#[test]
fn contacts_of_a_whole_hand_go_along_its_skin() {
    let folder = Folder::new("seams");
    // The right column of the index's tip, the middle of its middle module, the left column of the middle finger's tip.
    let pressed = [7, 11, 37, 38, 41, 42, 68, 72];
    let row = |row: usize| -> Vec<u16> {
        let count = |n: usize| {
            let press = u16::from(row >= 20 && n % 3 == 2 && pressed.contains(&(n / 3)));
            20_000 + ((row * 7 + n * 5) % 3) as u16 + 500 * press
        };
        (0..720).map(count).collect()
    };
    let file = folder.write("hand.csv", &csv(240, (0..40).map(row)));
    let joined = palpate_fixtures::layout("allegro").unwrap();
    let (apart, _) = joined.split_once("\n[[seams]]").unwrap();
    let apart = folder.write("apart.toml", apart).display().to_string();
    let file = file.display().to_string();
    let alone = |layout: &str| {
        let options = ["--scope", "skin", "--kc", "2", "--rate", "40"];
        let args = [&["contacts", &file, "--layout", layout], &options[..]].concat();
        let found = rows(&good(&args));
        // The module of the contact that has the fewest taxels, in the last row.
        let last = found.iter().filter(|row| row[0] as u64 == 39);
        let fewest = last.min_by(|a, b| a[8].total_cmp(&b[8])).unwrap();
        (fewest[2] as u64, fewest[8] as u64)
    };
    assert_eq!(alone(&apart), (2, 4));
    assert_eq!(alone("allegro"), (4, 2));
}
