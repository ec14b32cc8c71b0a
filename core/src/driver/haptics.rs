//! The DRV2605L driver: vibration motors behind one TCA9548A, or a single one alone on its bus.
//!
//! Every DRV2605L has the same address, so a channel of the switch is selected before each transfer. A level of real-time
//! playback is one byte, so it is never torn.

use alloc::boxed::Box;
use alloc::vec::Vec;

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{Error as I2cError, I2c};

use super::{Actuators, Driver, DriverError, HapticFault, HapticPlanError, Traffic};
use crate::codec::drv2605::{self as regs, mode, status};
use crate::codec::tca9548a as mux;
use crate::guard::GuardedVibration;
use crate::units::{Board, Duration, Instant};

/// A motor as its driver has to know it, with its data sheet's voltages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HapticMotor {
    /// A linear resonant actuator.
    Lra {
        /// Rated voltage, V RMS.
        rated_v: f64,
        /// Largest voltage while it starts or brakes, V peak.
        overdrive_v: f64,
        /// Resonance, Hz.
        resonance_hz: f64,
    },
    /// An eccentric rotating mass.
    Erm {
        /// Rated voltage, V.
        rated_v: f64,
        /// Largest voltage while it starts or brakes, V.
        overdrive_v: f64,
    },
}

/// Result of a calibration, to be stored with the actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HapticCalibration {
    /// A_CAL_COMP: losses in the coil.
    pub compensation: u8,
    /// A_CAL_BEMF: back-EMF at the rated voltage.
    pub back_emf: u8,
    /// BEMF_GAIN, two bits.
    pub gain: u8,
}

/// One driver: its place, its motor, and a stored calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HapticChannel {
    /// 7-bit address of the switch before it, and its channel there; `None` for a driver alone on its bus.
    pub behind: Option<(u8, u8)>,
    /// The motor.
    pub motor: HapticMotor,
    /// The stored calibration, of [`Haptics::calibrate`].
    pub calibration: HapticCalibration,
}

/// Times a transfer is tried before a transient error counts.
const ATTEMPTS: u32 = 3;
/// CONTROL2 as after power-on: levels below zero brake.
const CONTROL2: u8 = regs::RESET[regs::CONTROL2 as usize];
/// Longest wait for a calibration, in steps of [`POLL_MS`].
const POLLS: u32 = 150;
/// Wait between two looks at a calibration, ms.
const POLL_MS: u32 = 10;
/// Registers up to the last one that is read back.
const ALL: usize = regs::CONTROL3 as usize + 1;
/// Time of one driver's start on a bus of 400 kbit/s, us: 14 writes and as many bytes read as there are registers, rounded up.
const START_US: u64 = 3000;
/// Registers of a channel's settings, in the order in which they are written.
const SETTINGS: [u8; 9] = [
    regs::RATED_VOLTAGE,
    regs::OD_CLAMP,
    regs::FEEDBACK,
    regs::CONTROL1,
    regs::CONTROL2,
    regs::CONTROL3,
    regs::A_CAL_COMP,
    regs::A_CAL_BEMF,
    TAG,
];
/// Last entry of the sequencer, which real-time playback leaves alone. It holds the actuator's number: chips with equal
/// settings behind a switch that is stuck cannot be told apart by anything else.
const TAG: u8 = regs::SEQUENCE + regs::ENTRIES - 1;

/// One driver with its codes.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub(super) behind: Option<(u8, u8)>,
    /// Codes of [`SETTINGS`].
    settings: [u8; SETTINGS.len()],
    /// Level that the chip was last told; `None` where it may have another.
    told: Option<u8>,
}

