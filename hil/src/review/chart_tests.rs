//! Tests of `chart.rs`.

use super::*;

#[test]
fn rows_that_differ_stand_one_above_the_other() {
    let text = include_str!("../../../fixtures/goldens/sphere-along.schedule.snap");
    let old = Story::read(text).unwrap();
    assert_eq!(stacked(&old, &old, BLOCKS), Vec::<String>::new());
    let mut new = old.clone();
    let line = new.chart.iter().position(|l| l.contains("wire 2")).unwrap();
    new.chart[line] = new.chart[line].replacen('.', "7", 1);
    let shown = stacked(&old, &new, BLOCKS);
    let at = shown.iter().position(|l| l.starts_with('-')).unwrap();
    assert!(shown[at].starts_with("-       wire 2 ...."), "{shown:#?}");
    assert!(
        shown[at + 1].starts_with("+       wire 2 7..."),
        "{shown:#?}"
    );
    assert_eq!(shown.iter().filter(|l| l.contains('|')).count(), 1);
    new.chart[0].push_str(" other");
    assert!(
        stacked(&old, &new, 1)
            .last()
            .unwrap()
            .contains("stretches more")
    );
}
