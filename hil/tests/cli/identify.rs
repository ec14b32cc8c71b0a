//! `hil identify`: bad traces are named with key and range.

use std::fs;

use super::{Folder, hil_in};

fn trace(rows: &[String], heading: &str) -> String {
    format!("{heading}\n{}\n", rows.join("\n"))
}

#[test]
fn traces_without_times_clipped_or_too_short_are_refused_by_name() {
    let folder = Folder::new("identify");
    let rows = |of: fn(u32) -> String| (0..60).map(of).collect::<Vec<_>>();
    for (rows, heading, said) in [
        (
            rows(|n| format!("{},0.5", n % 7)),
            "displacement_um,current_a",
            "expected a first column time_us",
        ),
        (
            rows(|n| {
                format!(
                    "{},{},0.5",
                    n * 100,
                    if (20..30).contains(&n) { 99 } else { n % 7 }
                )
            }),
            "time_us,displacement_um,current_a",
            "t.csv:22: displacement_um: expected samples that the instrument has not clipped (choose a wider range), found 10 equal samples of 99, an end of the range",
        ),
        (
            rows(|n| format!("{},{},7.5", n * 100, n % 7)),
            "time_us,displacement_um,current_a",
            "t.csv:2: current_a: expected a number from 0 to 5 A, found 7.5",
        ),
        (
            rows(|n| format!("{},{},0.5", n * 100, n % 7)),
            "time_us,resistance_ohm,current_a",
            "a column displacement_um",
        ),
    ] {
        fs::write(folder.0.join("t.csv"), trace(&rows, heading)).unwrap();
        let said_by = hil_in(&folder.0, &["identify", "t.csv"]);
        assert_eq!(said_by.status, Some(2), "{}", said_by.err);
        assert!(said_by.err.contains(said), "{}", said_by.err);
    }
}