impl State {
    fn new(number: u8, place: &HapticChannel) -> Result<Self, HapticPlanError> {
        let code = |what, volts: f64, step: f64| {
            let code = regs::code(volts, step);
            code.ok_or(HapticPlanError::Voltage(number, what, volts, 255.0 * step))
        };
        let control1 = regs::RESET[usize::from(regs::CONTROL1)];
        let [rated, clamp, kind, control1] = match place.motor {
            HapticMotor::Lra {
                rated_v,
                overdrive_v,
                resonance_hz,
            } => {
                if !(125.0..=300.0).contains(&resonance_hz) {
                    return Err(HapticPlanError::Resonance(number, resonance_hz));
                }
                let step = regs::rated_step_lra(CONTROL2, resonance_hz);
                let time = regs::drive_time_lra(resonance_hz);
                [
                    code("rated", rated_v, step)?,
                    code("overdrive", overdrive_v, regs::CLAMP_STEP_LRA)?,
                    regs::LRA,
                    control1 & !regs::DRIVE_TIME | time,
                ]
            }
            HapticMotor::Erm {
                rated_v,
                overdrive_v,
            } => [
                code("rated", rated_v, regs::RATED_STEP_ERM)?,
                code("overdrive", overdrive_v, regs::CLAMP_STEP_ERM)?,
                0,
                control1,
            ],
        };
        let stored = place.calibration;
        let gain = stored.gain & regs::BEMF_GAIN;
        Ok(Self {
            behind: place.behind,
            settings: [
                rated,
                clamp,
                kind | regs::CLOSED_LOOP | gain,
                control1,
                CONTROL2,
                regs::SIGNED_LEVELS,
                stored.compensation,
                stored.back_emf,
                number,
            ],
            told: None,
        })
    }
}

/// DRV2605L drivers behind TCA9548A switches, or one alone. To the loop they are board 0, an actuator its channel.
#[derive(Debug)]
pub struct Haptics<I> {
    pub(super) i2c: I,
    drivers: Box<[State]>,
    /// The switch and its channel that are connected; `None` after anything that may have left them otherwise.
    pub(super) selected: Option<(u8, u8)>,
    retries: u64,
    traffic: Traffic,
}

impl<I: I2c> Haptics<I> {
    /// Drivers over their places, 16 at most; nothing is sent yet.
    ///
    /// # Errors
    /// [`HapticPlanError`] of the first driver whose place or voltages cannot be.
    pub fn new(i2c: I, channels: &[HapticChannel]) -> Result<Self, HapticPlanError> {
        for (number, place) in (0..).zip(channels) {
            let before = &channels[..usize::from(number)];
            let Some((address, channel)) = place.behind else {
                if channels.len() > 1 {
                    return Err(HapticPlanError::NoSwitch(number));
                }
                continue;
            };
            if channel >= mux::CHANNELS || !mux::ADDRESSES.contains(&address) {
                return Err(HapticPlanError::NoChannel(number, channel, address));
            }
            if before.iter().any(|other| other.behind == place.behind) {
                return Err(HapticPlanError::ChannelTwice(number, channel, address));
            }
        }
        if channels.len() > MOST {
            return Err(HapticPlanError::TooMany(channels.len()));
        }
        let drivers = (0..).zip(channels);
        let drivers: Result<Box<[_]>, _> = drivers.map(|(n, place)| State::new(n, place)).collect();
        Ok(Self {
            i2c,
            drivers: drivers?,
            selected: None,
            retries: 0,
            traffic: Traffic::default(),
        })
    }

    /// Calibrates the motor of a driver, which shakes it for about a second, and keeps the result. Only for a motor that
    /// nobody wears: the chip drives it at its rated voltage, past every guard.
    ///
    /// # Errors
    /// [`HapticFault`] of a driver that does not answer or does not calibrate.
    pub fn calibrate(
        &mut self,
        number: u8,
        delay: &mut impl DelayNs,
    ) -> Result<HapticCalibration, HapticFault> {
        self.configure(number)?;
        self.write(number, regs::MODE, mode::CALIBRATE)?;
        self.write(number, regs::GO, 1)?;
        let mut polls = 0;
        while self.read(number, regs::GO)? & 1 != 0 {
            if polls == POLLS {
                return Err(HapticFault::Endless(number));
            }
            polls += 1;
            delay.delay_ms(POLL_MS);
        }
        let found = self.read(number, regs::STATUS)?;
        complain(number, found)?;
        if found & status::DIAG_RESULT != 0 {
            return Err(HapticFault::Calibration(number));
        }
        let calibration = HapticCalibration {
            compensation: self.read(number, regs::A_CAL_COMP)?,
            back_emf: self.read(number, regs::A_CAL_BEMF)?,
            gain: self.read(number, regs::FEEDBACK)? & regs::BEMF_GAIN,
        };
        if let Some(state) = self.drivers.get_mut(usize::from(number)) {
            let [.., compensation, back_emf, _] = &mut state.settings;
            (*compensation, *back_emf) = (calibration.compensation, calibration.back_emf);
            state.settings[2] = state.settings[2] & !regs::BEMF_GAIN | calibration.gain;
        }
        self.write(number, regs::MODE, mode::STANDBY)?;
        Ok(calibration)
    }

