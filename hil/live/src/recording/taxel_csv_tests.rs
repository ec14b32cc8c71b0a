//! Tests of `taxel_csv.rs`.

use super::*;

/// All rows of a source, with their times.
fn all(source: &dyn RowSource) -> Vec<(u64, Vec<u16>)> {
    let (mut rows, mut row, mut all) = (source.rows().unwrap(), Vec::new(), Vec::new());
    while let Some(time) = rows.next_row(&mut row).unwrap() {
        all.push((time, row.clone()));
    }
    all
}

#[test]
fn a_recording_that_is_not_held_has_the_same_rows_as_often_as_wanted() {
    let path = std::env::temp_dir().join(format!("palpate-long-{}.csv", std::process::id()));
    let rows = (0..50).map(|n| format!("{},{n},7\n", 500 + n * 10_000));
    let text = format!("time_us,txl1_z,txl2_z\n{}", rows.collect::<String>());
    std::fs::write(&path, text).unwrap();
    let columns = Columns {
        taxels: 2,
        axes: 1,
        layout: "l".into(),
    };
    let read = |most| {
        read_holding(&path, &columns, &Reading::default(), most)
            .unwrap()
            .0
    };
    let (held, long) = (read(1000), read(10));
    assert_eq!((held.frames(), held.span_us()), (50, 490_000));
    assert_eq!((long.frames(), long.span_us()), (50, 490_000));
    assert_eq!(all(&*long), all(&*held));
    assert_eq!(all(&*long), all(&*held), "a second pass");
    std::fs::remove_file(&path).unwrap();
}
