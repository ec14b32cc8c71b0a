//! Drivers of others over the emulated chips: `xca9548a` and `drv2605`, and what Linux and Adafruit's library send.

#![allow(clippy::float_cmp)] // ends of ranges and a rotor at rest are exact

use drv2605::{Drv2605 as Driver, Effect, LibrarySelection};
use embedded_hal::i2c::I2c;
use xca9548a::{SlaveAddr, Xca9548a};

use super::drv2605::Drv2605;
use super::drv2605::registers as reg;
use super::erm::{Erm, ErmParameters};
use super::lra::{Lra, LraParameters};
use super::tca9548a::{CHANNELS, Tca9548a};
use super::{Drive, Motor};
use crate::display::i2c::{BusClock, I2cHandle, I2cSegment};
use crate::time::Nanos;

/// The traits of embedded-hal 0.2 over a bus of 1.0.
struct Old<B>(B);

impl<B: I2c> embedded_hal_02::blocking::i2c::Write for Old<B> {
    type Error = B::Error;

    fn write(&mut self, address: u8, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.write(address, bytes)
    }
}

impl<B: I2c> embedded_hal_02::blocking::i2c::WriteRead for Old<B> {
    type Error = B::Error;

    fn write_read(
        &mut self,
        address: u8,
        bytes: &[u8],
        read: &mut [u8],
    ) -> Result<(), Self::Error> {
        self.0.write_read(address, bytes, read)
    }
}

fn lra() -> Motor {
    Motor::Lra(Lra::new(LraParameters::COIN_10MM))
}

fn wait(bus: &I2cHandle, ms: u64) {
    let pass = |segment: &mut I2cSegment| {
        let to = segment.now() + Nanos::from_micros(ms * 1000);
        segment.advance(to, &mut |_, _| ());
    };
    bus.with(pass).unwrap();
}

fn alone(motor: Motor) -> I2cHandle {
    let segment = I2cSegment::new(BusClock::Fast, Vec::new());
    let bus = I2cHandle::new(segment.with_haptics(Vec::new(), vec![Drv2605::new(motor)]));
    wait(&bus, 1);
    bus
}

fn chip<T>(bus: &I2cHandle, work: impl FnOnce(&Drv2605) -> T) -> T {
    bus.with(|segment| work(&segment.haptics_mut()[0])).unwrap()
}

#[test]
fn eight_motors_at_one_address_play_each_its_own() {
    let mux = (0..CHANNELS).fold(Tca9548a::new(0x70), |mux, channel| {
        mux.with(channel, Drv2605::new(lra()))
    });
    let segment = I2cSegment::new(BusClock::Fast, Vec::new());
    let bus = I2cHandle::new(segment.with_haptics(vec![mux], Vec::new()));
    wait(&bus, 1);
    let switch = Xca9548a::new(bus.clone(), SlaveAddr::Default);
    let parts = switch.split();
    let mut channels = [
        parts.i2c0, parts.i2c1, parts.i2c2, parts.i2c3, parts.i2c4, parts.i2c5, parts.i2c6,
        parts.i2c7,
    ];
    for (number, channel) in channels.iter_mut().enumerate() {
        for (register, value) in [
            (reg::MODE, 0x05),
            (reg::RATED_VOLTAGE, 0x53),
            (reg::FEEDBACK, 0xB6),
            (reg::CONTROL3, 0xA1),
            (reg::OPEN_PERIOD, 58),
            (reg::RTP_INPUT, 15 * number as u8),
        ] {
            channel.write(reg::ADDRESS, &[register, value]).unwrap();
        }
    }
    wait(&bus, 500);
    let amplitudes = bus.with(|segment| {
        let chips = segment.muxes_mut()[0].chips();
        chips
            .map(|(_, chip)| chip.motor().amplitude_m())
            .collect::<Vec<_>>()
    });
    let amplitudes = amplitudes.unwrap();
    assert!(amplitudes[0] < 1e-9);
    for (number, amplitude) in amplitudes.iter().enumerate().skip(1) {
        let share = amplitude / amplitudes[7];
        assert!(
            (share - number as f64 / 7.0).abs() < 1e-3,
            "{number}: {share}"
        );
    }
}

