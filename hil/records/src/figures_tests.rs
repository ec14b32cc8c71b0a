//! Tests of `figures.rs`.

use super::*;
use crate::margin::Limited;
use crate::synthetic;

#[test]
fn figures_are_the_ledgers_own_numbers() {
    let mut trace = synthetic::circle(2);
    trace.ledger.margins = vec![
        Margin::new(Limited::Pulse, 250.0, 200.0),
        Margin::new(Limited::Burst, 30.595_84, 50.0),
    ];
    let all = figures(&trace);
    let of = |name: &str| all.iter().find(|f| f.name == name).unwrap();
    assert_eq!(
        of("stimuli").text(of("stimuli").value),
        trace.ledger.driven.stimuli.to_string()
    );
    let burst = of("burst");
    assert_eq!((burst.value, burst.used), (Some(30_596), Some(61_192)));
    assert!(of("pulse").over && !burst.over);
    assert_eq!(burst.text(burst.limit), "50.000");
}
