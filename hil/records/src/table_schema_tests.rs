//! The schema names the columns that the table has.

use super::*;

#[test]
fn the_schema_names_the_columns_of_the_table() {
    let mut header = crate::synthetic::circle(1).header;
    let schema: serde_json::Value = serde_json::from_str(&contacts_schema(Some(&header))).unwrap();
    let names = schema["fields"].as_array().unwrap().iter();
    let names: Vec<_> = names.map(|f| f["name"].as_str().unwrap()).collect();
    assert_eq!(names.join(","), contacts_csv::HEADER);
    assert_eq!(schema["source"], "emulated");
    assert!(!contacts_schema(None).contains("seed"));
    header.displays = vec![crate::trace::DisplayInfo {
        name: "thumb".to_owned(),
        wires: 8,
        modules: vec![0],
    }];
    let schema: serde_json::Value = serde_json::from_str(&contacts_schema(Some(&header))).unwrap();
    let last = schema["fields"].as_array().unwrap().last().unwrap();
    assert_eq!(last["name"], contacts_csv::DISPLAY);
}
