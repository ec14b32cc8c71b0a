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
            "contact 0/1: another level in 1 row, 1 apart at most",
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
fn every_number_of_a_row_is_compared() {
    let row = "83,831927,0,1,2.350,-7.050,16.922,1,1";
    let told = |other: &str, tolerance| -> Vec<(String, bool)> {
        let found = compared(&file(&[row]), &file(&[other]), tolerance).unwrap();
        found.into_iter().map(|d| (d.text, d.meaning)).collect()
    };
    let bands = Tolerance::HARDWARE;
    for (other, words, is_banded) in [
        (
            "83,831927,0,1,2.350,-7.050,17.000,1,1",
            "intensity in 1 row, 0.078",
            true,
        ),
        (
            "83,831927,0,1,2.350,-7.050,20.000,1,1",
            "intensity in 1 row, 3.078",
            false,
        ),
        (
            "83,831927,0,1,2.350,-7.050,16.922,2,1",
            "level in 1 row, 1",
            true,
        ),
        (
            "83,831927,0,1,2.350,-7.050,16.922,3,1",
            "level in 1 row, 2",
            false,
        ),
        (
            "83,831927,0,1,2.350,-7.050,16.922,1,2",
            "number of members in 1 row, 1",
            true,
        ),
        (
            "83,831927,0,1,2.350,-7.050,16.922,1,4",
            "number of members in 1 row, 3",
            false,
        ),
        (
            "90,831927,0,1,2.350,-7.050,16.922,1,1",
            "frame in 1 row, 7",
            true,
        ),
    ] {
        let text = format!("contact 0/1: another {words} apart at most");
        assert_eq!(told(other, Tolerance::default()), [(text.clone(), true)]);
        assert_eq!(told(other, bands), [(text, !is_banded)], "{other}");
    }
}

#[test]
fn names_of_displays_are_compared_and_hold_for_a_module() {
    let row =
        |module: u16, name: &str| format!("83,831927,{module},1,0.000,0.000,1.000,1,1,{name}\n");
    let table = |rows: &[String]| format!("{HEADER},{DISPLAY}\n{}", rows.concat());
    let told = |a: &str, b: &str| -> Vec<String> {
        let found = compared(a, b, Tolerance::default()).unwrap();
        found.into_iter().map(|d| d.text).collect()
    };
    let hand = table(&[row(0, "thumb"), row(3, "index")]);
    assert_eq!(told(&hand, &hand), [""; 0]);
    let other = table(&[row(0, "thumb"), row(3, "ring")]);
    assert_eq!(told(&hand, &other), ["display of module 3: index -> ring"]);
    let one = file(&[
        "83,831927,0,1,0.000,0.000,1.000,1,1",
        "83,831927,3,1,0.000,0.000,1.000,1,1",
    ]);
    assert_eq!(
        told(&one, &hand),
        [
            "display of module 0: none -> thumb",
            "display of module 3: none -> index"
        ]
    );
    let two = table(&[row(0, "thumb"), row(0, "ring").replace(",0,1,", ",0,2,")]);
    let damage = compared(&two, &hand, Tolerance::default()).unwrap_err();
    assert_eq!(damage.line, 3, "{damage}");
    assert!(damage.to_string().contains("display thumb"), "{damage}");
    let long = table(&[row(0, &"x".repeat(257))]);
    assert_eq!(
        compared(&long, &hand, Tolerance::default())
            .unwrap_err()
            .line,
        2
    );
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
