//! Registers and reset (document: "Registers and reset").

use super::*;

#[test]
fn reset_values() {
    let mut bench = Bench::one();
    assert_eq!(bench.read(map::MODE1), 0x11);
    assert_eq!(bench.read(map::MODE2), 0x04);
    for (register, value) in [(2, 0xE2), (3, 0xE4), (4, 0xE8), (5, 0xE0)] {
        assert_eq!(bench.read(register), value);
    }
    for n in 0..16 {
        for (k, value) in [(0, 0), (1, 0), (2, 0), (3, 0x10)] {
            assert_eq!(bench.read(6 + 4 * n + k), value, "channel {n} register {k}");
        }
    }
    assert_eq!(bench.read(map::PRE_SCALE), 0x1E);
    assert_eq!(bench.read(map::TESTMODE), 0);
}

#[test]
fn led_registers_lie_at_6_plus_4n_in_the_order_on_l_on_h_off_l_off_h() {
    let mut bench = Bench::one();
    for n in 0..16 {
        bench.write(&[0x06 + 4 * n, 0x10 + n]);
        bench.write(&[0x07 + 4 * n, 0x03]);
        bench.write(&[0x08 + 4 * n, 0x20 + n]);
        bench.write(&[0x09 + 4 * n, 0x05]);
    }
    for n in 0..16 {
        let is: Vec<u8> = (0..4).map(|k| bench.read(map::led(n) + k)).collect();
        assert_eq!(is, [0x10 + n, 0x03, 0x20 + n, 0x05]);
    }
}

#[test]
fn reserved_bits_cannot_be_written() {
    let mut bench = Bench::one();
    bench.write(&[map::MODE2, 0xFF]);
    assert_eq!(bench.read(map::MODE2), 0x1F);
    bench.write(&[0x07, 0xFF]);
    bench.write(&[0x09, 0xFF]);
    assert_eq!((bench.read(0x07), bench.read(0x09)), (0x1F, 0x1F));
}

#[test]
fn reserved_control_bytes_are_not_acknowledged() {
    let mut bench = Bench::one();
    for register in 0..=0xFF_u8 {
        let result = bench.try_write(ADDRESS, &[register]);
        let reserved = (0x46..=0xF9).contains(&register);
        assert_eq!(
            result,
            if reserved {
                Err(Error::DataNack)
            } else {
                Ok(())
            },
            "{register:02x}"
        );
    }
}

#[test]
fn a_refused_control_byte_leaves_the_pointer_alone() {
    let mut bench = Bench::one();
    bench.write(&[map::PRE_SCALE]);
    assert_eq!(
        bench.try_write(ADDRESS, &[0x46, 0x55]),
        Err(Error::DataNack)
    );
    let mut byte = [0];
    bench.bus.read(ADDRESS, &mut byte).unwrap();
    assert_eq!(byte, [0x1E]);
}

#[test]
fn all_led_registers_load_every_channel_and_read_zero() {
    let mut bench = Bench::one();
    bench.wake();
    bench.write(&[map::ALL_LED_ON_L, 0x34, 0x02, 0x78, 0x06]);
    for n in 0..16 {
        let is: Vec<u8> = (0..4).map(|k| bench.read(map::led(n) + k)).collect();
        assert_eq!(is, [0x34, 0x02, 0x78, 0x06]);
    }
    for register in map::ALL_LED_ON_L..=map::ALL_LED_OFF_H {
        assert_eq!(bench.read(register), 0);
    }
}

#[test]
fn auto_increment_wraps_from_45_to_00_when_reading_and_writing() {
    let mut bench = Bench::one();
    bench.wake();
    let mut bytes = [0; 3];
    bench.bus.write_read(ADDRESS, &[0x44], &mut bytes).unwrap();
    assert_eq!(bytes, [0x00, 0x10, 0x21]);
    // OFF_L, OFF_H of channel 15, then MODE1 and MODE2.
    bench.write(&[0x44, 7, 0, map::mode1::AI, 0x06]);
    assert_eq!((bench.read(0x44), bench.read(0x45)), (7, 0));
    assert_eq!((bench.read(0x00), bench.read(0x01)), (0x20, 0x06));
}

#[test]
fn auto_increment_wraps_from_fe_to_00() {
    let mut bench = Bench::one();
    bench.write(&[map::MODE1, 0x31]); // asleep, AI
    let mut bytes = [0; 6];
    bench.bus.write_read(ADDRESS, &[0xFA], &mut bytes).unwrap();
    assert_eq!(bytes, [0, 0, 0, 0, 0x1E, 0x31]);
    bench.write(&[0xFE, 0x55, 0x31, 0x0C]);
    assert_eq!(
        (bench.read(0xFE), bench.read(0x00), bench.read(0x01)),
        (0x55, 0x31, 0x0C)
    );
}

