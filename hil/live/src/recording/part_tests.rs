//! Tests of `part.rs`.

use palpate_run::TaxelTable;

use super::*;

#[test]
fn modules_side_by_side_are_taken_apart() {
    let whole: Arc<dyn RowSource> = Arc::new(TaxelTable {
        time_us: vec![5, 15],
        counts: vec![1, 2, 3, 4, 5, 6],
        columns: 3,
    });
    let parts = Part::all_of(&whole, &[1, 2]);
    let read = |part: &Arc<dyn RowSource>| {
        assert_eq!((part.frames(), part.span_us()), (2, 10));
        let (mut rows, mut row, mut all) = (part.rows().unwrap(), Vec::new(), Vec::new());
        while let Some(time) = rows.next_row(&mut row).unwrap() {
            all.push((time, row.clone()));
        }
        all
    };
    assert_eq!(read(&parts[0]), [(5, vec![1]), (15, vec![4])]);
    assert_eq!(read(&parts[1]), [(5, vec![2, 3]), (15, vec![5, 6])]);
    assert_eq!(parts[1].columns(), 2);
}
