//! OE x OUTNE x OUTDRV x INVRT (document: "Outputs", lines 2 and 3).

use super::*;
use palpate_emulators::display::pca9685::Hazard;

/// MODE2 under test, with channel 0 full on and channel 1 full off: their pins with OE low and high.
fn pins(mode2: u8) -> [Pin; 4] {
    let mut bench = Bench::awake();
    bench.write(&[map::MODE2, mode2]);
    bench.channel(0, 0x1000, 0);
    let low = [bench.pin(0), bench.pin(1)];
    bench.chip(|chip, now| chip.set_output_enable_pin(now, true));
    [low[0], low[1], bench.pin(0), bench.pin(1)]
}

#[test]
fn oe_outne_outdrv_invrt() {
    use Pin::{High as H, HighZ as Z, Low as L};
    // MODE2: INVRT 10, OUTDRV 04, OUTNE 03. Columns: OE low on, off; OE high on, off.
    let table = [
        (0x00, [Z, L, L, L]),
        (0x01, [Z, L, Z, Z]),
        (0x02, [Z, L, Z, Z]),
        (0x03, [Z, L, Z, Z]),
        (0x04, [H, L, L, L]),
        (0x05, [H, L, H, H]),
        (0x06, [H, L, Z, Z]),
        (0x07, [H, L, Z, Z]),
        (0x10, [L, Z, L, L]),
        (0x11, [L, Z, Z, Z]),
        (0x12, [L, Z, Z, Z]),
        (0x13, [L, Z, Z, Z]),
        (0x14, [L, H, L, L]),
        (0x15, [L, H, H, H]),
        (0x16, [L, H, Z, Z]),
        (0x17, [L, H, Z, Z]),
    ];
    for (mode2, expected) in table {
        assert_eq!(pins(mode2), expected, "MODE2 = {mode2:02x}");
    }
}

#[test]
fn outne_01_with_totem_pole_and_oe_high_is_flagged_as_a_hazard() {
    for mode2 in 0..0x20 {
        let mut bench = Bench::awake();
        bench.write(&[map::MODE2, mode2 & !0x08]);
        bench.chip(|chip, now| chip.set_output_enable_pin(now, true));
        let at = bench.now();
        let hazards = bench.chip(|chip, _| chip.hazards().to_vec());
        if mode2 & 0x07 == 0x05 {
            assert_eq!(hazards, [(Nanos(at), Hazard::OutputEnableDrivesAll)]);
            assert_eq!(bench.chip(|chip, _| chip.pins()), [Pin::High; 16]);
        } else {
            assert_eq!(hazards, []);
        }
    }
}

#[test]
fn the_hazard_is_flagged_when_the_mode_changes_with_oe_high_and_once_each_time() {
    let mut bench = Bench::awake();
    bench.chip(|chip, now| chip.set_output_enable_pin(now, true));
    for mode2 in [0x05, 0x05, 0x15, 0x04, 0x05] {
        bench.write(&[map::MODE2, mode2]);
    }
    assert_eq!(bench.chip(|chip, _| chip.hazard_count()), 2);
}

#[test]
fn oe_acts_at_its_own_nanosecond_in_mid_pulse() {
    let mut bench = Bench::awake();
    bench.channel(0, 0, 2000);
    let start = bench.now();
    bench.wait_ns(777);
    bench.chip(|chip, now| chip.set_output_enable_pin(now, true));
    bench.wait_ns(PERIOD);
    bench.chip(|chip, now| chip.set_output_enable_pin(now, false));
    let back = start + 777 + PERIOD;
    assert_eq!(
        bench.take(0),
        [(start, true), (start + 777, false), (back, true)]
    );
}

#[test]
fn after_a_host_dies_the_chip_goes_on_driving_what_it_was_last_told() {
    let mut bench = Bench::awake();
    bench.channel(0, 0, 100);
    let hour = 3_600_000_000_000 / PERIOD * PERIOD;
    let duty = bench.duty(0, hour);
    assert!((duty - 100.0 / 4096.0).abs() < 1e-9);
}
