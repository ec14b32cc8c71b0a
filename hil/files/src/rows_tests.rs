//! Good tables, and what is said of bad ones.

use super::*;
use crate::columns::Columns;

fn columns() -> Columns {
    Columns {
        taxels: 2,
        axes: 1,
        layout: "two".into(),
    }
}

/// Times and values of all rows.
type Table<V> = (Vec<u64>, Vec<Vec<V>>);

fn all<V: Number + Clone>(
    text: &[u8],
    take: Take<'_>,
    timing: Option<&Timing>,
) -> Result<Table<V>, String> {
    let text = Text::new("f.csv", text, 1 << 16);
    let mut rows = Rows::over(text, take, timing).map_err(|e| e.to_string())?;
    let (mut times, mut values, mut row) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(at) = rows.advance(&mut row).map_err(|e| e.to_string())? {
        times.push(at.time_us);
        values.push(row.clone());
    }
    Ok((times, values))
}

fn table(text: &[u8], rate_hz: Option<f64>) -> Result<Table<u16>, String> {
    let columns = columns();
    let timing = Timing {
        rate_hz,
        ..Timing::default()
    };
    all(text, Take::Taxels(&columns), Some(&timing))
}

fn say(text: &[u8], rate: Option<f64>) -> String {
    table(text, rate).unwrap_err()
}