    /// The resonance that an actuator's driver tracks, Hz; `None` before it was driven, and for a rotating motor.
    ///
    /// # Errors
    /// [`HapticFault`] of a driver or switch that does not answer.
    pub fn resonance_hz(&mut self, number: u8) -> Result<Option<f64>, HapticFault> {
        let steps = self.read(number, regs::LRA_PERIOD)?;
        Ok((steps != 0).then(|| 1.0 / (f64::from(steps) * regs::PERIOD_S)))
    }

    /// The bus.
    pub const fn bus(&self) -> &I {
        &self.i2c
    }

    /// The bus, for an owner that looks after it between two transfers.
    pub const fn bus_mut(&mut self) -> &mut I {
        &mut self.i2c
    }

    /// Puts a driver into standby with its settings and a level of 0.
    fn configure(&mut self, number: u8) -> Result<(), HapticFault> {
        let state = self.state(number)?;
        self.write(number, regs::MODE, mode::STANDBY)?;
        self.write(number, regs::RTP_INPUT, 0)?;
        let device = self.read(number, regs::STATUS)? >> status::DEVICE;
        if device != status::DRV2605L {
            return Err(HapticFault::Device(number, device));
        }
        let settings = SETTINGS.into_iter().zip(state.settings);
        settings
            .into_iter()
            .try_for_each(|(register, value)| self.write(number, register, value))
    }

    fn start_one(&mut self, number: u8) -> Result<(), HapticFault> {
        self.configure(number)?;
        self.write(number, regs::MODE, mode::REAL_TIME)
    }

    fn verify_one(&mut self, number: u8) -> Result<(), HapticFault> {
        let state = self.state(number)?;
        let found = self.read_all(number, regs::STATUS)?;
        complain(number, found[usize::from(regs::STATUS)])?;
        let settings = SETTINGS.into_iter().zip(state.settings);
        for (register, want) in settings.chain([(regs::MODE, mode::REAL_TIME)]) {
            let got = found[usize::from(register)];
            match register {
                _ if got == want => {}
                TAG => return Err(HapticFault::Elsewhere(number, got)),
                _ => return Err(HapticFault::Readback(number, register, want, got)),
            }
        }
        Ok(())
    }

    /// Sets the level of an actuator. Only a guarded update and switching off come here.
    pub(super) fn set(&mut self, number: u8, level: u8) -> Result<(), HapticFault> {
        if let Some(state) = self.drivers.get_mut(usize::from(number)) {
            state.told = None;
        }
        self.write(number, regs::RTP_INPUT, level)?;
        if let Some(state) = self.drivers.get_mut(usize::from(number)) {
            state.told = Some(level);
        }
        Ok(())
    }

    /// Numbers of all actuators.
    pub fn numbers(&self) -> core::ops::Range<u8> {
        0..self.drivers.len() as u8 // at most 16
    }

    pub(super) fn state(&self, number: u8) -> Result<State, HapticFault> {
        let state = self.drivers.get(usize::from(number)).copied();
        state.ok_or(HapticFault::NoSuchActuator(number))
    }

    /// Closes the switches that may be open, but for one: channels of two must not be connected together, since their drivers
    /// have one address.
    pub(super) fn close_others(&mut self, number: u8, but: Option<u8>) -> Result<(), HapticFault> {
        let before = self.selected.take();
        let others = self.drivers.iter().filter_map(|d| Some(d.behind?.0));
        let others = others.fold(0_u8, |all, other| all | 1 << (other & 7));
        let is_open = |other: u8| before.is_none_or(|(open, _)| open == other);
        for other in mux::ADDRESSES {
            if Some(other) != but && others & 1 << (other & 7) != 0 && is_open(other) {
                self.patiently(number, "switch", |i2c| i2c.write(other, &[mux::RESET]))?;
            }
        }
        Ok(())
    }

    /// Connects an actuator's channel alone, and reads that back.
    fn select(&mut self, number: u8) -> Result<(), HapticFault> {
        let Some((address, channel)) = self.state(number)?.behind else {
            return Ok(());
        };
        if self.selected == Some((address, channel)) {
            return Ok(());
        }
        self.close_others(number, Some(address))?;
        let want = mux::only(channel);
        self.patiently(number, "switch", |i2c| i2c.write(address, &[want]))?;
        let mut got = [0];
        self.patiently(number, "switch", |i2c| i2c.read(address, &mut got))?;
        if got[0] != want {
            return Err(HapticFault::Stuck(number, want, got[0]));
        }
        self.selected = Some((address, channel));
        Ok(())
    }

