//! Tests of `shape.rs`.

use super::*;

fn leaves(json: &str) -> Vec<(String, String)> {
    let mut leaves = Vec::new();
    flatten("", &serde_json::from_str(json).unwrap(), &mut leaves);
    leaves
}

fn shape(json: &str) -> Option<Shape> {
    let names: Vec<String> = leaves(json).into_iter().map(|leaf| leaf.0).collect();
    Shape::find(json.as_bytes(), &names)
}

#[test]
fn texts_of_one_shape_give_the_numbers_of_their_trees() {
    let first = r#"{"z": [1, -2.5, 0], "frame\"": "skin 7", "a": {"c":3,"b": 4}}"#;
    let mut shape = shape(first).unwrap();
    for next in [
        first,
        r#"{"z": [65535, 0.25, 1], "frame\"": "skin 7", "a": {"c":-3,"b": 123456}}"#,
    ] {
        let mut row = Vec::new();
        assert!(shape.add(next.as_bytes(), &mut row));
        let expected: String = leaves(next)
            .into_iter()
            .map(|leaf| ",".to_owned() + &leaf.1)
            .collect();
        assert_eq!(String::from_utf8(row).unwrap(), expected);
    }
}

#[test]
fn another_shape_adds_nothing() {
    let first = r#"{"a": [1, 2], "s": "x"}"#;
    let mut shape = shape(first).unwrap();
    for other in [
        r#"{"a": [1, 2], "s": "y"}"#,
        r#"{"a": [1, 2, 3], "s": "x"}"#,
        r#"{"a": [1], "s": "x"}"#,
        r#"{"a": [1, 2], "s": "x"} "#,
        r#"{"a": [1, 2], "s": "x""#,
        r#"{"a": [1, 1e5], "s": "x"}"#,
        r#"{"a": [1, -0], "s": "x"}"#,
        r#"{"a": [1, 007], "s": "x"}"#,
        r#"{"a": [1, 2.], "s": "x"}"#,
        r#"{"a": [1, null], "s": "x"}"#,
        r#"{"a": [1, 123456789012345678], "s": "x"}"#,
        "",
    ] {
        let mut row = Vec::new();
        assert!(!shape.add(other.as_bytes(), &mut row), "{other}");
        assert_eq!(row, b"");
    }
}

#[test]
fn numbers_in_texts_and_truths_have_no_shape() {
    for json in [
        r#"{"data": "0064,00c8", "n": 1}"#,
        r#"{"a": true, "b": 1}"#,
        r#"{"a": "1.5", "b": 1}"#,
        r#"{"a": 1, "a": 2}"#,
        r#"{"a": 1e5}"#,
        r#"{"a": 123456789012345678}"#,
        r#"[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 123456789012345678]"#,
    ] {
        assert!(shape(json).is_none(), "{json}");
    }
}
