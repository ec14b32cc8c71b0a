//! Tests of `taxel_write.rs`.

use super::super::taxel_csv::parse;
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
        write_taxel_csv(&table, &columns, &mut text).unwrap();
        assert_eq!(
            parse("f.csv", text.as_slice(), &columns, None).unwrap(),
            table
        );
    }
}
