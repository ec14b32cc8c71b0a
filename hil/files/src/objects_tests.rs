//! Tests of `objects.rs`.

use super::*;
use crate::made::Made;

fn table(text: &str) -> Result<String, String> {
    let mut table = String::new();
    let objects = Objects::new(text.as_bytes(), "f.json");
    let read = Made::new(objects).read_to_string(&mut table);
    read.map(|_| table).map_err(|e| e.to_string())
}

#[test]
fn what_xela_server_sends_is_a_table_of_counts() {
    let text = "{\"message\":\"Welcome\",\"sensors\":1}\n\
        {\"message\":7,\"time\":1600000000.25,\"1\":{\"data\":\"8001,7FFF,ffff\",\"model\":\"XR1944\",\"calibrated\":null}}\n\n\
        {\"message\":8,\"time\":1600000000.26,\"1\":{\"data\":\"8002,7FFF,0000\",\"model\":\"XR1944\",\"calibrated\":null}}\n";
    assert_eq!(
        table(text).unwrap(),
        "1.data.0,1.data.1,1.data.2,message,time\n32769,32767,65535,7,1600000000.25\n32770,32767,0,8,1600000000.26\n"
    );
}

#[test]
fn lists_and_tables_have_a_column_per_number() {
    let line = "{\"t\":1,\"taxels\":[{\"x\":1,\"y\":2.5},{\"x\":3,\"y\":-4}],\"on\":true,\"note\":\"a b\",\"s\":\"9\"}";
    assert_eq!(
        table(line).unwrap(),
        "on,s,t,taxels.0.x,taxels.0.y,taxels.1.x,taxels.1.y\n1,9,1,1,2.5,3,-4\n"
    );
}

#[test]
fn a_list_of_objects_has_the_rows_of_its_elements() {
    let (one, two) = (
        "{\"a\":[1,2,3],\"s\":\"],[{\\\"\",\"t\":4}",
        "{\"a\":[5,6,7],\"t\":8}",
    );
    let lines = table(&format!("{one}\n{two}\n")).unwrap();
    assert_eq!(lines, "a.0,a.1,a.2,t\n1,2,3,4\n5,6,7,8\n");
    for list in [
        format!("[{one},{two}]"),
        format!(" [\n  {one},\n  {two}\n]\n"),
    ] {
        assert_eq!(table(&list).unwrap(), lines, "{list}");
    }
    let cut = table(&format!("[{one},\n{{\"a\":[5")).unwrap_err();
    assert!(
        cut.starts_with("f.json:2: expected a whole JSON object"),
        "{cut}"
    );
}

#[test]
fn lines_that_are_no_rows_are_named() {
    let good = "{\"a\":[1,2,3,4]}\n";
    for (bad, said) in [
        (
            "{\"a\":[1,2",
            "f.json:2: expected a whole JSON object in each line",
        ),
        (
            "{\"a\":[1,2,3]}",
            "f.json:2: expected the numbers of the first object, found none under `a.3`",
        ),
    ] {
        let error = table(&format!("{good}{bad}")).unwrap_err();
        assert!(error.starts_with(said), "{error}");
    }
    assert!(
        table("{}\n[]\n")
            .unwrap_err()
            .contains("expected an object with numbers in each line")
    );
}
