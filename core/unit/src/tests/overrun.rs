//! A unit whose wires go off too late, or are not known to be off.

use super::*;

/// A rig that has driven a wire of the second board for some 10 ms of 38.
fn driving(unwired: bool) -> Rig {
    let mut rig = Rig::new();
    rig.chips.0.borrow_mut().unwired = unwired;
    rig.run(50, true);
    rig.burst(1, &[8], 100);
    rig.run(30, true);
    assert!(rig.any_on());
    rig
}

#[test]
fn a_dead_bus_without_a_pin_leaves_a_wire_on_until_the_bus_is_back() {
    for unwired in [false, true] {
        let mut rig = driving(unwired);
        rig.chips.0.borrow_mut().dead = true;
        rig.run(35, true);
        let state = |rig: &Rig| rig.driver.status().unwrap().state;
        assert_eq!(state(&rig), State::Stopped(Cause::ActuatorError));
        rig.run(200, true);
        assert_eq!(rig.any_on(), unwired);
        let stopped = if unwired {
            Cause::Overrun
        } else {
            Cause::ActuatorError
        };
        assert_eq!(state(&rig), State::Stopped(stopped));
        assert_eq!(rig.driver.status().unwrap().stops, 1);
        rig.chips.0.borrow_mut().dead = false;
        rig.run(50, true);
        assert!(!rig.any_on());
        let found = rig.unit.guard().overrun();
        let on_ms = found.map(|found| found.on.as_micros() / 1000);
        assert!(
            on_ms.map_or(!unwired, |ms| unwired && (235..275).contains(&ms)),
            "{on_ms:?}"
        );
        // It does not grow any more, and the host that acknowledges it drives again.
        rig.run(300, true);
        assert_eq!(rig.unit.guard().overrun(), found);
        assert_eq!(state(&rig), State::Ready);
    }
}

#[test]
fn a_unit_that_ends_a_stimulus_too_late_stops() {
    for (gap_ms, over) in [(45, false), (55, true)] {
        let mut rig = driving(false);
        rig.now += gap_ms * 1000;
        rig.run(1, true);
        assert!(!rig.any_on());
        assert_eq!(rig.unit.guard().overrun().is_some(), over, "{gap_ms} ms");
        let expected = over.then_some(Cause::Overrun);
        assert_eq!(rig.unit.guard().latched(), expected);
        assert_eq!(rig.unit.counts().stops, u32::from(over));
    }
}
