//! Tests of `clock.rs`.

use super::*;

fn found(names: &[&str], first: [&str; 3]) -> Result<(Clock, Option<String>), String> {
    let row = |field: &str| vec![field.to_owned(); names.len()];
    let rows = first.map(row);
    let table = Beginning {
        names: Some(names),
        rows: &rows,
        before: 0,
    };
    let found = Timing::default().clock(&table);
    found.map_err(|(key, expected, found)| format!("{key:?} {expected} {found}"))
}

#[test]
fn names_of_times_say_what_they_count() {
    for (name, unit) in [
        ("Time (us)", TimeUnit::Us),
        ("time_ns", TimeUnit::Ns),
        ("Time [ms]", TimeUnit::Ms),
        ("timestamp_s", TimeUnit::S),
        ("%time", TimeUnit::Ns),
        ("Seconds", TimeUnit::S),
        ("T_us", TimeUnit::Us),
        ("host time (µs)", TimeUnit::Us),
    ] {
        assert_eq!(is_time(name), Some(Some(unit)), "{name}");
    }
    for name in ["t", "Receive time", "timestamp", "header.stamp"] {
        assert_eq!(is_time(name), Some(None), "{name}");
    }
    for name in ["s", "us", "left_t", "times", "txl1_x", "ms", "taxels"] {
        assert_eq!(is_time(name), None, "{name}");
    }
}

#[test]
fn numbers_say_what_a_time_counts_or_it_is_asked_for() {
    let unit = |rows| match found(&["t"], rows) {
        Ok((Clock::Column(0, column), Some(_))) => Some(column.unit),
        _ => None,
    };
    assert_eq!(
        unit(["1780409804.29", "1780409804.30", "1780409804.31"]),
        Some(TimeUnit::S)
    );
    assert_eq!(
        unit(["1780409804290", "1780409804300", "1780409804310"]),
        Some(TimeUnit::Ms)
    );
    assert_eq!(unit(["0.0", "0.01", "0.02"]), Some(TimeUnit::S));
    assert_eq!(unit(["4027818", "4027846", "4027874"]), Some(TimeUnit::Ms));
    assert_eq!(unit(["0", "10000", "20000"]), Some(TimeUnit::Us));
    let date = "2026-03-01 12:00:00.25";
    assert_eq!(unit([date, date, date]), Some(TimeUnit::Date));
    for numbers in [
        ["0", "1", "2"],
        ["5", "5", "5"],
        ["0", "700", "1400"],
        ["a", "b", "c"],
    ] {
        assert_eq!(unit(numbers), None, "{numbers:?}");
        assert!(found(&["t"], numbers).unwrap_err().contains("--rate HZ"));
    }
}

#[test]
fn whole_seconds_go_with_the_nanoseconds_beside_them() {
    for names in [["secs", "nsecs"], ["stamp.sec", "stamp.nanosec"]] {
        let rows = [vec!["1763483234".to_owned(), "38210400".to_owned()]];
        let table = Beginning {
            names: Some(&names),
            rows: &rows,
            before: 0,
        };
        let (clock, _) = Timing::default().clock(&table).unwrap();
        assert!(matches!(clock, Clock::Seconds(0, 1)));
        // The seconds alone, as they are asked for, would put a hundred rows at one time.
        let timing = Timing {
            column: Some(format!("{}:s", names[0]).parse().unwrap()),
            ..Timing::default()
        };
        assert!(matches!(
            timing.clock(&table).unwrap().0,
            Clock::Seconds(0, 1)
        ));
    }
}
