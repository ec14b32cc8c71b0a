//! Tests of `margin.rs`.

use super::*;

#[test]
fn margins_count_from_rest_and_the_one_used_up_most_comes_first() {
    let mut all = [
        Margin::new(Limited::Pulse, 20.0, 200.0),
        Margin::new(Limited::SkinPeak, 38.0, 43.0),
        Margin::new(Limited::Henriques, f64::NAN, 0.01),
        Margin::new(Limited::SkinDeep, f64::NEG_INFINITY, 41.0),
        Margin::new(Limited::Burst, f64::INFINITY, 50.0),
    ];
    sort(&mut all);
    let names = all.map(|m| m.of.name());
    assert_eq!(names[2..], ["skin at 0.1 mm", "pulse", "skin at 0.4 mm"]);
    assert_eq!(all[2].used_milli_percent(), Some(50_000));
    assert!((all[2].left() - 5.0).abs() < 1e-12 && !all[2].over());
    assert_eq!(all[4].used_milli_percent(), Some(0));
    assert!(all[0].over() && all[1].over());
    let json = serde_json::to_value(all[3]).unwrap();
    assert_eq!(json["used"], 0.1);
    assert_eq!(json["margin"], 180.0);
}

#[test]
fn shares_are_rounded_and_stay_in_their_range() {
    assert_eq!(share_milli_percent(1, 3), Some(33_333));
    assert_eq!(share_milli_percent(-2, 3), Some(-66_667));
    assert_eq!(share_milli_percent(i128::from(i64::MAX), 1), Some(i64::MAX));
    assert_eq!(share_milli_percent(1, 0), None);
}
