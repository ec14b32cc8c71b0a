//! The chip's behaviours, one test each: docs/drv2605.md lists them.

#![allow(clippy::float_cmp)] // ends of ranges and a rotor at rest are exact

use embedded_hal::i2c::I2c;

use super::*;
use crate::display::i2c::{BusClock, Error, I2cHandle, I2cSegment};
use crate::haptic::erm::{Erm, ErmParameters};
use crate::haptic::lra::{Lra, LraParameters};

const COIN: LraParameters = LraParameters::COIN_10MM;

fn lra() -> Motor {
    Motor::Lra(Lra::new(COIN))
}

fn erm() -> Motor {
    Motor::Erm(Erm::new(ErmParameters::COIN_10MM))
}

/// A bus with one chip, a millisecond after power-on.
struct Bench(I2cHandle);

impl Bench {
    fn new(motor: Motor) -> Self {
        let segment = I2cSegment::new(BusClock::Fast, Vec::new());
        let bench = Self(I2cHandle::new(
            segment.with_haptics(Vec::new(), vec![Drv2605::new(motor)]),
        ));
        bench.wait(1);
        bench
    }

    /// A chip that drives the coin in a closed loop at 2 Vrms, with 3 V of overdrive, in real-time playback.
    fn calibrated() -> Self {
        let bench = Self::new(lra());
        bench.set_up_lra();
        bench.put(reg::MODE, 7);
        bench.put(reg::GO, 1);
        bench.wait(1200);
        assert_eq!(bench.get(reg::GO), 0);
        assert_eq!(bench.get(reg::STATUS), 0xE0);
        bench.put(reg::MODE, 5);
        bench
    }

    fn set_up_lra(&self) {
        self.put(reg::MODE, 0);
        self.put(reg::RATED_VOLTAGE, 0x53);
        self.put(reg::OD_CLAMP, 0x8C);
        self.put(reg::FEEDBACK, 0xB6);
        // 0.5 + 24 / 10 ms, of the coin's 2.86.
        self.put(reg::CONTROL1, 0x98);
    }

    fn put(&self, register: u8, value: u8) {
        self.0
            .clone()
            .write(reg::ADDRESS, &[register, value])
            .unwrap();
    }

    fn get(&self, register: u8) -> u8 {
        let mut value = [0];
        self.0
            .clone()
            .write_read(reg::ADDRESS, &[register], &mut value)
            .unwrap();
        value[0]
    }

    fn wait(&self, ms: u64) {
        let pass = |segment: &mut I2cSegment| {
            let to = segment.now() + Nanos::from_micros(ms * 1000);
            segment.advance(to, &mut |_, _| ());
        };
        self.0.with(pass).unwrap();
    }

    fn chip<T>(&self, work: impl FnOnce(&mut Drv2605) -> T) -> T {
        self.0.with(|s| work(&mut s.haptics_mut()[0])).unwrap()
    }

    fn amplitude_m(&self) -> f64 {
        self.chip(|chip| chip.motor().amplitude_m())
    }

    /// Milliseconds until the amplitude is on the other side of a limit.
    fn until(&self, is_there: impl Fn(f64) -> bool) -> u64 {
        for ms in 0..2000 {
            if is_there(self.amplitude_m()) {
                return ms;
            }
            self.wait(1);
        }
        panic!("it never was: {}", self.amplitude_m());
    }
}

#[test]
fn reset_values() {
    let bench = Bench::new(lra());
    let mut all = [0; reg::COUNT];
    let mut bus = bench.0.clone();
    bus.write_read(reg::ADDRESS, &[0], &mut all).unwrap();
    assert_eq!(all, reg::RESET);
}

#[test]
fn nothing_is_acknowledged_250_us_after_power_on() {
    let bench = Bench::new(lra());
    bench.chip(|chip| chip.power_cycle(Nanos::from_micros(1000)));
    let mut bus = bench.0.clone();
    assert_eq!(bus.write(reg::ADDRESS, &[1, 0]), Err(Error::AddressNack));
    bench.wait(1);
    assert_eq!(bus.write(reg::ADDRESS, &[1, 0]), Ok(()));
}

