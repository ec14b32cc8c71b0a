//! Scans from readings that come in order, late, twice or never.

use super::*;
use crate::skin::Scan;

fn reading(order: u16, value: u16, us: u64) -> TaxelReading {
    TaxelReading {
        module: 0,
        taxel: 15 - order, // the wire's order is not the layout's
        order,
        counts: [value; 3],
        at: Instant::from_micros(us),
    }
}

fn pad() -> Layout {
    Layout::single(Module::grid("pad", 4, 4, 4.7).unwrap()).unwrap()
}

fn assembler() -> ScanAssembler {
    ScanAssembler::new(&pad(), Duration::from_millis(4))
}

/// The skin after every scan that ended.
fn run(a: &mut ScanAssembler, readings: &[TaxelReading]) -> Vec<Scan> {
    let (layout, mut out) = (pad(), Vec::new());
    let mut scan = Scan::new(&layout);
    for r in readings {
        let done = |s: &ModuleScan<'_>| {
            scan.merge(&layout, s).unwrap();
            out.push(scan.clone());
        };
        a.push(r, done).unwrap();
    }
    out
}

#[test]
fn a_scan_ends_with_its_last_taxel() {
    let mut a = assembler();
    let all: Vec<_> = (0..16).map(|o| reading(o, 7, u64::from(o))).collect();
    let scans = run(&mut a, &all);
    assert_eq!(scans.len(), 1);
    assert!(scans[0].fresh().iter().all(|f| *f));
    assert_eq!(scans[0].at(), Instant::from_micros(15));
    assert_eq!(a.lost(), 0);
}

#[test]
fn a_lost_last_frame_does_not_merge_two_scans() {
    let mut a = assembler();
    let mut all: Vec<_> = (0..15).map(|o| reading(o, 1, u64::from(o))).collect();
    all.extend((0..16).map(|o| reading(o, 2, 100 + u64::from(o))));
    let scans = run(&mut a, &all);
    assert_eq!(scans.len(), 2);
    assert!(!scans[0].fresh()[0] && !scans[0].seen()[0]);
    assert!(scans[0].counts()[1..].iter().all(|c| c[0] == 1));
    assert!(scans[1].counts().iter().all(|c| c[0] == 2));
    assert_eq!(a.lost(), 1);
}

#[test]
fn a_lost_taxel_holds_its_value() {
    let mut a = assembler();
    let mut all: Vec<_> = (0..16).map(|o| reading(o, 1, 0)).collect();
    all.extend((0..16).filter(|o| *o != 5).map(|o| reading(o, 2, 10_000)));
    let scans = run(&mut a, &all);
    assert_eq!(scans[1].counts()[10], [1; 3]);
    assert!(!scans[1].fresh()[10]);
    assert_eq!((scans[1].counts()[9], scans[1].fresh()[9]), ([2; 3], true));
}

#[test]
fn silence_ends_a_scan_and_two_may_end_at_one_reading() {
    let mut a = assembler();
    let scans = run(&mut a, &[reading(3, 1, 0), reading(15, 2, 4_001)]);
    assert_eq!(scans.len(), 2);
    assert_eq!((scans[0].fresh()[12], scans[0].fresh()[0]), (true, false));
    assert_eq!((scans[1].fresh()[12], scans[1].fresh()[0]), (false, true));
    run(&mut a, &[reading(0, 1, 10_000)]);
    let mut ended = 0;
    a.flush(Instant::from_micros(14_000), |_| ended += 1);
    assert_eq!(ended, 0);
    a.flush(Instant::from_micros(14_001), |_| ended += 1);
    assert_eq!(ended, 1);
    a.flush(Instant::from_micros(20_000), |_| ended += 1);
    assert_eq!(ended, 1);
}

#[test]
fn unknown_taxels_are_refused() {
    let mut a = assembler();
    let mut r = reading(0, 1, 0);
    r.taxel = 16;
    assert!(a.push(&r, |_| {}).is_none());
    r.module = 1;
    r.taxel = 0;
    assert!(a.push(&r, |_| {}).is_none());
}
