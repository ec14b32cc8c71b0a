//! Bad recordings and what is said about them.

use super::super::taxel_csv::parse;
use super::super::*;

fn columns() -> Columns {
    Columns {
        taxels: 2,
        axes: 1,
        layout: "two".into(),
    }
}

fn say(text: &[u8], rate: Option<f64>) -> String {
    parse("f.csv", text, &columns(), rate)
        .unwrap_err()
        .to_string()
}

#[test]
fn good_rows_read_with_either_time() {
    let table = parse(
        "f.csv",
        &b"txl1_z,txl2_z\n1.0,65535\n\n 0 , 2\r\n"[..],
        &columns(),
        Some(8.0),
    );
    let table = table.unwrap();
    assert_eq!((table.frames(), &table.time_us[..]), (2, &[0, 125_000][..]));
    assert_eq!(table.frame(1), Some(&[0, 2][..]));
    assert_eq!(table.frame(2), None);
    let text = &b"\xEF\xBB\xBFtime_us,txl1_z,txl2_z\n7,1,2"[..];
    assert_eq!(parse("f.csv", text, &columns(), None).unwrap().time_us, [7]);
}

#[test]
fn bad_recordings_name_line_and_column() {
    let cases: &[(&[u8], Option<f64>, &str)] = &[
        (
            b"",
            Some(1.0),
            "f.csv: expected a header and rows, found an empty file",
        ),
        (
            b"txl1_z,txl2_z\n",
            Some(1.0),
            "f.csv: expected at least one row, found a header alone",
        ),
        (
            b"1,2\n3,4\n",
            Some(1.0),
            "f.csv:1: column 1: expected the header `txl1_z`, found `1`",
        ),
        (
            b"txl1_z;txl2_z\n1;2\n",
            Some(1.0),
            "f.csv:1: column 1: expected the header `txl1_z`, found `txl1_z;txl2_z`",
        ),
        (
            b"time_us,txl1_z,txl2_z\n0,1,2\n18446744073709551615,1,2\n",
            None,
            "f.csv:3: column 1 (time_us): expected at most a day after the first row, 0, found `18446744073709551615`",
        ),
        (
            b"txl1_z\n1\n",
            Some(1.0),
            "f.csv:1: expected 2 taxel columns (2 taxels of 1 axes in layout `two`), found 1",
        ),
        (
            b"txl1_z,txl2_z,txl3_z\n1,2,3\n",
            Some(1.0),
            "f.csv:1: expected 2 taxel columns (2 taxels of 1 axes in layout `two`), found 3",
        ),
        (
            b"txl1_z,txl2_z\n1,2\n3\n",
            Some(1.0),
            "f.csv:3: expected 2 columns as in the header, found 1",
        ),
        (
            b"txl1_z,txl2_z\n1,2,3\n",
            Some(1.0),
            "f.csv:2: expected 2 columns as in the header, found 3",
        ),
        (
            b"txl1_z,txl2_z\n1,2\n",
            Some(0.0),
            "f.csv: expected a rate above 0 Hz, found 0",
        ),
        (
            b"txl1_z,txl2_z\n1,2\n",
            Some(f64::NAN),
            "f.csv: expected a rate above 0 Hz, found NaN",
        ),
        (
            b"txl1_z,txl2_z\n1,2\n",
            None,
            "f.csv:1: expected a first column time_us, or a rate (--rate HZ), found neither",
        ),
        (
            b"txl1_z,txl2_z\n1,2\n1,abc\n",
            Some(1.0),
            "f.csv:3: column 2 (txl2_z): expected a whole count from 0 to 65535, found `abc`",
        ),
        (
            b"txl1_z,txl2_z\nNaN,2\n",
            Some(1.0),
            "f.csv:2: column 1 (txl1_z): expected a whole count from 0 to 65535, found `NaN`",
        ),
        (
            b"txl1_z,txl2_z\ninf,2\n",
            Some(1.0),
            "f.csv:2: column 1 (txl1_z): expected a whole count from 0 to 65535, found `inf`",
        ),
        (
            b"txl1_z,txl2_z\n1,65536\n",
            Some(1.0),
            "f.csv:2: column 2 (txl2_z): expected a whole count from 0 to 65535, found `65536`",
        ),
        (
            b"txl1_z,txl2_z\n-1,2\n",
            Some(1.0),
            "f.csv:2: column 1 (txl1_z): expected a whole count from 0 to 65535, found `-1`",
        ),
        (
            b"txl1_z,txl2_z\n1.5,2\n",
            Some(1.0),
            "f.csv:2: column 1 (txl1_z): expected a whole count from 0 to 65535, found `1.5`",
        ),
        (
            b"txl1_z,txl2_z\n,2\n",
            Some(1.0),
            "f.csv:2: column 1 (txl1_z): expected a whole count from 0 to 65535, found nothing",
        ),
        (
            b"txl1_z,txl2_z\n1e400,2\n",
            Some(1.0),
            "f.csv:2: column 1 (txl1_z): expected a whole count from 0 to 65535, found `1e400`",
        ),
        (
            b"txl1_z,txl2_z\n\xFF,2\n",
            Some(1.0),
            "f.csv:2: column 1 (txl1_z): expected a whole count from 0 to 65535, found `\u{FFFD}`",
        ),
        (
            b"time_us,txl1_z,txl2_z\n5,1,2\n5,1,2\n",
            None,
            "f.csv:3: column 1 (time_us): expected more than the row before, 5, found `5`",
        ),
        (
            b"time_us,txl1_z,txl2_z\n-5,1,2\n",
            None,
            "f.csv:2: column 1 (time_us): expected a whole number of microseconds, found `-5`",
        ),
        (
            b"time_us,txl1_z,txl2_z\n5,1\n",
            None,
            "f.csv:2: expected 3 columns as in the header, found 2",
        ),
    ];
    for (text, rate, expected) in cases {
        assert_eq!(say(text, *rate), *expected);
    }
}

#[test]
fn a_missing_file_is_named() {
    let error = read_taxel_csv(std::path::Path::new("no/such.csv"), &columns(), None);
    assert!(
        error
            .unwrap_err()
            .to_string()
            .starts_with("no/such.csv: expected a readable file, found ")
    );
}
