//! Tests of `taxel_write.rs`.

use super::super::{Reading, read_taxel_csv};
use super::*;

#[test]
fn what_is_written_is_read_back() {
    for (axes, taxels) in [(1, 3), (3, 2)] {
        let columns = Columns {
            taxels,
            axes,
            layout: "l".into(),
        };
        let width = taxels * usize::from(axes);
        let table = TaxelTable {
            time_us: vec![0, 10_000, 20_001],
            counts: (0..3 * width as u16).map(|n| n * 3000).collect(),
            columns: width,
        };
        let mut text = Vec::new();
        write_taxel_csv(&table, &columns, &[], &mut text).unwrap();
        let path =
            std::env::temp_dir().join(format!("palpate-write-{axes}-{}.csv", std::process::id()));
        std::fs::write(&path, text).unwrap();
        let (read, notes) = read_taxel_csv(&path, &columns, &Reading::default()).unwrap();
        std::fs::remove_file(&path).unwrap();
        let (mut rows, mut row) = (read.rows().unwrap(), Vec::new());
        for (index, time) in table.time_us.iter().enumerate() {
            assert_eq!(rows.next_row(&mut row).unwrap(), Some(*time));
            assert_eq!(Some(&*row), table.frame(index));
        }
        assert_eq!(
            (rows.next_row(&mut row).unwrap(), notes),
            (None, Vec::new())
        );
    }
}
