//! Wires beside, on a thread or here, against the same wires step by step.

use palpate_core::physics::{TissueParameters, WireParameters};

use super::*;
use crate::person::channels::Person;

fn wearing() -> Wearing {
    let (wire, tissue) = (WireParameters::FINAL, TissueParameters::DEFAULT);
    let mut wearing = Wearing::new(&wire, &tissue, 2).unwrap();
    let person = Person {
        vibration_um: 0.6,
        flutter_um: 5.0,
        np2_um: None,
        growth: [0.7, 1.0],
    };
    wearing.by(person, &[(0.0, 0.0), (9.5, 0.0)]).unwrap();
    wearing
}

/// Bursts of both wires, an onset every 60 ms; each current is said again, as a display does.
fn bursts(mut set: impl FnMut(usize, Nanos, f64), mut onset: impl FnMut(Nanos)) {
    for burst in 0..40_u64 {
        for pulse in 0..3 {
            let wire = (burst % 2) as usize;
            let at = Nanos::from_micros(burst * 60_000 + pulse * 15_000);
            for (after, amps) in [(0, 1.2), (10, 1.2), (150, 0.0), (160, 0.0)] {
                set(wire, at + Nanos::from_micros(after), amps);
            }
        }
        onset(Nanos::from_micros((burst + 1) * 60_000));
    }
}

#[test]
fn the_same_is_felt_wherever_the_wires_are_computed() {
    let mut plain = wearing();
    let mut expected = Vec::new();
    let steps = std::cell::RefCell::new(&mut plain);
    bursts(
        |wire, at, amps| steps.borrow_mut().wires[wire].set_current(at, amps),
        |now| expected.push(steps.borrow_mut().onset(now)),
    );
    assert_eq!(expected.len(), 40);
    assert!(expected.iter().all(Option::is_some));
    let thread: Aside = |work| std::thread::Builder::new().spawn(work).is_ok();
    for aside in [None, Some(thread), Some(|_| false)] {
        let mut beside = Beside::new(wearing(), aside);
        let steps = std::cell::RefCell::new(&mut beside);
        bursts(
            |wire, at, amps| steps.borrow_mut().set_current(wire, at, amps),
            |now| steps.borrow_mut().onset(now),
        );
        assert_eq!(beside.finish(), expected);
    }
}
