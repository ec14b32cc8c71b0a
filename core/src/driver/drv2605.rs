//! The DRV2605L driver: vibration motors behind one TCA9548A, or a single one alone on its bus.
//!
//! Every DRV2605L has the same address, so a channel of the switch is selected before each transfer. Levels are signed
//! real-time playback: 0 to 127 of the rated voltage, below zero brakes. A level is written whole, one byte, and so never
//! torn.

use alloc::boxed::Box;

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{Error as I2cError, I2c};

use super::haptic_error::HapticError;
use crate::codec::drv2605::{self as regs, control, feedback, mode, status};
use crate::codec::tca9548a as mux;

/// The actuator of one driver, with its data sheet's voltages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HapticMotor {
    /// A linear resonant actuator, driven in a closed loop.
    Lra {
        /// Rated voltage, V RMS.
        rated_v: f64,
        /// Largest voltage while it starts or brakes, V peak.
        overdrive_v: f64,
        /// Resonance, Hz.
        resonance_hz: f64,
    },
    /// An eccentric rotating mass, driven in a closed loop.
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
    /// A_CAL_COMP.
    pub compensation: u8,
    /// A_CAL_BEMF.
    pub back_emf: u8,
    /// BEMF_GAIN, two bits.
    pub gain: u8,
}

/// One driver: its place, its actuator, and a stored calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HapticChannel {
    /// Channel of the switch; `None` for a driver alone on its bus.
    pub channel: Option<u8>,
    /// The actuator.
    pub motor: HapticMotor,
    /// A stored calibration; `None` calibrates at every start, which shakes the actuator for about a second.
    pub calibration: Option<HapticCalibration>,
}

/// Times a transfer is tried before a transient error counts.
const ATTEMPTS: u32 = 3;
/// CONTROL2: levels below zero brake, slow measurement, as after power-up.
const CONTROL2: u8 = regs::DEFAULTS[regs::CONTROL2 as usize];
/// Longest wait for a calibration, in steps of [`POLL_MS`].
const POLLS: u32 = 150;
/// Wait between two looks at a calibration, ms.
const POLL_MS: u32 = 10;
/// Registers of a channel's settings in the order in which they are written.
const SETTINGS: [u8; 6] = [
    regs::RATED_VOLTAGE,
    regs::OD_CLAMP,
    regs::FEEDBACK,
    regs::CONTROL1,
    regs::CONTROL2,
    regs::CONTROL3,
];

/// One driver with its codes.
#[derive(Clone, Copy, Debug)]
struct State {
    channel: Option<u8>,
    /// Codes of [`SETTINGS`].
    settings: [u8; SETTINGS.len()],
    calibration: Option<HapticCalibration>,
}

impl State {
    fn new(number: u8, place: &HapticChannel) -> Result<Self, HapticError> {
        let code = |what, volts: f64, step: f64| {
            regs::code(volts, step).ok_or(HapticError::Voltage(number, what, volts, 255.0 * step))
        };
        let base = regs::DEFAULTS[usize::from(regs::CONTROL1)] & !control::DRIVE_TIME;
        let common = feedback::BRAKE_4X | feedback::GAIN_MEDIUM;
        let [rated, clamp, kind, drive] = match place.motor {
            HapticMotor::Lra {
                rated_v,
                overdrive_v,
                resonance_hz,
            } => {
                if !(125.0..=300.0).contains(&resonance_hz) {
                    return Err(HapticError::Resonance(number, resonance_hz));
                }
                let step = regs::rated_step_lra(CONTROL2, resonance_hz);
                [
                    code("rated", rated_v, step)?,
                    code("overdrive", overdrive_v, regs::CLAMP_STEP_LRA)?,
                    feedback::LRA,
                    regs::drive_time_lra(resonance_hz),
                ]
            }
            HapticMotor::Erm {
                rated_v,
                overdrive_v,
            } => {
                let drive = regs::DEFAULTS[usize::from(regs::CONTROL1)] & control::DRIVE_TIME;
                let step = regs::clamp_step_erm(drive, CONTROL2);
                [
                    code("rated", rated_v, regs::RATED_STEP_ERM)?,
                    code("overdrive", overdrive_v, step)?,
                    0,
                    drive,
                ]
            }
        };
        let gain = place.calibration.map_or(feedback::BEMF_DEFAULT, |c| c.gain);
        let settings = [
            rated,
            clamp,
            kind | common | gain & 3,
            base | drive,
            CONTROL2,
            control::NOISE_GATE_2,
        ];
        Ok(Self {
            channel: place.channel,
            settings,
            calibration: place.calibration,
        })
    }
}

/// Up to eight DRV2605L behind one TCA9548A, or one alone.
#[derive(Debug)]
pub struct Haptics<I> {
    i2c: I,
    /// 7-bit address of the switch; `None` without one.
    switch: Option<u8>,
    drivers: Box<[State]>,
    /// Control byte that the switch holds; `None` after anything that may have left it otherwise.
    selected: Option<u8>,
    retries: u64,
}

