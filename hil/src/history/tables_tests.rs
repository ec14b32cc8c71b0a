//! Runs of two tables in pairs.

use super::*;
use palpate_records::runs::Values;

fn table(rows: &[(u64, f64, &str)]) -> RunTable {
    let row = |(seed, error, version): &(u64, f64, &str)| {
        let values = Values::from([("path_error_rmse_mm", *error)]);
        let key = RunKey {
            seed: *seed,
            version: (*version).to_owned(),
            ..RunKey::default()
        };
        RunRow {
            key,
            values,
            ..RunRow::default()
        }
    };
    RunTable {
        rows: rows.iter().map(row).collect(),
        whole: 0,
    }
}

#[test]
fn versions_may_differ_and_runs_that_lack_are_told() {
    let (a, b) = (
        table(&[(1, 2.0, "0.1"), (2, 4.0, "0.1")]),
        table(&[(2, 5.0, "0.2"), (1, 2.0, "0.2")]),
    );
    let found = compare_tables(&a, &b, Tolerance::default());
    assert_eq!(found.differences.len(), 1);
    let words = found.differences[0].words();
    for part in [
        "path error RMSE mm",
        "3 -> 3.5 (+16.67 %)",
        "1 of 2 runs, most at seed 2: 4 -> 5 (+25.00 %)",
    ] {
        assert!(words.contains(part), "{words}");
    }
    assert_eq!(found.conclusion.verdict, Verdict::Failed);
    let found = compare_tables(&a, &table(&[(1, 2.0, "0.2")]), Tolerance::default());
    assert_eq!(
        found.conclusion.line(),
        "INCOMPLETE: 1 of 2 runs are not in the second table"
    );
    let found = compare_tables(&a, &table(&[(9, 2.0, "0.2")]), Tolerance::default());
    assert_eq!(found.conclusion.verdict, Verdict::Incomplete);
    let both = table(&[(1, 2.0, "0.1"), (2, 4.0, "0.1"), (2, 9.0, "0.2")]);
    let found = compare_tables(&both, &a, Tolerance::default());
    assert!(
        found
            .conclusion
            .why
            .iter()
            .any(|why| why.starts_with("the first table has 1 runs of another version")),
        "{:?}",
        found.conclusion
    );
}

#[test]
fn values_pair_by_number() {
    let table = |shape: &str, error: f64| {
        let mut table = table(&[(1, error, "0.1")]);
        let set = [("illusion.shape".to_owned(), shape.to_owned())];
        table.rows[0].key.set = set.into();
        table
    };
    let (a, b) = (table("0.02", 2.0), table("0.020", 3.0));
    let found = compare_tables(&a, &b, Tolerance::default());
    assert_eq!(found.conclusion.verdict, Verdict::Failed);
    assert_eq!(found.differences.len(), 1);
}
