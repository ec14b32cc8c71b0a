//! Tests of `timeplot.rs`.

use super::*;

#[test]
fn a_line_keeps_extremes_in_few_whole_numbers_and_breaks_where_a_value_is_missing() {
    let points = [(0, 1), (2, 9), (4, -5), (9, 2)].map(Some);
    let points = points
        .into_iter()
        .chain([None, Some((30, 3)), Some((31, 3))]);
    assert_eq!(envelope(points, 10), "m0 1l2 8 2-14 5 7m21 1l1 0");
    let level = (0..1000).map(|t| Some((t, 7)));
    assert!(envelope(level, 10).len() < 2000);
}

#[test]
fn bars_and_dots_are_told_from_the_one_before() {
    let mut pen = Pen::default();
    pen.bar((10, 50), 5, 20);
    pen.bar((30, 50), 5, 10);
    pen.dot((31, 4));
    assert_eq!(pen.finish(), "m10 50v-20h5v20zm20 0v-10h5v10zm1-46h0");
}

#[test]
fn an_hour_costs_what_its_columns_do() {
    let mut plot = TimePlot::new("x", "", 100.0, (0, 3_600_000_000), Scale::exact(0.0, 1.0));
    let wild = (0..400_000_u64).map(|n| (n * 9000, (n * 7919 % 1000) as f64 / 1e3));
    plot.line("wild", "series", wild);
    let page = plot.finish(2, "");
    assert!(page.len() < 120_000, "{} bytes", page.len());
}
