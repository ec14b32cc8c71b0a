//! Columns are taken by name, by number or by prefix; what is wrong is said with its place.

use super::*;

fn read(text: &str, features: usize, names: &[&str]) -> Result<Rows, String> {
    let names: Vec<_> = names.iter().map(|n| (*n).to_owned()).collect();
    let take = Take::Features {
        names: &names,
        count: features,
    };
    Rows::parse("f.csv", text.as_bytes(), take).map_err(|e| e.to_string())
}

#[test]
fn columns_are_taken_by_name_or_by_number() {
    let named = read("time_us,c,b,a\n5,1,2,3\n6,4,5,6.5\n", 2, &["a", "b"]).unwrap();
    assert_eq!(named.iter().collect::<Vec<_>>(), [[3.0, 2.0], [6.5, 5.0]]);
    assert_eq!((named.count(), named.line(1), named.line(2)), (2, 3, 0));
    let counted = read("time_us, x, y\n5, 1, 2\n", 2, &["a", "b"]).unwrap();
    assert_eq!(counted.iter().collect::<Vec<_>>(), [[1.0, 2.0]]);
    let bare = read("1,2\n3,4\n", 2, &["a", "b"]).unwrap();
    assert_eq!(bare.iter().count(), 2);
}

#[test]
fn columns_are_taken_by_prefix_without_some_taxels() {
    let without = ["txl1".to_owned()];
    let read = |text: &str| {
        let take = Take::Prefixed {
            prefix: "txl",
            without: &without,
        };
        Rows::parse("f.csv", text.as_bytes(), take).map_err(|e| e.to_string())
    };
    let rows = read("time,txl1_x,txl10_x,txl2_x\n1,2,3,4.5\n").unwrap();
    let names = ["txl10_x", "txl2_x"].map(String::from).to_vec();
    assert_eq!(rows.into_parts(), (names, vec![3.0, 4.5]));
    for nothing in ["time,txl1_x\n1,2\n", "1,2\n"] {
        let message = "f.csv:1: expected columns txl*, found none of that name";
        assert_eq!(read(nothing).unwrap_err(), message);
    }
}

#[test]
fn what_is_wrong_is_said_with_its_line_and_column() {
    for (text, message) in [
        (
            "a,b\n1,2\n3,nan\n",
            "f.csv:3: column 2: expected a finite number, found nan",
        ),
        (
            "a,b\n1,2\n3\n",
            "f.csv:3: column 2: expected a finite number, found nothing",
        ),
        (
            "a,b\n1,1e99\n",
            "f.csv:2: column 2: expected a finite number, found 1e99",
        ),
        (
            "a,c\n1,2\n",
            "f.csv:1: expected a column b, found none of that name",
        ),
        (
            "p,q,r\n1,2,3\n",
            "f.csv:1: expected the model's columns (a, ..), or 2 beside times, found 3",
        ),
        ("a,b\n", "f.csv: expected at least one row, found none"),
        ("", "f.csv: expected at least one row, found none"),
    ] {
        assert_eq!(read(text, 2, &["a", "b"]).unwrap_err(), message);
    }
}
