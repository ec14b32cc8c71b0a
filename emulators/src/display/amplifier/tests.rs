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
