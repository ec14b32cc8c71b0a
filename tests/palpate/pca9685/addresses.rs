//! Addresses, wired-AND reads, software reset (document: "Addresses").

use super::*;

#[test]
fn the_six_pins_give_own_addresses_40_to_7f() {
    for pins in 0..64 {
        let mut bench = Bench::new(&[Config::new(pins)]);
        let own = 0x40 | pins;
        for address in 1..0x80 {
            let answers = bench.try_write(address, &[0]).is_ok();
            assert_eq!(
                answers,
                address == own || address == 0x70,
                "{address:02x} of {own:02x}"
            );
        }
    }
}

#[test]
fn all_call_is_acknowledged_after_reset_and_can_be_moved_and_switched_off() {
    let mut bench = Bench::one();
    bench.try_write(0x70, &[0]).unwrap();
    bench.write(&[map::ALLCALLADR, 0x6B << 1 | 1]);
    assert_eq!(bench.read(map::ALLCALLADR), 0xD6, "lowest bit reads 0");
    assert_eq!(bench.try_write(0x70, &[0]), Err(Error::AddressNack));
    bench.try_write(0x6B, &[0]).unwrap();
    bench.write(&[map::MODE1, 0x10]);
    assert_eq!(bench.try_write(0x6B, &[0]), Err(Error::AddressNack));
}

#[test]
fn sub_addresses_answer_only_when_enabled() {
    let mut bench = Bench::one();
    for (bit, address) in [(0x08, 0x71), (0x04, 0x72), (0x02, 0x74)] {
        bench.write(&[map::MODE1, 0x10]);
        assert_eq!(bench.try_write(address, &[0]), Err(Error::AddressNack));
        bench.write(&[map::MODE1, 0x10 | bit]);
        for other in [0x71, 0x72, 0x74] {
            assert_eq!(bench.try_write(other, &[0]).is_ok(), other == address);
        }
    }
    bench.write(&[map::MODE1, 0x18]);
    bench.write(&[map::SUBADR1, 0x33 << 1]);
    bench.try_write(0x33, &[0]).unwrap();
    assert_eq!(bench.try_write(0x71, &[0]), Err(Error::AddressNack));
}

#[test]
fn a_chip_strapped_to_70_collides_with_all_call() {
    let mut bench = Bench::new(&[Config::new(0x70), Config::new(0x41)]);
    bench.try_write(0x70, &[map::SUBADR1, 0x22]).unwrap(); // meant for the first chip alone
    let other = bench
        .bus
        .with(|s| s.chips()[1].register(map::SUBADR1))
        .unwrap();
    assert_eq!(other, 0x22);
}

#[test]
fn reads_on_shared_addresses_are_a_wired_and() {
    let mut bench = Bench::new(&[Config::new(0x40), Config::new(0x41)]);
    bench
        .try_write(0x40, &[map::PRE_SCALE, 0b1111_0011])
        .unwrap();
    bench
        .try_write(0x41, &[map::PRE_SCALE, 0b0101_1111])
        .unwrap();
    let mut byte = [0];
    bench
        .bus
        .write_read(0x70, &[map::PRE_SCALE], &mut byte)
        .unwrap();
    assert_eq!(byte, [0b0101_0011]);
}

#[test]
fn all_call_writes_reach_every_chip_at_the_same_instant() {
    let mut bench = Bench::new(&[Config::new(0x40), Config::new(0x41), Config::new(0x42)]);
    bench.try_write(0x70, &[map::MODE1, 0x21]).unwrap();
    bench.wait_us(500);
    bench
        .try_write(0x70, &[map::ALL_LED_ON_L, 0, 0, 0, 8])
        .unwrap();
    let stop = bench.now();
    assert_eq!(bench.edges.len(), 48);
    assert!(
        bench
            .edges
            .iter()
            .all(|(_, e)| e.at.0 == stop && e.pin == Pin::High)
    );
}

#[test]
fn software_reset_is_executed_on_stop() {
    let mut bench = Bench::awake();
    bench.channel(0, 0, 4095);
    bench.write(&[map::MODE2, 0x1C]);
    bench.forget();
    bench.try_write(0, &[6]).unwrap();
    let stop = bench.now();
    assert_eq!(bench.read(map::MODE2), 0x04);
    assert_eq!(bench.read(map::MODE1), 0x11);
    assert_eq!(bench.read(map::led(0) + 3), 0x10);
    assert_eq!(bench.pin(0), Pin::Low);
    // INVRT was set: the other pins, high until here, fall with it.
    let edges: Vec<_> = bench.edges.iter().map(|(_, e)| (e.at.0, e.pin)).collect();
    assert_eq!(edges, vec![(stop, Pin::Low); 15]);
}

#[test]
fn another_software_reset_byte_is_not_acknowledged() {
    for byte in (0..=255).filter(|&b| b != 6) {
        let mut bench = Bench::one();
        bench.write(&[map::MODE2, 0x05]);
        assert_eq!(bench.try_write(0, &[byte]), Err(Error::DataNack));
        assert_eq!(bench.read(map::MODE2), 0x05);
    }
}

#[test]
fn a_second_byte_after_software_reset_is_not_acknowledged_and_calls_it_off() {
    let mut bench = Bench::one();
    bench.write(&[map::MODE2, 0x05]);
    assert_eq!(bench.try_write(0, &[6, 6]), Err(Error::DataNack));
    assert_eq!(bench.read(map::MODE2), 0x05);
}

#[test]
fn a_repeated_start_calls_a_software_reset_off() {
    let mut bench = Bench::one();
    bench.write(&[map::MODE2, 0x05]);
    let mut byte = [0];
    let result = bench.bus.write_read(0, &[6], &mut byte);
    assert_eq!(
        result,
        Err(Error::AddressNack),
        "0x00 read is not acknowledged"
    );
    assert_eq!(bench.read(map::MODE2), 0x05);
}

#[test]
fn the_general_call_read_is_not_acknowledged() {
    let mut bench = Bench::one();
    assert_eq!(bench.bus.read(0, &mut [0]), Err(Error::AddressNack));
}

#[test]
fn nobody_home_is_an_address_nack() {
    let mut bench = Bench::one();
    assert_eq!(bench.try_write(0x41, &[0, 0]), Err(Error::AddressNack));
    // START, address, STOP.
    assert_eq!(bench.now(), 11 * 2_500);
}