#[test]
fn without_auto_increment_the_pointer_stays() {
    let mut bench = Bench::one();
    bench.write(&[map::SUBADR1, 0x10, 0x20, 0x30]);
    assert_eq!(
        (bench.read(map::SUBADR1), bench.read(map::SUBADR1 + 1)),
        (0x30, 0xE4)
    );
    let mut bytes = [0; 3];
    bench
        .bus
        .write_read(ADDRESS, &[map::PRE_SCALE], &mut bytes)
        .unwrap();
    assert_eq!(bytes, [0x1E; 3]);
}

#[test]
fn auto_increment_set_in_a_write_counts_from_its_own_acknowledge() {
    // Figure 21: AI initially clear, one transaction over MODE1 and all that follows.
    let mut bench = Bench::one();
    bench.write(&[map::MODE1, 0x31, 0x0C, 0x10]);
    assert_eq!(
        (bench.read(0), bench.read(1), bench.read(2)),
        (0x31, 0x0C, 0x10)
    );
}

#[test]
fn the_pointer_outlives_the_transaction() {
    let mut bench = Bench::one();
    bench.write(&[map::PRE_SCALE]);
    let mut byte = [0];
    bench.bus.read(ADDRESS, &mut byte).unwrap();
    assert_eq!(byte, [0x1E]);
}

#[test]
fn pre_scale_is_ignored_while_awake() {
    let mut bench = Bench::awake();
    bench.write(&[map::PRE_SCALE, 100]); // acknowledged, without effect
    assert_eq!(bench.read(map::PRE_SCALE), 30);
    bench.write(&[map::MODE1, 0x31]);
    bench.write(&[map::PRE_SCALE, 100]);
    assert_eq!(bench.read(map::PRE_SCALE), 100);
}

#[test]
fn pre_scale_is_clamped_to_3() {
    let mut bench = Bench::one();
    for value in 0..=255 {
        bench.write(&[map::PRE_SCALE, value]);
        assert_eq!(bench.read(map::PRE_SCALE), value.max(3));
    }
}

#[test]
fn extclk_is_sticky_until_software_reset_or_power_on() {
    let mut bench = Bench::one();
    bench.write(&[map::MODE1, 0x51]);
    for value in [0x11, 0x01, 0x11, 0x21] {
        bench.write(&[map::MODE1, value]);
        assert_eq!(bench.read(map::MODE1), value | 0x40);
    }
    bench.try_write(0, &[6]).unwrap();
    assert_eq!(bench.read(map::MODE1), 0x11);
    bench.write(&[map::MODE1, 0x51]);
    bench.chip(|chip, now| chip.power_cycle(now));
    assert_eq!(bench.read(map::MODE1), 0x11);
}

#[test]
fn the_external_clock_sets_the_frequency_and_without_one_nothing_moves() {
    let mut bench = Bench::one();
    bench.write(&[map::MODE1, 0x11]);
    bench.write(&[map::MODE1, 0x71]);
    bench.write(&[map::MODE1, 0x21]);
    bench.channel(0, 0, 2048);
    bench.wait_us(100_000);
    assert_eq!(bench.take(0), []);
    bench.chip(|chip, now| chip.set_external_clock(now, 50_000_000));
    let start = bench.now();
    bench.wait_ns(PERIOD / 2);
    let half = PERIOD / 4;
    assert_eq!(
        bench.take(0),
        [
            (start, true),
            (start + half, false),
            (start + 2 * half, true)
        ]
    );
}

#[test]
fn a_write_to_the_test_register_is_recorded_as_a_hazard() {
    let mut bench = Bench::one();
    bench.write(&[map::TESTMODE, 1]);
    let hazards = bench.chip(|chip, _| chip.hazards().to_vec());
    assert_eq!(
        hazards[0].1,
        palpate_emulators::display::pca9685::Hazard::TestRegisterWritten
    );
    assert_eq!(bench.read(map::TESTMODE), 0);
}

#[test]
fn a_brown_out_in_mid_burst_leaves_reset_values_and_cold_wires() {
    let mut bench = Bench::awake();
    bench.channel(3, 0, 2000);
    bench.wait_us(1000);
    assert_eq!(bench.pin(3), Pin::High);
    bench.chip(|chip, now| chip.power_off(now));
    assert_eq!(bench.pin(3), Pin::HighZ);
    assert_eq!(bench.try_write(ADDRESS, &[0]), Err(Error::AddressNack));
    bench.wait_us(10);
    bench.chip(|chip, now| chip.power_on(now));
    assert_eq!(bench.read(map::MODE1), 0x11);
    assert_eq!(bench.read(map::led(3) + 3), 0x10);
    assert_eq!(bench.duty(3, 3 * PERIOD), 0.0);
}
