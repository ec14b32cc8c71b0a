//! Tables come back from their text, whatever the form, cut short or joined.

use super::*;

fn row(seed: u64, shape: &str) -> RunRow {
    let values = Values::from([
        ("path_error_rmse_mm", 0.1 + 0.2),
        ("felt_level_db", 3.0),
        ("felt_jumps", -1e-12),
    ]);
    RunRow {
        key: RunKey {
            scene: "a-scene".into(),
            digest: "0123456789abcdef".into(),
            bench: "emulated".into(),
            set: [("illusion.shape", shape), ("touches", "[[0, 1], \"a\"]")]
                .map(|(k, v)| (k.to_owned(), v.to_owned()))
                .into(),
            seed,
            version: "0.1.0".into(),
        },
        verdict: Verdict::LimitExceeded,
        why: "1 of 13 rows, \"most\" of all, skin".into(),
        values,
    }
}

fn text(form: TableForm, rows: &[RunRow]) -> String {
    let keys = ["illusion.shape", "touches"].into_iter();
    rows.iter()
        .fold(form.head(keys), |text, row| text + &form.line(row))
}

#[test]
fn what_was_written_is_read_and_written_the_same_again() {
    for form in [TableForm::Csv, TableForm::Lines] {
        let rows = [row(1, "1.0"), row(u64::MAX, "1")];
        let first = text(form, &rows);
        assert!(RunTable::is_one(&first), "{first}");
        let read = RunTable::read(&first).unwrap();
        assert_eq!(
            (read.rows[1].key.clone(), read.whole),
            (rows[1].key.clone(), first.len())
        );
        assert_eq!(text(form, &read.rows), first);
        // Joined with `cat`.
        assert_eq!(
            RunTable::read(&(first.clone() + &first))
                .unwrap()
                .rows
                .len(),
            4
        );
    }
    assert_eq!(number(0.1 + 0.2), "0.3");
    assert_eq!([number(-1e-12), number(120.0)], ["0", "120"]);
}

#[test]
fn a_torn_last_line_is_left_out_at_every_byte() {
    for form in [TableForm::Csv, TableForm::Lines] {
        let rows = [row(1, "a"), row(2, "b")];
        let whole = text(form, &rows);
        let first = text(form, &rows[..1]).len();
        for cut in first..whole.len() {
            let read = RunTable::read(&whole[..cut]).unwrap();
            assert_eq!((read.rows.len(), read.whole), (1, first), "{cut}");
        }
        assert_eq!(RunTable::read(&whole[..5]).unwrap(), RunTable::default());
    }
}

#[test]
fn a_line_of_another_table_is_named() {
    let head = TableForm::Csv.head(["a"].into_iter());
    for (text, line) in [
        ("a,b\n".to_owned(), 1),
        ("scene,b\n".to_owned(), 1),
        (format!("{head}x,y\n"), 2),
        (format!("{head}\n{{}}\n"), 3),
    ] {
        assert_eq!(RunTable::read(&text).unwrap_err().line, line, "{text}");
    }
}

#[test]
fn a_row_that_contradicts_another_of_its_key_is_named_with_it() {
    for form in [TableForm::Csv, TableForm::Lines] {
        let first = row(1, "0.02");
        let mut other = row(1, "0.020");
        let keys = [row(2, "0.02"), first.clone(), row(3, "0.02"), other.clone()];
        assert_eq!(RunTable::read(&text(form, &keys)).unwrap().rows.len(), 4);
        other.values.insert("felt_level_db", 3.5);
        let damage = RunTable::read(&text(form, &[row(2, "0.02"), first.clone(), other.clone()]));
        let damage = damage.unwrap_err();
        let heading = usize::from(form == TableForm::Csv);
        assert_eq!(damage.line, heading + 3);
        let words = format!(
            "expected what line {} says at illusion.shape=0.020",
            heading + 2
        );
        assert!(damage.to_string().contains(&words), "{damage}");
        // Of another version it is another run.
        other.key.version = "0.2.0".into();
        RunTable::read(&text(form, &[first, other])).unwrap();
    }
}

#[test]
fn a_number_is_one_value_however_it_is_written() {
    for (value, number) in [
        ("0.020", "0.02"),
        ("2e1", "20"),
        ("20.0", "20"),
        ("+7", "7"),
        ("1_000", "1000"),
        ("-0.0", "0"),
        ("9007199254740993", "9007199254740993"),
        ("nan", "nan"),
        ("balanced", "balanced"),
        ("[0.020]", "[0.020]"),
    ] {
        assert_eq!(by_number(value), number);
    }
}
