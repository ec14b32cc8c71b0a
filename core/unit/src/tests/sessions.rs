//! Who may command a unit.

use super::*;

/// A second host with the same key talks to the unit for a while.
fn visit(rig: &mut Rig, visitor: &mut UnitDriver, ms: u64) {
    for _ in 0..ms * 1000 / STEP {
        rig.now += STEP;
        let now = Instant::from_micros(rig.now);
        let mut buffer = [0; MOST];
        if let Some(datagram) = visitor.datagram(now, Some(now), &mut buffer) {
            rig.air.there.push_back(datagram.to_vec());
        }
        let unit_now = rig.unit_now();
        rig.unit.turn(unit_now, &mut rig.air);
        while let Some(mut datagram) = rig.air.back.pop_front() {
            let _ = visitor.hear(now, &mut datagram);
        }
    }
}

#[test]
fn a_host_keeps_its_unit_until_it_is_silent() {
    let mut rig = Rig::new();
    rig.run(50, true);
    let mut other = driver(1000, true);
    visit(&mut rig, &mut other, 100);
    let now = Instant::from_micros(rig.now);
    assert_eq!(other.ready(now), Err(UnitFault::Busy));
    visit(&mut rig, &mut other, 900);
    assert_eq!(other.ready(Instant::from_micros(rig.now)), Ok(()));
    // The first one finds its session gone and gets no other.
    rig.run(100, true);
    let now = Instant::from_micros(rig.now);
    assert!(rig.driver.ready(now).is_err());
}

#[test]
fn a_stop_by_another_host_stays_until_it_is_acknowledged() {
    let mut rig = Rig::new();
    rig.driver = driver(1, false);
    rig.run(50, true);
    rig.burst(0, &[2], 100);
    rig.run(25, true);
    assert!(rig.any_on());
    // What `hil off` does: knock, greet, stop.
    let key = Key::new(&KEY);
    let mut buffer = [0; MOST];
    let knock = Header {
        kind: Kind::Knock,
        host: 500,
        unit: 0,
        sequence: 1,
    };
    rig.air
        .there
        .push_back(key.seal(&knock, &mut buffer, |_| 0).to_vec());
    let unit_now = rig.unit_now();
    rig.unit.turn(unit_now, &mut rig.air);
    let hello = rig.air.back.pop_back().unwrap();
    let greeted = Header::read(&hello).unwrap();
    let stop = Header {
        kind: Kind::Command,
        host: 500,
        unit: greeted.unit,
        sequence: 2,
    };
    let said = Said {
        request: Request::Stop,
        ..Said::default()
    };
    let write = |out: &mut [u8]| Command::write(out, &said, &[]);
    rig.air
        .there
        .push_back(key.seal(&stop, &mut buffer, write).to_vec());
    rig.unit.turn(unit_now, &mut rig.air);
    assert!(!rig.any_on());
    assert_eq!(rig.unit.guard().latched(), Some(Cause::End));
    // The first host finds its session gone and begins another, by itself: that ends no stop.
    rig.run(1000, true);
    assert_eq!(rig.unit.guard().latched(), Some(Cause::End));
    let ready = rig.driver.ready(Instant::from_micros(rig.now));
    assert_eq!(ready, Err(UnitFault::Stopped(Cause::End)));
    // A person starts the program again.
    rig.driver = driver(900, false);
    rig.run(1000, true);
    assert_eq!(rig.unit.guard().latched(), None);
    assert_eq!(rig.driver.ready(Instant::from_micros(rig.now)), Ok(()));
}

#[test]
fn a_stop_is_acknowledged_only_where_that_is_allowed() {
    for (resumes, then) in [(true, None), (false, Some(Cause::StaleInput))] {
        let mut rig = Rig::new();
        rig.driver = driver(1, resumes);
        rig.run(50, true);
        for n in 0..20 {
            rig.burst(0, &[n % 8], 100);
            rig.run(10, false);
        }
        assert_eq!(rig.unit.guard().latched(), Some(Cause::StaleInput));
        rig.run(100, true);
        assert_eq!(rig.unit.guard().latched(), then);
        let ready = rig.driver.ready(Instant::from_micros(rig.now));
        assert_eq!(ready.is_ok(), resumes, "{ready:?}");
    }
}

#[test]
fn a_unit_that_began_anew_is_found_again_and_takes_nothing_that_was_said_before() {
    let mut rig = Rig::new();
    rig.run(50, true);
    rig.burst(0, &[2], 100);
    rig.run(5, true);
    let recorded = rig.seen.clone();
    let wires = wires();
    let unit = Unit::new(&settings(&wires, 78), rig.chips.clone(), rig.chips.clone());
    rig.unit = unit.unwrap();
    let unit_now = rig.unit_now();
    rig.unit.start(unit_now);
    for datagram in recorded {
        rig.air.there.push_back(datagram);
        rig.unit.turn(unit_now, &mut rig.air);
    }
    rig.air.back.clear();
    assert!(!rig.any_on());
    rig.run(400, true);
    assert_eq!(rig.driver.counts().sessions, 2);
    rig.burst(0, &[5], 100);
    rig.run(30, true);
    assert!(rig.chips.0.borrow().width(0, 5) > 0);
}

#[test]
fn a_wrong_key_or_version_reaches_nothing() {
    let mut rig = Rig::new();
    let other = [3; 32];
    rig.driver = UnitDriver::new(
        &other,
        1,
        UnitSettings {
            delay: DELAY,
            resumes: true,
        },
    );
    rig.run(100, true);
    assert_eq!(
        rig.driver.ready(Instant::from_micros(rig.now)),
        Err(UnitFault::Silent)
    );
    let mut knock = rig.seen[0].clone();
    knock[2] = 2;
    rig.air.there.push_back(knock);
    rig.run(1, true);
    assert!(rig.air.back.is_empty());
}
