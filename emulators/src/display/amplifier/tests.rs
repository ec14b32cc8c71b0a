//! Tests of `mod.rs`.

use super::*;

fn edge(at: u64, channel: u8, pin: Pin) -> Edge {
    Edge {
        at: Nanos(at),
        channel: Channel(channel),
        pin,
    }
}

#[test]
fn a_high_pin_gives_the_set_current_and_nothing_else_does() {
    let mut amplifier = Amplifier::new(Milliamps(300));
    let change = amplifier.edge(edge(5, 2, Pin::High));
    assert_eq!(change.map(|c| (c.at.0, c.current.0)), Some((5, 300)));
    assert_eq!(amplifier.edge(edge(6, 2, Pin::High)), None);
    assert_eq!(amplifier.sum(), Milliamps(300));
    assert!(amplifier.edge(edge(7, 2, Pin::HighZ)).is_some());
    assert_eq!(amplifier.sum(), Milliamps(0));
    assert_eq!(amplifier.edge(edge(8, 99, Pin::High)), None);
}

#[test]
fn a_stuck_output_stays_on_and_an_open_wire_stays_cold() {
    let mut amplifier = Amplifier::new(Milliamps(300));
    let stuck = amplifier.set_fault(Nanos(1), Channel(1), Some(AmplifierFault::StuckOn));
    assert_eq!(stuck.map(|c| c.current.0), Some(300));
    amplifier.set_fault(Nanos(1), Channel(2), Some(AmplifierFault::OpenWire));
    assert_eq!(amplifier.edge(edge(2, 2, Pin::High)), None);
    assert_eq!(amplifier.sum(), Milliamps(300));
    assert_eq!(
        amplifier
            .set_fault(Nanos(3), Channel(2), None)
            .map(|c| c.current.0),
        Some(300)
    );
}

#[test]
fn a_ramp_gives_the_energy_of_its_equivalent_edges() {
    let rise = Nanos(3000);
    let on = takes_effect(&edge(0, 0, Pin::High), rise);
    let off = takes_effect(&edge(100_000, 0, Pin::Low), rise);
    // Integral of the squared current over both ramps and what lies between, per squared full current.
    let steps = 300_000;
    let true_ns: f64 = (0..steps)
        .map(|i| (f64::from(i) + 0.5) * 103_000.0 / f64::from(steps))
        .map(|t| (t / 3000.0).min(1.0).min((103_000.0 - t) / 3000.0))
        .map(|part| part * part * 103_000.0 / f64::from(steps))
        .sum();
    assert!((true_ns - off.since(on).0 as f64).abs() < 0.1, "{true_ns}");
}

#[test]
fn a_set_current_flows_while_the_pin_is_high_with_its_error() {
    let error = SetError {
        gain: 1.01,
        offset_ma: -3.0,
    };
    let set = |code| error.current(Milliamps(990), code);
    // 990 mA of 4095 steps: 999.9 and 499.85 (at 2047 of them), less 3.
    assert_eq!([set(4095), set(2047), set(0)], [997, 497, 0].map(Milliamps));
    let mut amplifier = Amplifier::new(set(0));
    assert_eq!(amplifier.set(Nanos(1), Channel(4), set(2047)), None);
    assert_eq!(amplifier.peak(Channel(4)), Milliamps(497));
    let on = amplifier.edge(edge(2, 4, Pin::High));
    assert_eq!(on.map(|c| c.current.0), Some(497));
    let raised = amplifier.set(Nanos(3), Channel(4), set(4095));
    assert_eq!(raised.map(|c| (c.at.0, c.current.0)), Some((3, 997)));
    assert_eq!(amplifier.sum(), Milliamps(997));
}

#[test]
fn a_ramp_between_two_currents_takes_effect_where_it_puts_the_same_energy() {
    let rise = Nanos(30_000);
    for (was, is) in [(0, 900), (900, 0), (300, 900), (900, 300), (500, 500)] {
        let (from, to) = (f64::from(was), f64::from(is));
        // The square of a straight line, over its length.
        let ramp = 30_000.0 * (from * from + from * to + to * to) / 3.0;
        let at = settles(Milliamps(was), Milliamps(is), rise);
        let step = from * from * at.0 as f64 + to * to * (30_000 - at.0) as f64;
        assert!((ramp - step).abs() <= 900.0 * 900.0, "{was} to {is}");
    }
    assert_eq!(settles(Milliamps(0), Milliamps(900), rise), Nanos(20_000));
    assert_eq!(settles(Milliamps(900), Milliamps(0), rise), Nanos(10_000));
    assert_eq!(settles(Milliamps(0), Milliamps(0), rise), Nanos(0));
}
