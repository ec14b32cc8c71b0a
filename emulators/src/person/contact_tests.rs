//! How wires lie on a person: the same for one person, other for another.

use super::*;

#[test]
fn a_person_stays_the_same_and_a_trial_drifts_slowly() {
    let one = WireContacts::new(7, 1, 1, 8);
    assert_eq!(one, WireContacts::new(7, 1, 1, 8));
    let again = WireContacts::new(7, 1, 2, 8);
    assert!((0..8).all(|w| one.wires[w].constant == again.wires[w].constant));
    assert!((0..8).all(|w| one.wires[w].waves != again.wires[w].waves));
    for wire in 0..8 {
        for step in 0..1000 {
            let t = f64::from(step) * 0.01;
            let change = one.factor(wire, t + 0.01) / one.factor(wire, t);
            assert!((change - 1.0).abs() < 0.02, "2 % in 10 ms at most");
        }
    }
}

#[test]
fn factors_spread_as_stated() {
    let (mut sum, mut squares, mut n) = (0.0, 0.0, 0.0);
    for person in 0..200 {
        let contacts = WireContacts::new(1, person, 0, 8);
        for wire in 0..8 {
            let log = libm::log(contacts.factor(wire, 3.3));
            (sum, squares, n) = (sum + log, squares + log * log, n + 1.0);
        }
    }
    let (mean, spread) = (sum / n, libm::sqrt(squares / n));
    assert!(
        mean.abs() < 0.03 && (spread - 0.25).abs() < 0.02,
        "{mean} {spread}"
    );
}
