//! Boxes by hand, and the Mann-Whitney U test against scipy.

use super::*;
use serde_json::Value;

/// What scipy says of samples with many ties, few, all alike, of unequal size: `ci/peers/panel.py oracle`.
#[test]
fn mann_whitney_is_scipys() {
    let oracle: Vec<Value> = serde_json::from_str(include_str!("oracle.json")).unwrap();
    assert!(oracle.len() > 50);
    for case in &oracle {
        let sample = |key: &str| -> Vec<u8> {
            let all = case[key].as_array().unwrap().iter();
            all.map(|v| v.as_u64().unwrap() as u8).collect()
        };
        let (u, p) = mann_whitney(&sample("a"), &sample("b")).unwrap();
        let off = |found: f64, key: &str| (found - case[key].as_f64().unwrap()).abs();
        assert!(off(u, "u") < 1e-9 && off(p, "p") < 1e-9, "{u} {p} {case}");
    }
    assert_eq!(mann_whitney(&[], &[1]), None);
}

#[test]
fn boxes_have_linear_quartiles_and_outliers() {
    let found = Box5::new(&[3, 3, 4, 4, 4, 5, 6, 1, 4, 4, 3, 4]).unwrap();
    let expected = Box5 {
        low: 3.0,
        q1: 3.0,
        median: 4.0,
        q3: 4.0,
        high: 5.0,
        outliers: vec![1, 6],
    };
    assert_eq!(found, expected);
    let even = Box5::new(&[1, 2, 3, 4]).unwrap();
    assert_eq!((even.q1, even.median, even.q3), (1.75, 2.5, 3.25));
    assert_eq!(Box5::new(&[]), None);
}