impl<I: I2c> Haptics<I> {
    /// Drivers over their places; nothing is sent yet. `switch` is the 7-bit address of the TCA9548A.
    ///
    /// # Errors
    /// [`HapticError`] of the first driver whose place or voltages cannot be.
    pub fn new(
        i2c: I,
        switch: Option<u8>,
        channels: &[HapticChannel],
    ) -> Result<Self, HapticError> {
        let mut taken = 0;
        for (number, place) in (0..).zip(channels) {
            match (switch, place.channel) {
                (Some(address), Some(channel)) => {
                    if channel >= mux::CHANNELS || !mux::ADDRESSES.contains(&address) {
                        return Err(HapticError::NoChannel(number, channel, address));
                    }
                    if taken & mux::only(channel) != 0 {
                        return Err(HapticError::ChannelTwice(number, channel));
                    }
                    taken |= mux::only(channel);
                }
                _ if channels.len() > 1 => return Err(HapticError::NoSwitch(number.max(1))),
                _ => {}
            }
        }
        let drivers: Result<Box<[_]>, _> = (0..)
            .zip(channels)
            .map(|(number, place)| State::new(number, place))
            .collect();
        Ok(Self {
            i2c,
            switch,
            drivers: drivers?,
            selected: None,
            retries: 0,
        })
    }

    /// Sets every driver up, calibrates those without a stored calibration one after another, and reads back. Afterwards
    /// all are in real-time playback at level 0.
    ///
    /// # Errors
    /// [`HapticError`] of the first actuator that does not answer, does not calibrate or does not read back. All are
    /// switched off then, as far as they answer.
    pub fn start(&mut self, delay: &mut impl DelayNs) -> Result<(), HapticError> {
        self.selected = None;
        let mut result = Ok(());
        for number in self.numbers() {
            result = result.and_then(|()| self.start_one(number, delay));
        }
        if result.is_err() {
            let _ = self.all_off();
        }
        result
    }

    fn start_one(&mut self, number: u8, delay: &mut impl DelayNs) -> Result<(), HapticError> {
        let state = self.state(number)?;
        self.write(number, regs::MODE, mode::STANDBY)?;
        self.write(number, regs::RTP_INPUT, 0)?;
        let device = self.read(number, regs::STATUS)? >> status::DEVICE.trailing_zeros();
        if device != status::DRV2605L {
            return Err(HapticError::Device(number, device));
        }
        for (register, value) in SETTINGS.into_iter().zip(state.settings) {
            self.write(number, register, value)?;
        }
        if let Some(stored) = state.calibration {
            self.write(number, regs::A_CAL_COMP, stored.compensation)?;
            self.write(number, regs::A_CAL_BEMF, stored.back_emf)?;
        } else {
            self.calibrate(number, delay)?;
        }
        self.write(number, regs::MODE, mode::REAL_TIME)?;
        self.verify_one(number)
    }

    /// Calibrates one actuator and keeps the result.
    fn calibrate(&mut self, number: u8, delay: &mut impl DelayNs) -> Result<(), HapticError> {
        self.write(number, regs::MODE, mode::CALIBRATE)?;
        self.write(number, regs::GO, 1)?;
        let mut polls = 0;
        while self.read(number, regs::GO)? & 1 != 0 {
            if polls == POLLS {
                return Err(HapticError::Endless(number));
            }
            polls += 1;
            delay.delay_ms(POLL_MS);
        }
        let found = self.read(number, regs::STATUS)?;
        complain(number, found)?;
        if found & status::DIAG_RESULT != 0 {
            return Err(HapticError::Calibration(number));
        }
        let calibration = HapticCalibration {
            compensation: self.read(number, regs::A_CAL_COMP)?,
            back_emf: self.read(number, regs::A_CAL_BEMF)?,
            gain: self.read(number, regs::FEEDBACK)? & 3,
        };
        if let Some(state) = self.drivers.get_mut(usize::from(number)) {
            state.calibration = Some(calibration);
            // The chip chose the gain.
            state.settings[2] = state.settings[2] & !3 | calibration.gain;
        }
        Ok(())
    }

    /// Sets the level of an actuator: 127 is its rated voltage, 0 brakes to rest, and a level below zero drives an LRA in
    /// opposite phase and an ERM backwards.
    ///
    /// # Errors
    /// [`HapticError`] when the driver or its switch does not answer.
    pub fn set(&mut self, actuator: u8, level: i8) -> Result<(), HapticError> {
        self.write(actuator, regs::RTP_INPUT, level.max(-127).cast_unsigned())
    }

