//! What a supply gives to the wires that are on.

use super::*;

fn loads(asked: &[f64], ohm: f64) -> Vec<Load> {
    let load = |&asked: &f64| Load {
        asked,
        ohm,
        amps: 0.0,
    };
    asked.iter().map(load).collect()
}

#[test]
fn a_supply_sags_with_the_wires_that_are_on() {
    // 5 V behind 0.2 Ohm, wires of 1.9 Ohm behind 0.1 Ohm: 4 V for 2 A.
    let source = SupplySource {
        volts: 5.0,
        ohm: 0.2,
    };
    let mut two = loads(&[2.0, 2.0, 0.0], 2.0);
    source.share(&mut two);
    assert!(two[0].amps == 2.0 && two[1].amps == 2.0 && two[2].amps == 0.0);
    // Eight at once: V = 5 / (1 + 0.2 * 8 / 2) = 2.78 V, 1.39 A each.
    let mut eight = loads(&[2.0; 8], 2.0);
    source.share(&mut eight);
    assert!(
        eight
            .iter()
            .all(|l| (l.amps - 5.0 / 1.8 / 2.0).abs() < 1e-12)
    );
    let stiff = SupplySource {
        volts: f64::INFINITY,
        ohm: 0.0,
    };
    stiff.share(&mut eight);
    assert!(eight.iter().all(|l| l.amps == 2.0));
}

#[test]
fn the_hungriest_wire_gives_way_first() {
    let source = SupplySource {
        volts: 4.0,
        ohm: 0.5,
    };
    let mut unlike = loads(&[1.0, 1.0], 1.0);
    unlike[1].ohm = 5.0;
    source.share(&mut unlike);
    // V = (4 - 0.5) / (1 + 0.5 / 5) = 3.18 V: enough for the first, not for the second.
    let volts = 3.5 / 1.1;
    assert!(unlike[0].amps == 1.0 && (unlike[1].amps - volts / 5.0).abs() < 1e-12);
    // What flows through the source explains the voltage at the wires.
    let sum: f64 = unlike.iter().map(|l| l.amps).sum();
    assert!((4.0 - 0.5 * sum - volts).abs() < 1e-12);
}

#[test]
fn the_supply_peak_is_over_all_wires_and_not_over_a_handover() {
    let mut supply = Supply::default();
    supply.set(Nanos(10), Milliamps(300));
    supply.set(Nanos(20), Milliamps(600)); // the next one on and the first one off in one nanosecond
    supply.set(Nanos(20), Milliamps(300));
    assert_eq!(supply.peak(), (Milliamps(300), Nanos(10)));
    supply.set(Nanos(30), Milliamps(600));
    supply.set(Nanos(40), Milliamps(300));
    assert_eq!(supply.peak(), (Milliamps(600), Nanos(30)));
    assert_eq!(supply.current(), Milliamps(300));
}