#[test]
fn good_rows_read_with_either_time() {
    let (times, values) = table(b"txl1_z,txl2_z\n1.0,65535\n\n 0 , \"2\"\r\n", Some(8.0)).unwrap();
    assert_eq!(times, [0, 125_000]);
    assert_eq!(values, [[1, 65_535], [0, 2]]);
    let text = b"\xEF\xBB\xBFtime_us,txl1_z,txl2_z\n7,1,2";
    assert_eq!(table(text, None).unwrap().0, [7]);
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
            b"time_us,txl1_z,txl2_z\n0,1,2\n18446744073709551615,1,2\n",
            None,
            "f.csv:3: column 1 (time_us): expected a time near the one before, 0 us (--split-jumps plays what follows right after it), found a jump of the clock, 584542.0 years ahead",
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
            "f.csv:1: expected a rate above 0 Hz, found 0",
        ),
        (
            b"txl1_z,txl2_z\n1,2\n",
            Some(f64::NAN),
            "f.csv:1: expected a rate above 0 Hz, found NaN",
        ),
        (
            b"txl1_z,txl2_z\n1,2\n",
            None,
            "f.csv:1: expected a first column time_us, or a rate (--rate HZ), or --time COLUMN:UNIT, found neither",
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
            "f.csv:2: expected UTF-8 text, found byte 0xFF",
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

fn features(text: &str, count: usize, names: &[&str]) -> Result<Vec<Vec<f32>>, String> {
    let names: Vec<_> = names.iter().map(|n| (*n).to_owned()).collect();
    let names = names.as_slice();
    all(text.as_bytes(), Take::Features { names, count }, None).map(|(_, values)| values)
}

#[test]
fn features_are_taken_by_name_or_by_number() {
    let named = features("time_us,c,b,a\n5,1,2,3\n6,4,5,6.5\n", 2, &["a", "b"]);
    assert_eq!(named.unwrap(), [[3.0, 2.0], [6.5, 5.0]]);
    let counted = features("time_us, x, y\n5, 1, 2\n", 2, &["a", "b"]);
    assert_eq!(counted.unwrap(), [[1.0, 2.0]]);
    let bare = features("1,2\n3,4\n", 2, &["a", "b"]);
    assert_eq!(bare.unwrap(), [[1.0, 2.0], [3.0, 4.0]]);
}

#[test]
fn columns_are_taken_by_prefix_without_some_taxels() {
    let without = ["txl1".to_owned()];
    let take = Take::Prefixed {
        prefix: "txl",
        without: &without,
    };
    let text = Text::new(
        "f.csv",
        &b"time,txl1_x,txl10_x,txl2_x\n1,2,3,4.5\n"[..],
        100,
    );
    let mut rows = Rows::over(text, take, None).unwrap();
    assert_eq!(rows.names().collect::<Vec<_>>(), ["txl10_x", "txl2_x"]);
    let mut values: Vec<f32> = Vec::new();
    rows.advance(&mut values).unwrap();
    assert_eq!(values, [3.0, 4.5]);
    for nothing in ["time,txl1_x\n1,2\n", "1,2\n"] {
        let message = "f.csv:1: expected columns txl*, found none of that name";
        assert_eq!(
            all::<f32>(nothing.as_bytes(), take, None).unwrap_err(),
            message
        );
    }
}

#[test]
fn bad_features_name_line_and_column() {
    for (text, message) in [
        (
            "a,b\n1,2\n3,nan\n",
            "f.csv:3: column 2 (b): expected a finite number, found `nan`",
        ),
        (
            "a,b\n1,2\n3\n",
            "f.csv:3: expected 2 columns as in the header, found 1",
        ),
        (
            "a,b\n1,1e99\n",
            "f.csv:2: column 2 (b): expected a finite number, found `1e99`",
        ),
        (
            "a,c\n1,2\n",
            "f.csv:1: expected a column b, found none of that name",
        ),
        (
            "p,q,r\n1,2,3\n",
            "f.csv:1: expected the model's columns (a, ..), or 2 beside times, found 3",
        ),
        (
            "a,b\n",
            "f.csv: expected at least one row, found a header alone",
        ),
        ("", "f.csv: expected a header and rows, found an empty file"),
    ] {
        assert_eq!(features(text, 2, &["a", "b"]).unwrap_err(), message);
    }
}

fn timed(text: &str, column: &str) -> Result<Vec<u64>, String> {
    let timing = Timing {
        column: Some(column.parse().unwrap()),
        ..Timing::default()
    };
    let take = Take::Counted("channel", 2);
    all::<u16>(text.as_bytes(), take, Some(&timing)).map(|(times, _)| times)
}

/// As FabricSlide writes its files: milliseconds since something, other sensors before the taxels.
#[test]
fn headers_of_others_are_read_by_a_prefix_and_a_named_time() {
    let text = "timestamp, proximity1, channel1, channel2\n4027818,0,63,154\n4027846,0,62,151\n4027846,0,62,151\n";
    let times = timed(text, "timestamp:ms").unwrap();
    assert_eq!(times, [4_027_818_000, 4_027_846_000, 4_027_846_000]);
    assert_eq!(
        timed(text, "when:ms").unwrap_err(),
        "f.csv:1: expected a column when (--time), found `timestamp, proximity1, channel1, channel`"
    );
    assert_eq!(
        timed(&text.replace("channel2", "other"), "timestamp:ms").unwrap_err(),
        "f.csv:1: expected 2 columns channel* (--columns), found 1"
    );
}

#[test]
fn times_that_are_no_microseconds_are_noticed_unless_stated() {
    let rows = |step: u64| -> String {
        let row = |n: u64| format!("{},1,2\n", n * step);
        let rows: String = (0..20).map(row).collect();
        format!("time_us,txl1_z,txl2_z\n{rows}")
    };
    for (step, word) in [(25_000_000, "nanoseconds"), (1, "row numbers")] {
        let text = rows(step);
        let message = say(text.as_bytes(), None);
        assert!(message.contains(&format!("looks like {word}")), "{message}");
        let stated = text.replace("txl", "channel");
        assert_eq!(timed(&stated, "time_us:us").unwrap()[1], step);
    }
    assert!(table(rows(25_000).as_bytes(), None).is_ok());
}

#[test]
fn other_formats_are_named() {
    for (text, found) in [
        ("(1.000000) can0 104#00\n", "a candump log"),
        ("frame,time_us,module,contact\n", "contacts (CSV)"),
        ("name = \"idle\"\n", "TOML settings"),
        ("{\"a\":1}", "JSON"),
        ("\x1f\x08", "bytes"),
    ] {
        let message = say(text.as_bytes(), Some(1.0));
        let expected = format!("f.csv: expected a recording (CSV), found {found}");
        assert!(message == expected || found == "bytes", "{message}");
    }
}

#[test]
fn tables_of_others_are_read_as_they_are() {
    let same = (vec![0, 10_000], vec![vec![1, 2], vec![3, 4]]);
    for (text, note) in [
        ("time_us;txl1_z;txl2_z\n0;1;2\n10000;3;4\n", ""),
        (
            "t,left_2,left_1,temperature\n0.0,2,1,20.5\n0.01,4,3,20.5\n",
            "which is not that of the file",
        ),
        (
            "Time (ms);c1;c2;\n0;1,0;2;\n10;3,0;4;\n",
            "times are column `Time (ms)`, milliseconds",
        ),
        (
            "# t a1 a2\n0.00 1 2\n0.01 3 4\n",
            "taken for seconds by its numbers (--time COLUMN:UNIT",
        ),
        (
            "0 0.00 1.0 2.0\n1 0.01 3.0 4.0\n",
            "no heading: the last columns are `txl1_z`, `txl2_z`",
        ),
        (
            "secs,nsecs,ch0,ch1\n0,0,1,2\n0,10000000,3,4\n",
            "times are `secs` and `nsecs`",
        ),
        (
            "a1 a2 stamp_ns\n1 2 0\n3 4 10000000\n",
            "times are column `stamp_ns`, nanoseconds",
        ),
        (
            "time_us,a_1,b_1\n0,1,2\n10000,3,4\n",
            "columns `a_#`, then `b_#` are the readings",
        ),
    ] {
        let columns = columns();
        let timing = Timing::default();
        let text = Text::new("f.csv", text.as_bytes(), 1 << 16);
        let mut rows = Rows::over(text, Take::Taxels(&columns), Some(&timing)).unwrap();
        let (mut read, mut row) = ((Vec::new(), Vec::new()), Vec::<u16>::new());
        while let Some(at) = rows.advance(&mut row).unwrap() {
            read.0.push(at.time_us);
            read.1.push(row.clone());
        }
        let notes = rows.notes().join("\n");
        assert_eq!(read, same, "{notes}");
        assert_eq!(notes.is_empty(), note.is_empty(), "{notes}");
        assert!(notes.contains(note), "{notes}");
    }
}

#[test]
fn what_a_file_leaves_open_is_asked_for() {
    for (text, said) in [
        (
            "t,a1,a2\n0,1,2\n1,3,4\n",
            "f.csv:1: column `t`: expected what it counts (--time COLUMN:UNIT",
        ),
        (
            "1,2\n3,4\n",
            "f.csv:1: expected a first column time_us, or a rate (--rate HZ)",
        ),
        (
            "1,2,3,4,5\n6,7,8,9,0\n",
            "f.csv:1: expected 2 taxel columns",
        ),
        (
            "time_us,a1,a2,b1,b2\n0,1,2,3,4\n",
            "f.csv:1: expected one group of 2 columns (--columns PREFIX chooses), found 2 of `a#`, 2 of `b#`",
        ),
        (
            "secs,nsecs,a1,a2\n0,1000000000,1,2\n",
            "f.csv:2: columns 1 and 2: expected a whole number below 1000000000",
        ),
    ] {
        let message = say(text.as_bytes(), None);
        assert!(message.starts_with(said), "{message}");
    }
    let wide = say(b"1,2,3,4,5\n", Some(1.0));
    assert!(wide.contains("expected 2 taxel columns"), "{wide}");
}

#[test]
fn a_prefix_takes_columns_by_their_numbers() {
    let text = "t,ch1,ch10,ch2\n0,1,3,2\n";
    let take = Take::Counted("ch", 3);
    let rows = all::<u16>(text.as_bytes(), take, None).unwrap().1;
    assert_eq!(rows, [[1, 2, 3]]);
}
