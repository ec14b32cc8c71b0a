//! Tests of `scan.rs`.

use super::*;
use crate::skin::Module;

fn skin() -> (Layout, Scan) {
    let pad = |name, cols| Module::grid(name, 1, cols, 4.7).unwrap();
    let layout = Layout::new(alloc::vec![pad("a", 2), pad("b", 3)]).unwrap();
    let scan = Scan::new(&layout);
    (layout, scan)
}

#[test]
fn modules_fill_their_own_part_and_what_was_not_read_is_held() {
    let (layout, mut scan) = skin();
    let at = Instant::from_micros;
    let first = [[1; 3], [2; 3], [3; 3]];
    scan.merge(&layout, &ModuleScan::whole(1, at(20), &first))
        .unwrap();
    assert_eq!(scan.seen(), [false, false, true, true, true]);
    let some = ModuleScan {
        fresh: Some(&[true, false, true]),
        ..ModuleScan::whole(1, at(10), &[[7; 3]; 3])
    };
    scan.merge(&layout, &some).unwrap();
    assert_eq!(scan.counts(), [[0; 3], [0; 3], [7; 3], [2; 3], [7; 3]]);
    assert_eq!(scan.fresh(), [false, false, true, false, true]);
    assert_eq!(scan.at(), at(20), "time does not go back");
}

#[test]
fn scans_of_another_layout_change_nothing() {
    let (layout, mut scan) = skin();
    let at = Instant::from_micros(5);
    let unknown = scan.merge(&layout, &ModuleScan::whole(2, at, &[[1; 3]; 2]));
    assert_eq!(
        unknown,
        Err(ScanError::NoSuchModule {
            module: 2,
            modules: 2
        })
    );
    let short = scan.merge(&layout, &ModuleScan::whole(1, at, &[[1; 3]; 2]));
    let flags = ModuleScan {
        fresh: Some(&[true; 2]),
        ..ModuleScan::whole(1, at, &[[1; 3]; 3])
    };
    let wrong = Err(ScanError::Taxels {
        module: 1,
        got: 2,
        expected: 3,
    });
    assert_eq!((short, scan.merge(&layout, &flags)), (wrong, wrong));
    assert!(!scan.seen().contains(&true) && scan.at() == Instant::ZERO);
}
