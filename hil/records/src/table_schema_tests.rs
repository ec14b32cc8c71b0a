//! The schema names the columns that the table has.

use super::*;

#[test]
fn the_schema_names_the_columns_of_the_table() {
    let header = crate::synthetic::circle(1).header;
    let schema: serde_json::Value = serde_json::from_str(&contacts_schema(Some(&header))).unwrap();
    let names = schema["fields"].as_array().unwrap().iter();
    let names: Vec<_> = names.map(|f| f["name"].as_str().unwrap()).collect();
    assert_eq!(names.join(","), contacts_csv::HEADER);
    assert_eq!(schema["source"], "emulated");
    assert!(!contacts_schema(None).contains("seed"));
}
