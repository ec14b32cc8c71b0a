//! Which charts a table gives, and what their lines go through.

use super::*;
use palpate_records::runs::{RunKey, Values};

fn row(set: &[(&str, &str)], seed: u64, error: f64) -> RunRow {
    let set = set.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned()));
    let values = Values::from([("path_error_rmse_mm", error), ("contacts", 5.0)]);
    RunRow {
        key: RunKey {
            set: set.collect(),
            seed,
            ..RunKey::default()
        },
        values,
        ..RunRow::default()
    }
}

#[test]
fn a_line_goes_through_the_means_with_the_spread_over_seeds() {
    let rows = [
        row(&[("tau_ms", "10"), ("law", "a")], 1, 2.0),
        row(&[("tau_ms", "9"), ("law", "a")], 1, 1.0),
        row(&[("tau_ms", "9"), ("law", "a")], 2, 3.0),
        row(&[("tau_ms", "9"), ("law", "b")], 1, 7.0),
    ];
    let rows: Vec<&RunRow> = rows.iter().collect();
    assert_eq!(swept(&rows), ["tau_ms"]);
    let drawn = lines(&rows, "tau_ms", "path_error_rmse_mm");
    let spot = |x, low, mean, high| Spot { x, low, mean, high };
    assert_eq!(
        drawn[0],
        Line {
            name: "law=a".into(),
            spots: vec![spot(9.0, 1.0, 2.0, 3.0), spot(10.0, 2.0, 2.0, 2.0)]
        }
    );
    assert_eq!(drawn[1].name, "law=b");
    let page = page(&Conclusion::default(), &rows);
    for words in [
        "tau_ms [ms]",
        "path error RMSE [mm]",
        "contacts 5",
        "law=b",
        "of 2 seeds",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert_eq!(
        [
            unit("bench.drive.current_ma"),
            unit("illusion.shape"),
            unit("s")
        ],
        ["mA", "", ""]
    );
}
