//! The multiplexer's behaviours, one test each: docs/drv2605.md lists them.

use embedded_hal::i2c::{I2c, Operation};

use super::*;
use crate::display::i2c::{BusClock, Error, I2cHandle, I2cSegment};
use crate::haptic::Motor;
use crate::haptic::drv2605::registers::{ADDRESS, RTP_INPUT};
use crate::haptic::lra::{Lra, LraParameters};

fn chip() -> Drv2605 {
    Drv2605::new(Motor::Lra(Lra::new(LraParameters::COIN_10MM)))
}

/// Eight chips of one address, each behind a channel; a millisecond after power-on.
fn bus() -> I2cHandle {
    let mux = (0..CHANNELS).fold(Tca9548a::new(0x70), |mux, channel| {
        mux.with(channel, chip())
    });
    let mut segment = I2cSegment::new(BusClock::Fast, Vec::new());
    segment = segment.with_haptics(vec![mux], Vec::new());
    segment.advance(Nanos::from_micros(1000), &mut |_, _| ());
    I2cHandle::new(segment)
}

fn amplitudes(bus: &I2cHandle) -> Vec<u8> {
    let read = |segment: &mut I2cSegment| {
        let chips = segment.muxes_mut()[0].chips();
        chips.map(|(_, chip)| chip.register(RTP_INPUT)).collect()
    };
    bus.with(read).unwrap()
}

#[test]
fn after_power_on_every_channel_is_closed() {
    let mut bus = bus();
    let mut control = [0xFF];
    bus.read(0x70, &mut control).unwrap();
    assert_eq!(control, [0]);
    assert_eq!(bus.write(ADDRESS, &[0]), Err(Error::AddressNack));
}

#[test]
fn a_channel_opens_at_the_stop() {
    let mut bus = bus();
    let within = bus.with(|segment| {
        segment.transfer(&mut [
            (0x70, Operation::Write(&[0x04])),
            (ADDRESS, Operation::Write(&[RTP_INPUT, 9])),
        ])
    });
    assert_eq!(within.unwrap(), Err(Error::AddressNack));
    bus.write(ADDRESS, &[RTP_INPUT, 9]).unwrap();
    assert_eq!(amplitudes(&bus), [0, 0, 9, 0, 0, 0, 0, 0]);
}

#[test]
fn the_last_byte_of_a_write_counts() {
    let mut bus = bus();
    bus.write(0x70, &[0xFF, 0x01, 0x80]).unwrap();
    let mut control = [0; 3];
    bus.read(0x70, &mut control).unwrap();
    assert_eq!(control, [0x80; 3]);
}

#[test]
fn open_channels_hear_the_same_and_reads_are_a_wired_and() {
    let mut bus = bus();
    for (channels, value) in [(0x01, 0b1100), (0x02, 0b1010)] {
        bus.write(0x70, &[channels]).unwrap();
        bus.write(ADDRESS, &[RTP_INPUT, value]).unwrap();
    }
    bus.write(0x70, &[0x03]).unwrap();
    let mut value = [0];
    bus.write_read(ADDRESS, &[RTP_INPUT], &mut value).unwrap();
    assert_eq!(value, [0b1000]);
    bus.write(ADDRESS, &[RTP_INPUT, 77]).unwrap();
    assert_eq!(amplitudes(&bus), [77, 77, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn a_reset_closes_every_channel() {
    let mut bus = bus();
    bus.write(0x70, &[0xFF]).unwrap();
    bus.with(|segment| segment.muxes_mut()[0].reset()).unwrap();
    assert_eq!(bus.write(ADDRESS, &[0]), Err(Error::AddressNack));
}

#[test]
fn stuck_switches_stay_where_they_are_whatever_reads_back() {
    let mut bus = bus();
    bus.write(0x70, &[0x01]).unwrap();
    bus.with(|segment| segment.muxes_mut()[0].set_stuck(true))
        .unwrap();
    bus.write(0x70, &[0x10]).unwrap();
    let mut control = [0];
    bus.read(0x70, &mut control).unwrap();
    assert_eq!(control, [0x10]);
    bus.write(ADDRESS, &[RTP_INPUT, 5]).unwrap();
    assert_eq!(amplitudes(&bus), [5, 0, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn chips_of_one_address_without_a_multiplexer_hear_the_same() {
    let segment = I2cSegment::new(BusClock::Fast, Vec::new());
    let mut segment = segment.with_haptics(Vec::new(), vec![chip(), chip()]);
    segment.advance(Nanos::from_micros(1000), &mut |_, _| ());
    let mut bus = I2cHandle::new(segment);
    bus.write(ADDRESS, &[RTP_INPUT, 33]).unwrap();
    let both = bus.with(|segment| {
        let chips = segment.haptics_mut().iter();
        chips.map(|c| c.register(RTP_INPUT)).collect::<Vec<_>>()
    });
    assert_eq!(both.unwrap(), [33, 33]);
}