#[test]
fn reserved_bits_cannot_be_written() {
    let bench = Bench::new(lra());
    for register in 0..reg::COUNT as u8 {
        if [reg::MODE, reg::GO].contains(&register) {
            continue;
        }
        bench.put(register, !reg::RESET[usize::from(register)]);
        let changed = bench.get(register) ^ reg::RESET[usize::from(register)];
        let mask = reg::WRITABLE[usize::from(register)];
        assert_eq!(changed & !mask, 0, "{register:#04x}");
    }
}

#[test]
fn registers_count_up_in_writes_and_reads() {
    let bench = Bench::new(lra());
    let mut bus = bench.0.clone();
    bus.write(reg::ADDRESS, &[reg::SEQUENCE, 1, 2, 3, 4])
        .unwrap();
    let mut read = [0; 4];
    bus.write_read(reg::ADDRESS, &[reg::SEQUENCE], &mut read)
        .unwrap();
    assert_eq!(read, [1, 2, 3, 4]);
    let mut beyond = [7; 2];
    bus.write_read(reg::ADDRESS, &[reg::COUNT as u8], &mut beyond)
        .unwrap();
    assert_eq!(beyond, [0, 0]);
}

#[test]
fn a_reset_bit_brings_every_reset_value_back_and_clears_itself() {
    let bench = Bench::calibrated();
    bench.put(reg::RTP_INPUT, 100);
    bench.put(reg::MODE, 0x80);
    bench.wait(1);
    let mut all = [0; reg::COUNT];
    bench.chip(|chip| all = core::array::from_fn(|i| chip.register(i as u8)));
    assert_eq!(all, reg::RESET);
    assert_eq!(bench.chip(|c| *c.output()), Drive::Open);
}

#[test]
fn standby_drives_nothing_and_keeps_every_register() {
    let bench = Bench::calibrated();
    bench.put(reg::RTP_INPUT, 127);
    bench.wait(100);
    bench.put(reg::MODE, 0x45);
    bench.wait(1);
    assert_eq!(bench.chip(|c| *c.output()), Drive::Open);
    assert_eq!(bench.get(reg::RTP_INPUT), 127);
    assert_eq!(bench.get(reg::RATED_VOLTAGE), 0x53);
}

#[test]
fn high_impedance_comes_at_once_and_lets_the_motor_coast() {
    let bench = Bench::calibrated();
    bench.put(reg::RTP_INPUT, 127);
    bench.wait(200);
    bench.put(reg::LIBRARY, 0x10);
    bench.wait(1);
    assert_eq!(bench.chip(|c| *c.output()), Drive::Open);
    let coasts = bench.until(|m| m < 0.1 * COIN.steady_m(2.83));
    bench.put(reg::LIBRARY, 0x00);
    bench.wait(300);
    bench.put(reg::RTP_INPUT, 0);
    let brakes = bench.until(|m| m < 0.1 * COIN.steady_m(2.83));
    assert!(coasts > 80 && brakes * 3 < coasts, "{coasts} {brakes}");
}

#[test]
fn the_rated_voltage_is_that_of_the_data_sheets_formula() {
    // 2 Vrms at 175 Hz with 300 us of sampling: the data sheet's formula by hand.
    let rms = |code: f64| 20.58e-3 * code / (1.0_f64 - (4.0 * 300e-6 + 300e-6) * 175.0).sqrt();
    let mut registers = reg::RESET;
    registers[usize::from(reg::FEEDBACK)] = 0xB6;
    registers[usize::from(reg::RATED_VOLTAGE)] = 0x53;
    let v = Settings(&registers).rated_v(175.0);
    assert!((v - rms(83.0) * 2.0_f64.sqrt()).abs() < 1e-12, "{v}");
    assert!((v / 2.0_f64.sqrt() - 2.0).abs() < 0.03, "{v}");
    registers[usize::from(reg::OD_CLAMP)] = 0x8C;
    let clamp = Settings(&registers).clamp_v();
    assert!((clamp - 140.0 * 21.22e-3).abs() < 1e-12, "{clamp}");
}