    /// Brings every actuator to rest: all channels of the switch together, then each by its own. Every one is tried
    /// whatever the others answer.
    ///
    /// # Errors
    /// The first error of an own channel.
    pub fn all_off(&mut self) -> Result<(), HapticError> {
        let off = [regs::RTP_INPUT, 0];
        if let Some(address) = self.switch {
            let all = self.drivers.iter().filter_map(|d| d.channel);
            let all = all.fold(0, |all, channel| all | mux::only(channel));
            self.selected = None;
            // Chips that answer together hide one that does not: the writes below decide.
            let _ = self
                .i2c
                .write(address, &[all])
                .and_then(|()| self.i2c.write(regs::ADDRESS, &off));
        }
        let mut result = Ok(());
        for number in self.numbers() {
            let written = self.write(number, regs::RTP_INPUT, 0);
            result = result.and(written);
        }
        result
    }

    /// Confirms that every driver still is as [`Self::start`] left it, and that none was too hot or overloaded.
    ///
    /// # Errors
    /// [`HapticError`] of the first actuator that does not answer, does not read back or reports a fault.
    pub fn verify(&mut self) -> Result<(), HapticError> {
        self.selected = None;
        self.numbers()
            .try_for_each(|number| self.verify_one(number))
    }

    fn verify_one(&mut self, number: u8) -> Result<(), HapticError> {
        let state = self.state(number)?;
        let found = self.read(number, regs::STATUS)?;
        complain(number, found)?;
        let settings = SETTINGS.into_iter().zip(state.settings);
        for (register, want) in settings.chain([(regs::MODE, mode::REAL_TIME)]) {
            let got = self.read(number, register)?;
            if got != want {
                return Err(HapticError::Readback(number, register, want, got));
            }
        }
        Ok(())
    }

    /// Calibration of an actuator: the stored one, or that of the last [`Self::start`].
    pub fn calibration(&self, actuator: u8) -> Option<HapticCalibration> {
        self.drivers.get(usize::from(actuator))?.calibration
    }

    /// The resonance that an actuator's driver tracks, Hz; `None` before it was driven, and for an ERM.
    ///
    /// # Errors
    /// [`HapticError`] when the driver or its switch does not answer.
    pub fn resonance_hz(&mut self, actuator: u8) -> Result<Option<f64>, HapticError> {
        Ok(regs::frequency_hz(self.read(actuator, regs::LRA_PERIOD)?))
    }

    /// Transfers made again after a transient error.
    pub const fn retries(&self) -> u64 {
        self.retries
    }

    /// The bus, for an owner that looks after it between two transfers.
    pub const fn bus_mut(&mut self) -> &mut I {
        &mut self.i2c
    }

    fn numbers(&self) -> core::ops::Range<u8> {
        0..self.drivers.len() as u8
    }

    fn state(&self, number: u8) -> Result<State, HapticError> {
        let state = self.drivers.get(usize::from(number)).copied();
        state.ok_or(HapticError::NoSuchActuator(number))
    }

    /// Connects an actuator's channel alone, and reads that back.
    fn select(&mut self, number: u8) -> Result<(), HapticError> {
        let (Some(address), Some(channel)) = (self.switch, self.state(number)?.channel) else {
            return Ok(());
        };
        let want = mux::only(channel);
        if self.selected == Some(want) {
            return Ok(());
        }
        self.selected = None;
        self.patiently(number, "switch", |i2c| i2c.write(address, &[want]))?;
        let mut got = [0];
        self.patiently(number, "switch", |i2c| i2c.read(address, &mut got))?;
        if got[0] != want {
            return Err(HapticError::Stuck(number, want, got[0]));
        }
        self.selected = Some(want);
        Ok(())
    }

    fn write(&mut self, number: u8, register: u8, value: u8) -> Result<(), HapticError> {
        self.select(number)?;
        let bytes = [register, value];
        self.patiently(number, "driver", |i2c| i2c.write(regs::ADDRESS, &bytes))
    }

    fn read(&mut self, number: u8, register: u8) -> Result<u8, HapticError> {
        self.select(number)?;
        let mut got = [0];
        self.patiently(number, "driver", |i2c| {
            i2c.write_read(regs::ADDRESS, &[register], &mut got)
        })?;
        Ok(got[0])
    }

    /// Makes a transfer, and makes it again from its first byte after a transient error.
    fn patiently(
        &mut self,
        number: u8,
        chip: &'static str,
        mut transfer: impl FnMut(&mut I) -> Result<(), I::Error>,
    ) -> Result<(), HapticError> {
        let mut attempt = 1;
        loop {
            let Err(error) = transfer(&mut self.i2c) else {
                return Ok(());
            };
            let error = HapticError::Bus(number, error.kind(), chip);
            if attempt == ATTEMPTS || !error.is_transient() {
                return Err(error);
            }
            attempt += 1;
            self.retries += 1;
        }
    }
}

/// Turns the flags of a status register into an error.
const fn complain(number: u8, found: u8) -> Result<(), HapticError> {
    if found & status::OVER_TEMP != 0 {
        return Err(HapticError::OverTemperature(number));
    }
    if found & status::OC_DETECT != 0 {
        return Err(HapticError::OverCurrent(number));
    }
    Ok(())
}
