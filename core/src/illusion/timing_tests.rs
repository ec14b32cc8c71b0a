//! Tests of `timing.rs`.

use super::*;

const BRUSH: TimingLaw = TimingLaw::TactileBrush;

#[test]
fn thirty_five_milliseconds_give_58_5() {
    let t = BRUSH.timing(Some(Duration::from_millis(35)), None).unwrap();
    assert_eq!(t.soa, Duration::from_micros(58_500));
    assert_eq!(BRUSH.timing(None, None), Ok(t));
    assert_eq!(BRUSH.timing(None, Some(t.soa)), Ok(t));
}

#[test]
fn a_law_never_asks_for_more_than_a_burst() {
    let t = TimingLaw::Fingerpad.timing(None, None).unwrap();
    assert_eq!(t.soa, Duration::from_millis(115));
    assert_eq!(t.duration, LONGEST);
    let stated = TimingLaw::Fingerpad.timing(Some(Duration::from_millis(20)), None);
    assert_eq!(stated.unwrap().duration, Duration::from_millis(20));
}

#[test]
fn overlap_starts_just_under_70_ms() {
    // d <= 0.32 d + 47.3 ms exactly when d <= 69.56 ms (Park 2016).
    let of = |us| BRUSH.timing(Some(Duration::from_micros(us)), None);
    assert!(of(69_558).is_ok());
    assert_eq!(of(69_560), Err(TimingError::Overlap));
    assert_eq!(of(0), Err(TimingError::Zero));
    let close = BRUSH.timing(None, Some(Duration::from_millis(47)));
    assert_eq!(close, Err(TimingError::Zero));
}