#[test]
fn a_calibration_measures_the_motor() {
    let bench = Bench::new(lra());
    bench.set_up_lra();
    bench.put(reg::MODE, 7);
    bench.put(reg::GO, 1);
    bench.wait(300);
    assert_eq!(
        bench.get(reg::GO),
        1,
        "500 to 700 ms by CONTROL4's reset value"
    );
    bench.wait(400);
    assert_eq!((bench.get(reg::GO), bench.get(reg::STATUS)), (0, 0xE0));
    // Back-EMF at the rated voltage, by the motor's own constants.
    let registers: [u8; reg::COUNT] =
        bench.chip(|chip| core::array::from_fn(|i| chip.register(i as u8)));
    let settings = Settings(&registers);
    let omega = TAU * COIN.resonance_hz;
    let emf = COIN.force_n_a * omega * COIN.steady_m(settings.rated_v(175.0));
    let found = settings.full_emf_v();
    assert!((found / emf - 1.0).abs() < 0.01, "{found} for {emf}");
    assert_eq!(registers[usize::from(reg::LRA_PERIOD)], 58);
}

#[test]
fn a_calibration_fails_without_a_motor_as_stated() {
    for (motor, control1) in [
        (
            {
                let mut motor = lra();
                motor.set_fault(Some(MotorFault::Open));
                motor
            },
            0x98,
        ),
        (
            {
                let mut motor = lra();
                motor.set_fault(Some(MotorFault::Stuck));
                motor
            },
            0x98,
        ),
        (erm(), 0x98),
        // A drive time of 0.5 ms: 1 kHz.
        (lra(), 0x80),
    ] {
        let bench = Bench::new(motor);
        bench.set_up_lra();
        bench.put(reg::CONTROL1, control1);
        bench.put(reg::MODE, 7);
        bench.put(reg::GO, 1);
        bench.wait(1200);
        assert_eq!((bench.get(reg::GO), bench.get(reg::STATUS)), (0, 0xE8));
        assert_eq!(
            bench.get(reg::STATUS),
            0xE0,
            "the result ends as it is read"
        );
        assert_eq!(bench.get(reg::A_CAL_BEMF), 0x6C);
    }
}

#[test]
fn a_diagnosis_finds_a_broken_motor() {
    for (fault, status) in [
        (None, 0xE0),
        (Some(MotorFault::Open), 0xE8),
        (Some(MotorFault::Stuck), 0xE8),
    ] {
        let bench = Bench::new(lra());
        bench.set_up_lra();
        bench.chip(|chip| chip.motor_mut().set_fault(fault));
        bench.put(reg::MODE, 6);
        bench.put(reg::GO, 1);
        bench.wait(150);
        assert_eq!((bench.get(reg::GO), bench.get(reg::STATUS)), (0, status));
    }
}

#[test]
fn a_closed_loop_comes_to_the_asked_share_of_the_rated_amplitude() {
    let bench = Bench::calibrated();
    let rated = {
        let registers: [u8; reg::COUNT] =
            bench.chip(|chip| core::array::from_fn(|i| chip.register(i as u8)));
        COIN.steady_m(Settings(&registers).rated_v(175.0))
    };
    for (value, share) in [(127, 1.0), (64, 0.5), (32, 0.25)] {
        bench.put(reg::RTP_INPUT, value);
        bench.wait(400);
        let found = bench.amplitude_m() / rated;
        assert!((found - share).abs() < 0.015, "{value}: {found}");
    }
}