#[test]
fn the_crate_drv2605_plays_an_effect_on_a_rotating_mass() {
    let bus = alone(Motor::Erm(Erm::new(ErmParameters::COIN_10MM)));
    let mut driver = Driver::new(Old(bus.clone()));
    driver.init_open_loop_erm().unwrap();
    driver.set_library(LibrarySelection::B).unwrap();
    driver.set_single_effect(Effect::StrongBuzz100).unwrap();
    assert_eq!(driver.get_status().unwrap().0, 0xE0);
    driver.set_go(true).unwrap();
    wait(&bus, 200);
    assert!(chip(&bus, |chip| chip.motor().hz()) > 100.0);
    wait(&bus, 2000);
    assert_eq!(chip(&bus, |chip| chip.motor().hz()), 0.0);
    assert_eq!(chip(&bus, |chip| chip.register(reg::GO)), 0);
    driver.set_standby(true).unwrap();
    assert_eq!(chip(&bus, |chip| *chip.output()), Drive::Open);
    driver.reset().unwrap();
    wait(&bus, 1);
    assert_eq!(chip(&bus, |chip| chip.register(reg::LIBRARY)), 0x01);
}

/// Registers and values that Linux's drivers/input/misc/drv260x.c writes for an actuator of 2 V with 3 V of overdrive.
const LINUX_LRA: [(u8, u8); 6] = [
    (reg::RATED_VOLTAGE, 91),
    (reg::OD_CLAMP, 136),
    (reg::MODE, 0x07),
    (reg::CONTROL3, 0x40),
    (reg::FEEDBACK, 0xB8),
    (reg::GO, 0x01),
];

#[test]
fn what_linux_sends_calibrates_and_plays() {
    let bus = alone(lra());
    let mut i2c = bus.clone();
    for (register, value) in LINUX_LRA {
        i2c.write(reg::ADDRESS, &[register, value]).unwrap();
    }
    // It polls GO until the calibration is over.
    let mut polls = 0;
    loop {
        let mut go = [0];
        i2c.write_read(reg::ADDRESS, &[reg::GO], &mut go).unwrap();
        if go[0] & 1 == 0 {
            break;
        }
        wait(&bus, 15);
        polls += 1;
        assert!(polls < 100, "GO never ended");
    }
    assert_eq!(chip(&bus, |chip| chip.register(reg::STATUS)), 0xE0);
    // Its worker: real-time playback of signed values.
    i2c.write(reg::ADDRESS, &[reg::MODE, 0x05]).unwrap();
    i2c.write(reg::ADDRESS, &[reg::RTP_INPUT, 0x7F]).unwrap();
    wait(&bus, 300);
    let amplitude = chip(&bus, |chip| chip.motor().amplitude_m());
    // Linux reckons 5.6 V for a code of 255. By the data sheet its 2 V are 2.18 Vrms, whose peak its clamp of 2.89 V cuts.
    let rated = LraParameters::COIN_10MM.steady_m(136.0 * 21.22e-3);
    assert!((amplitude / rated - 1.0).abs() < 0.02, "{amplitude}");
    i2c.write(reg::ADDRESS, &[reg::MODE, 0x40]).unwrap();
    wait(&bus, 500);
    assert!(chip(&bus, |chip| chip.motor().amplitude_m()) < 1e-3 * rated);
}

/// Registers and values that Adafruit's library writes in `begin`, `selectLibrary(1)` and `setWaveform`.
const ADAFRUIT: [(u8, u8); 12] = [
    (reg::MODE, 0x00),
    (reg::RTP_INPUT, 0x00),
    (reg::SEQUENCE, 1),
    (reg::SEQUENCE + 1, 0),
    (0x0D, 0),
    (0x0E, 0),
    (0x0F, 0),
    (0x10, 0),
    (0x13, 0x64),
    (reg::LIBRARY, 1),
    (reg::SEQUENCE, 47),
    (reg::SEQUENCE + 1, 0),
];

#[test]
fn what_adafruits_library_sends_plays_effects() {
    let bus = alone(Motor::Erm(Erm::new(ErmParameters::COIN_10MM)));
    let mut i2c = bus.clone();
    for (register, value) in ADAFRUIT {
        i2c.write(reg::ADDRESS, &[register, value]).unwrap();
    }
    // Its `begin` reads both before it writes them: a rotating mass in an open loop.
    for (register, clear, set) in [(reg::FEEDBACK, 0x80, 0x00), (reg::CONTROL3, 0x00, 0x20)] {
        let mut value = [0];
        i2c.write_read(reg::ADDRESS, &[register], &mut value)
            .unwrap();
        let value = value[0] & !clear | set;
        i2c.write(reg::ADDRESS, &[register, value]).unwrap();
    }
    i2c.write(reg::ADDRESS, &[reg::GO, 1]).unwrap();
    wait(&bus, 150);
    assert!(chip(&bus, |chip| chip.motor().hz()) > 100.0);
    i2c.write(reg::ADDRESS, &[reg::GO, 0]).unwrap();
    wait(&bus, 1500);
    assert_eq!(chip(&bus, |chip| chip.motor().hz()), 0.0);
}
