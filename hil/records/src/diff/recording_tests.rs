//! Tests of `recording.rs`.

use super::*;

fn file(rows: &[&str]) -> Recording {
    let text = format!("{HEADER}\n{}\n", rows.join("\n"));
    Recording::read(text.trim_end()).unwrap()
}

#[test]
fn places_levels_rows_and_contacts_are_told() {
    let a = file(&[
        "83,831927,0,1,2.350,-7.050,16.922,1,1",
        "84,841927,0,1,2.350,-7.000,16.922,1,1",
        "85,851927,0,2,0.000,0.000,1.000,1,1",
    ]);
    let b = file(&[
        "83,831927,0,1,2.353,-7.046,16.922,2,1",
        "86,861927,0,3,0.000,0.000,1.000,1,1",
    ]);
    let told = |t| -> Vec<String> {
        compare_recordings(&a, &b, t)
            .into_iter()
            .map(|d| d.text)
            .collect()
    };
    assert_eq!(
        told(Tolerance::default()),
        [
            "contact 0/1 elsewhere in 1 of 1 rows from 0.831 s on: 0.005 mm RMSE, 0.005 mm at most",
            "contact 0/1: another level in 1 row",
            "contact 0/1: 1 row gone",
            "gone: contact 0/2, 1 row from 0.851 s",
            "new: contact 0/3, 1 row from 0.861 s",
        ]
    );
    let near = Tolerance {
        place_um: 5,
        ..Tolerance::default()
    };
    let cosmetic = compare_recordings(&a, &b, near);
    assert!(
        cosmetic
            .iter()
            .any(|d| d.grade == Grade::Cosmetic && !d.meaning)
    );
    assert_eq!(compare_recordings(&a, &a, Tolerance::default()), []);
}

#[test]
fn damage_is_named_by_its_line() {
    let line = |text: &str| Recording::read(text).unwrap_err().line;
    assert_eq!(line(""), 1);
    assert_eq!(line(&format!("{HEADER}\n1,2,3\n")), 2);
    let row = "83,831927,0,1,2.350,-7.050,16.922,1,1";
    assert_eq!(line(&format!("{HEADER}\n{row}\n{row}\n")), 3);
    assert_eq!(
        line(&format!("{HEADER}\n{}\n", row.replace("2.350", "nan"))),
        2
    );
}