#[test]
fn overdrive_is_sooner_there_than_an_open_loop_and_a_brake_sooner_at_rest() {
    let closed = Bench::calibrated();
    closed.put(reg::RTP_INPUT, 64);
    let half = COIN.steady_m(2.83) / 2.0;
    let rises = closed.until(|m| m > 0.45 * half * 2.0);
    closed.wait(300);
    closed.put(reg::RTP_INPUT, 0);
    let rests = closed.until(|m| m < 0.1 * half);
    let open = Bench::calibrated();
    open.put(reg::CONTROL3, 0xA1);
    open.put(reg::OPEN_PERIOD, 58);
    open.put(reg::RTP_INPUT, 64);
    let slow = open.until(|m| m > 0.45 * half * 2.0);
    open.wait(300);
    open.put(reg::RTP_INPUT, 0);
    let coasts = open.until(|m| m < 0.1 * half);
    assert!(rises * 2 < slow, "{rises} {slow}");
    assert!(rests * 2 < coasts, "{rests} {coasts}");
    // The coin's data sheets state some 50 ms to rise, and as much to stop.
    assert!(rises < 50 && rests < 50, "{rises} {rests}");
}

#[test]
fn no_output_exceeds_its_clamp_or_the_supply() {
    let bench = Bench::calibrated();
    let peak = |bench: &Bench| {
        let mut most = 0.0_f64;
        for _ in 0..200 {
            bench.wait(1);
            if let Drive::Wave { peak, .. } = bench.chip(|c| *c.output()) {
                most = most.max(peak.abs());
            }
        }
        most
    };
    bench.put(reg::RTP_INPUT, 127);
    let clamp = 140.0 * 21.22e-3;
    let most = peak(&bench);
    assert!(most > 0.99 * clamp && most <= clamp, "{most}");
    bench.put(reg::RTP_INPUT, 0);
    bench.wait(300);
    bench.chip(|chip| chip.set_supply(2.0));
    bench.put(reg::RTP_INPUT, 127);
    assert!(peak(&bench) <= 2.0);
    assert_eq!(bench.get(reg::VBAT), (2.0 / reg::VBAT_V) as u8);
}

#[test]
fn an_open_loop_keeps_its_own_period() {
    let bench = Bench::calibrated();
    bench.put(reg::CONTROL3, 0xA1);
    bench.put(reg::OPEN_PERIOD, 64);
    bench.put(reg::RTP_INPUT, 127);
    bench.wait(500);
    let Drive::Wave { omega, .. } = bench.chip(|c| *c.output()) else {
        panic!("no wave");
    };
    assert!((omega / TAU - 1.0 / (64.0 * 98.46e-6)).abs() < 1e-9);
    // 158.7 Hz is far from the resonance.
    assert!(bench.amplitude_m() < 0.4 * COIN.steady_m(2.97));
}

#[test]
fn signed_and_unsigned_playback_ask_for_the_same() {
    let mut registers = reg::RESET;
    let asked = |registers: &[u8; reg::COUNT], value| Settings(registers).asked(value);
    // Signed, both ways: the reset values.
    assert!((asked(&registers, 0x7F) - 1.0).abs() < 1e-12);
    assert!((asked(&registers, 0x81) + 1.0).abs() < 1e-12);
    assert_eq!(
        asked(&registers, 0x80),
        -1.0,
        "beyond the range it is the end"
    );
    registers[usize::from(reg::CONTROL3)] |= 0x08;
    assert_eq!(asked(&registers, 128), 0.0);
    assert_eq!((asked(&registers, 255), asked(&registers, 0)), (1.0, -1.0));
    registers[usize::from(reg::CONTROL2)] &= 0x7F;
    // One way: a closed loop of either motor.
    registers[usize::from(reg::FEEDBACK)] |= 0x80;
    assert_eq!((asked(&registers, 255), asked(&registers, 0)), (1.0, 0.0));
    registers[usize::from(reg::CONTROL3)] &= !0x08;
    assert_eq!((asked(&registers, 127), asked(&registers, 200)), (1.0, 0.0));
}

#[test]
fn a_sequence_plays_its_entries_and_clears_go() {
    let bench = Bench::calibrated();
    bench.put(reg::MODE, 0);
    bench.put(reg::LIBRARY, 6);
    let mut bus = bench.0.clone();
    // 250 ms, a wait of 100 ms, a click, the end.
    let entries = [reg::SEQUENCE, 14, 0x80 | 10, 1, 0];
    bus.write(reg::ADDRESS, &entries).unwrap();
    bench.put(reg::GO, 1);
    bench.wait(240);
    assert!(bench.amplitude_m() > 0.9 * COIN.steady_m(2.83));
    bench.wait(90);
    assert!(bench.amplitude_m() < 0.1 * COIN.steady_m(2.83));
    assert_eq!(bench.get(reg::GO), 1);
    bench.wait(40);
    assert_eq!(bench.get(reg::GO), 0);
}

