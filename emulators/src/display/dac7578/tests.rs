//! The chip byte by byte: what each command of the data sheet does to registers and outputs.

use embedded_hal::i2c::I2c;
use palpate_core::codec::dac7578::{
    ALL, BROADCAST_ADDRESS, CLEAR_CODE, LDAC, POWER, RESET, UPDATE, WRITE, WRITE_UPDATE,
    WRITE_UPDATE_ALL, data, frame,
};

use super::*;
use crate::display::i2c::{BusClock, Error, I2cHandle, I2cSegment};

const CHIP: u8 = 0x48;

fn bus() -> I2cHandle {
    let chips = [CHIP, CHIP + 1].map(Dac7578::new);
    I2cHandle::new(I2cSegment::new(BusClock::Fast, Vec::new()).with_converters(chips.into()))
}

fn chip<T>(bus: &I2cHandle, work: impl FnOnce(&mut Dac7578, Nanos) -> T) -> T {
    bus.with(|segment| {
        let now = segment.now();
        work(&mut segment.converters_mut()[0], now)
    })
    .unwrap()
}

fn levels(bus: &I2cHandle) -> [u16; 8] {
    chip(bus, |chip, _| {
        std::array::from_fn(|n| chip.level(Channel(n as u8)))
    })
}

fn send(bus: &I2cHandle, command: u8, access: u8, word: u16) {
    let bytes = frame(command, access, word);
    bus.clone().write(CHIP, &bytes).unwrap();
}

fn read(bus: &I2cHandle, command: u8, channel: u8) -> u16 {
    let mut bytes = [0; 2];
    let asked = [command | channel];
    bus.clone().write_read(CHIP, &asked, &mut bytes).unwrap();
    u16::from_be_bytes(bytes)
}

#[test]
fn powers_up_at_zero_and_answers_to_its_address_and_to_broadcast_writes() {
    let bus = bus();
    assert_eq!(levels(&bus), [0; 8]);
    assert_eq!(read(&bus, UPDATE, 0), 0);
    assert_eq!(bus.clone().write(0x4A, &[0]), Err(Error::AddressNack));
    let to_all = frame(WRITE_UPDATE, 3, data(0x123));
    bus.clone().write(BROADCAST_ADDRESS, &to_all).unwrap();
    let both = bus.with(|s| [0, 1].map(|n: usize| s.converters_mut()[n].level(Channel(3))));
    assert_eq!(both.unwrap(), [0x123; 2]);
    let nothing = bus.clone().read(BROADCAST_ADDRESS, &mut [0]);
    assert_eq!(nothing, Err(Error::AddressNack));
}

#[test]
fn an_input_register_waits_for_an_update_and_both_read_back() {
    let bus = bus();
    send(&bus, WRITE, 2, data(0xABC));
    assert_eq!(levels(&bus)[2], 0);
    assert_eq!([read(&bus, WRITE, 2), read(&bus, UPDATE, 2)], [0xABC0, 0]);
    send(&bus, UPDATE, 2, 0);
    assert_eq!(levels(&bus)[2], 0xABC);
    assert_eq!(read(&bus, UPDATE, 2), 0xABC0);
    send(&bus, WRITE, 5, data(7));
    send(&bus, WRITE_UPDATE_ALL, 1, data(9));
    assert_eq!(levels(&bus), [0, 9, 0xABC, 0, 0, 7, 0, 0]);
    send(&bus, WRITE_UPDATE, ALL, data(0xFFF));
    assert_eq!(levels(&bus), [0xFFF; 8]);
}

#[test]
fn a_level_changes_with_the_acknowledge_of_the_last_byte() {
    let bus = bus();
    // START, address, command and two bytes of nine bits at 2.5 us each; STOP comes after.
    send(&bus, WRITE_UPDATE, 0, data(5));
    let mut seen = Vec::new();
    bus.with(|s| {
        s.take_levels(Nanos::from_micros(100), &mut |n, level| {
            seen.push((n, level))
        })
    })
    .unwrap();
    let level = Level {
        at: Nanos(37 * 2500),
        channel: Channel(0),
        code: 5,
    };
    assert_eq!(seen, [(0, level)]);
    // A command without its last byte is dropped.
    let torn = &frame(WRITE_UPDATE, 0, data(0xF00))[..2];
    bus.clone().write(CHIP, torn).unwrap();
    assert_eq!(levels(&bus)[0], 5);
    // Pairs of bytes may follow each other: the last one stays.
    let pairs = [WRITE_UPDATE, 0x10, 0x00, 0x20, 0x00];
    bus.clone().write(CHIP, &pairs).unwrap();
    assert_eq!(levels(&bus)[0], 0x200);
}

