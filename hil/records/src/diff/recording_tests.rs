//! Tests of `recording.rs`.

use super::*;

fn read(text: &str) -> Result<Contacts<'_, Damage>, Damage> {
    let mut lines = text.lines();
    Contacts::new(move || Ok(lines.next().map(str::to_owned)), |damage| damage)
}

fn compared(a: &str, b: &str, tolerance: Tolerance) -> Result<Vec<Difference>, Damage> {
    compare_contacts(&mut read(a)?, &mut read(b)?, tolerance)
}

fn file(rows: &[&str]) -> String {
    format!("{HEADER}\n{}\n", rows.join("\n"))
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
        compared(&a, &b, t)
            .unwrap()
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
    let cosmetic = compared(&a, &b, near).unwrap();
    assert!(
        cosmetic
            .iter()
            .any(|d| d.grade == Grade::Cosmetic && !d.meaning)
    );
    assert_eq!(compared(&a, &a, Tolerance::default()), Ok(Vec::new()));
}

#[test]
fn damage_is_named_by_its_line() {
    let line = |text: &str| compared(text, text, Tolerance::default()).unwrap_err().line;
    assert_eq!(line(""), 1);
    assert_eq!(line(&format!("{HEADER}\n1,2,3\n")), 2);
    let row = "83,831927,0,1,2.350,-7.050,16.922,1,1";
    assert_eq!(line(&format!("{HEADER}\n{row}\n{row}\n")), 3);
    assert_eq!(
        line(&format!("{HEADER}\n{}\n", row.replace("2.350", "nan"))),
        2
    );
    let earlier = row.replace("831927", "831926");
    assert_eq!(line(&format!("{HEADER}\n{row}\n{earlier}\n")), 3);
}