#[test]
fn go_can_be_taken_back_and_the_empty_library_plays_nothing() {
    let bench = Bench::calibrated();
    bench.put(reg::MODE, 0);
    bench.put(reg::SEQUENCE, 118);
    bench.put(reg::GO, 1);
    bench.wait(100);
    assert!(bench.amplitude_m() > 0.5 * COIN.steady_m(2.83));
    bench.put(reg::GO, 0);
    bench.wait(100);
    assert!(bench.amplitude_m() < 0.05 * COIN.steady_m(2.83));
    bench.put(reg::LIBRARY, 0);
    bench.put(reg::GO, 1);
    bench.wait(1);
    assert_eq!(bench.get(reg::GO), 0);
}

#[test]
fn too_hot_it_drives_nothing_and_says_so_until_that_is_read() {
    let bench = Bench::calibrated();
    bench.put(reg::RTP_INPUT, 127);
    bench.wait(100);
    let now = bench.0.with(|s| s.now()).unwrap();
    bench.chip(|chip| chip.set_hot(now, true));
    bench.wait(1);
    assert!(matches!(
        bench.chip(|c| *c.output()),
        Drive::Open | Drive::Steady(_)
    ));
    assert_eq!(bench.get(reg::STATUS), 0xE2);
    assert_eq!(bench.get(reg::STATUS), 0xE2, "it still is");
    let now = bench.0.with(|s| s.now()).unwrap();
    bench.chip(|chip| chip.set_hot(now, false));
    assert_eq!(bench.get(reg::STATUS), 0xE2);
    assert_eq!(bench.get(reg::STATUS), 0xE0);
}

#[test]
fn a_shorted_motor_is_switched_off_and_flagged() {
    let bench = Bench::calibrated();
    bench.chip(|chip| chip.motor_mut().set_fault(Some(MotorFault::Short)));
    bench.put(reg::RTP_INPUT, 127);
    bench.wait(5);
    assert_eq!(bench.get(reg::STATUS), 0xE1);
    assert_eq!(bench.chip(|c| *c.output()), Drive::Steady(0.0));
}

#[test]
fn a_rotating_mass_spins_up_and_is_braked() {
    let bench = Bench::new(erm());
    bench.put(reg::MODE, 5);
    bench.put(reg::RATED_VOLTAGE, 0x8E);
    // Open loop, which the reset values have.
    bench.put(reg::RTP_INPUT, 127);
    bench.wait(500);
    let hz = bench.chip(|chip| chip.motor().hz());
    assert!((150.0..260.0).contains(&hz), "{hz}");
    // A closed loop brakes by itself.
    bench.put(reg::CONTROL3, 0x80);
    bench.put(reg::MODE, 7);
    bench.put(reg::GO, 1);
    bench.wait(1200);
    assert_eq!(bench.get(reg::STATUS), 0xE0);
    bench.put(reg::MODE, 5);
    bench.wait(500);
    bench.put(reg::RTP_INPUT, 0);
    let stops = {
        let mut ms = 0;
        while bench.chip(|chip| chip.motor().hz()) > 10.0 && ms < 1000 {
            bench.wait(1);
            ms += 1;
        }
        ms
    };
    assert!(stops < 60, "{stops}");
}

#[test]
fn looking_often_changes_nothing() {
    let run = |step: u64| {
        let bench = Bench::calibrated();
        bench.put(reg::RTP_INPUT, 90);
        for _ in 0..(120 / step) {
            bench.wait(step);
        }
        bench.put(reg::RTP_INPUT, 0);
        for _ in 0..(12 / step) {
            bench.wait(step);
        }
        bench.amplitude_m()
    };
    let (often, seldom) = (run(1), run(12));
    assert!((often - seldom).abs() < 1e-12, "{often} {seldom}");
}