#[test]
fn ldac_loads_at_its_edge_and_lets_through_while_it_is_low_or_not_used() {
    let bus = bus();
    send(&bus, WRITE, 0, data(1));
    chip(&bus, |chip, now| chip.set_ldac_pin(now, true));
    assert_eq!(levels(&bus)[0], 1);
    send(&bus, WRITE, 0, data(2));
    assert_eq!(levels(&bus)[0], 2);
    chip(&bus, |chip, now| chip.set_ldac_pin(now, false));
    send(&bus, LDAC, 0, 0x0200);
    assert_eq!(read(&bus, LDAC, 0), 2);
    send(&bus, WRITE, 0, data(3));
    send(&bus, WRITE, 1, data(4));
    assert_eq!(levels(&bus)[..2], [2, 4]);
}

#[test]
fn clear_loads_what_its_register_says() {
    let bus = bus();
    for (code, expected) in [(0, 0), (1, 0x800), (2, 0xFFF), (3, 0x321)] {
        send(&bus, CLEAR_CODE, 0, code << 4);
        send(&bus, WRITE_UPDATE, 4, data(0x321));
        chip(&bus, |chip, now| chip.set_clr_pin(now, true));
        assert_eq!(levels(&bus)[4], expected, "clear code {code}");
        chip(&bus, |chip, now| chip.set_clr_pin(now, false));
    }
}

#[test]
fn power_down_pulls_an_output_down_and_keeps_its_register() {
    let bus = bus();
    send(&bus, WRITE_UPDATE, ALL, data(0x700));
    // Mode 01 for H, D and A: one bit each, A the lowest of the eleven above five that do not count.
    send(&bus, POWER, 0, 0x2000 | (1 << 7 | 1 << 3 | 1) << 5);
    assert_eq!(levels(&bus), [0, 0x700, 0x700, 0, 0x700, 0x700, 0x700, 0]);
    assert_eq!(read(&bus, POWER, 0), 0b1000_1001);
    assert_eq!(read(&bus, UPDATE, 3), 0x7000);
    send(&bus, POWER, 0, palpate_core::codec::dac7578::ALL_ON);
    assert_eq!(levels(&bus), [0x700; 8]);
}

#[test]
fn reset_and_a_lost_supply_leave_zeros() {
    let bus = bus();
    send(&bus, WRITE_UPDATE, ALL, data(0x700));
    send(&bus, LDAC, 0, 0xFF00);
    send(&bus, RESET, 0, 0);
    assert_eq!(levels(&bus), [0; 8]);
    assert_eq!([read(&bus, LDAC, 0), read(&bus, UPDATE, 0)], [0, 0]);
    send(&bus, WRITE_UPDATE, ALL, data(0x700));
    chip(&bus, |chip, now| chip.power_off(now));
    assert_eq!(levels(&bus), [0; 8]);
    assert_eq!(bus.clone().write(CHIP, &[0]), Err(Error::AddressNack));
    chip(&bus, |chip, now| chip.power_on(now));
    assert_eq!(read(&bus, UPDATE, 0), 0);
}

#[test]
fn what_the_data_sheet_does_not_list_changes_nothing() {
    let bus = bus();
    send(&bus, WRITE_UPDATE, ALL, data(0x700));
    for (command, access) in [(0x80, 0), (0xF0, 0), (WRITE, 8), (WRITE_UPDATE, 14)] {
        send(&bus, command, access, 0xFFFF);
    }
    assert_eq!(levels(&bus), [0x700; 8]);
    assert_eq!(chip(&bus, |chip, _| chip.invalid()), 4);
    assert_eq!([read(&bus, UPDATE, 9), read(&bus, 0xF0, 0)], [0, 0]);
}

#[test]
fn a_stuck_register_acknowledges_and_keeps_its_code() {
    let bus = bus();
    send(&bus, WRITE_UPDATE, 6, data(0x700));
    chip(&bus, |chip, _| chip.set_stuck(Channel(6), true));
    send(&bus, WRITE_UPDATE, 6, 0);
    send(&bus, RESET, 0, 0);
    assert_eq!(levels(&bus)[6], 0x700);
    assert_eq!([read(&bus, WRITE, 6), read(&bus, UPDATE, 6)], [0, 0x7000]);
    chip(&bus, |chip, now| chip.flip(now, Channel(5), 11));
    assert_eq!(levels(&bus)[5], 0x800);
}