    pub(super) fn write(&mut self, number: u8, register: u8, value: u8) -> Result<(), HapticFault> {
        self.select(number)?;
        let bytes = [register, value];
        self.patiently(number, "driver", |i2c| i2c.write(regs::ADDRESS, &bytes))
    }

    pub(super) fn read(&mut self, number: u8, register: u8) -> Result<u8, HapticFault> {
        self.select(number)?;
        let mut got = [0];
        self.patiently(number, "driver", |i2c| {
            i2c.write_read(regs::ADDRESS, &[register], &mut got)
        })?;
        Ok(got[0])
    }

    /// Registers from one on to the last of the settings, in one transfer: on many adapters a transfer takes as long as its
    /// bytes. Those before it read as zero.
    pub(super) fn read_all(&mut self, number: u8, first: u8) -> Result<[u8; ALL], HapticFault> {
        self.select(number)?;
        let mut all = [0; ALL];
        self.patiently(number, "driver", |i2c| {
            let wanted = all.get_mut(usize::from(first)..).unwrap_or_default();
            i2c.write_read(regs::ADDRESS, &[first], wanted)
        })?;
        Ok(all)
    }

    /// Makes a transfer, and makes it again from its first byte after a transient error.
    fn patiently(
        &mut self,
        number: u8,
        chip: &'static str,
        mut transfer: impl FnMut(&mut I) -> Result<(), I::Error>,
    ) -> Result<(), HapticFault> {
        let mut attempt = 1;
        loop {
            let Err(error) = transfer(&mut self.i2c) else {
                return Ok(());
            };
            let error = HapticFault::Bus(number, error.kind(), chip);
            if attempt == ATTEMPTS || !error.is_transient() {
                return Err(error);
            }
            attempt += 1;
            self.retries += 1;
        }
    }
}

/// Most drivers of one finger: an update has so many channels.
const MOST: usize = 16;

/// Turns the flags of a status register into an error.
pub(super) const fn complain(number: u8, found: u8) -> Result<(), HapticFault> {
    if found & status::OVER_TEMPERATURE != 0 {
        return Err(HapticFault::OverTemperature(number));
    }
    if found & status::OVER_CURRENT != 0 {
        return Err(HapticFault::OverCurrent(number));
    }
    Ok(())
}

impl<I: I2c> Actuators<GuardedVibration> for Haptics<I> {
    type Error = DriverError;

    /// Ends come first, so that no channel of the switch holds one up.
    fn apply(&mut self, update: &GuardedVibration) -> Result<(), DriverError> {
        let levels = update.levels();
        let of = |ends: bool| {
            let each = (0..).zip(levels);
            each.filter_map(move |(n, level)| Some((n, level.filter(|l| (*l == 0) == ends)?)))
        };
        let before = self.traffic.channels;
        for (number, level) in of(true).chain(of(false)) {
            if self
                .state(number)
                .is_ok_and(|state| state.told == Some(level))
            {
                self.traffic.unchanged_channels += 1;
                continue;
            }
            self.set(number, level).map_err(DriverError::Haptic)?;
            self.traffic.channels += 1;
        }
        match self.traffic.channels == before {
            true => self.traffic.unchanged_updates += 1,
            false => self.traffic.writes += 1,
        }
        Ok(())
    }

    /// Brings every actuator to rest. Each is tried whatever the others answer; the first error is returned.
    fn all_off(&mut self) -> Result<(), DriverError> {
        self.selected = None;
        let mut result = Ok(());
        for number in self.numbers() {
            let off = self.set(number, 0);
            result = result.and(off.map_err(DriverError::Haptic));
        }
        result
    }
}

impl<I: I2c> Driver<GuardedVibration> for Haptics<I> {
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.all_off()?;
        // All are set before any is read back: behind a stuck switch the last one's settings have replaced the others'.
        let set = self.numbers().try_for_each(|n| self.start_one(n));
        let set = set.map_err(DriverError::Haptic);
        if let Err(error) = set.and_then(|()| self.verify()) {
            let _ = self.all_off();
            return Err(error);
        }
        let each = u64::from(self.numbers().end);
        Ok(now + Duration::from_micros(each * START_US))
    }

    fn verify(&mut self) -> Result<(), DriverError> {
        self.selected = None;
        self.numbers()
            .try_for_each(|number| self.verify_one(number))
            .map_err(DriverError::Haptic)
    }

    fn retries(&self) -> u64 {
        self.retries
    }

    fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn boards(&self) -> Vec<Board> {
        alloc::vec![Board(0)]
    }
}
