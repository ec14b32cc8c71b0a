//! A DRV2605L at register level, in virtual time: TI data sheet SLOS854.
//!
//! The bus face ([`Drv2605::start`], [`Drv2605::write`], [`Drv2605::read`], [`Drv2605::stop`]) is what a driver sees. The
//! physical face has the motor, the supply and the chip's temperature. The chip looks at the back-EMF each half wave of an
//! actuator, or each drive time of a rotating motor, and sets its output anew: overdrive until the motor is as fast as
//! asked, then the asked drive, and a brake at the end. The IN/TRIG pin lies at ground: external triggers, PWM, analog and
//! audio input give nothing.

mod effects;
pub mod registers;

use core::f64::consts::{FRAC_PI_2, TAU};

use super::{Drive, Motor, MotorFault};
use crate::time::Nanos;
use registers as reg;
use registers::Settings;

/// Time after power-on from which the chip acknowledges.
const AWAKE_AFTER: Nanos = Nanos::from_micros(250);
/// Length of a diagnosis: assumed.
const DIAGNOSIS: Nanos = Nanos::from_micros(100_000);
/// Part of full back-EMF below which a motor counts as at rest.
const AT_REST: f64 = 0.02;
/// Largest part by which the drive time may miss an actuator's half period in a calibration: assumed.
const GUESS: f64 = 0.3;

const DIAG_RESULT: u8 = 0x08;
const OVER_TEMPERATURE: u8 = 0x02;
const OVER_CURRENT: u8 = 0x01;

/// Part of a transaction that comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    /// A register's number.
    Register,
    /// Bytes of registers from the pointer on.
    Data,
}

/// Run of the GO bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Play {
    /// A part of a sequence's entry.
    Sequence {
        entry: u8,
        part: usize,
    },
    Diagnosis,
    Calibration,
}

const fn wave(peak: f64, hz: f64, phase: f64) -> Drive {
    Drive::Wave {
        peak,
        omega: TAU * hz,
        phase,
    }
}

/// One emulated chip with its motor.
#[derive(Clone, Debug)]
pub struct Drv2605 {
    registers: [u8; reg::COUNT],
    pointer: u8,
    next: Next,
    motor: Motor,
    supply_v: f64,
    hot: bool,
    powered: Nanos,
    now: Nanos,
    output: Drive,
    /// Time of the next look at the motor; far away while nothing is driven.
    look: Nanos,
    /// Run of the GO bit, and the end of its present part.
    play: Option<(Play, Nanos)>,
}

impl Drv2605 {
    /// A chip that is powered at the start of the run, by 3.3 V, with a motor.
    pub const fn new(motor: Motor) -> Self {
        Self {
            registers: reg::RESET,
            pointer: 0,
            next: Next::Register,
            motor,
            supply_v: 3.3,
            hot: false,
            powered: Nanos::ZERO,
            now: Nanos::ZERO,
            output: Drive::Steady(0.0),
            look: Nanos::MAX,
            play: None,
        }
    }

    /// The motor.
    pub const fn motor(&self) -> &Motor {
        &self.motor
    }

    /// The motor, to break or repair it.
    pub const fn motor_mut(&mut self) -> &mut Motor {
        &mut self.motor
    }

    /// Output as it is now.
    pub const fn output(&self) -> &Drive {
        &self.output
    }

    /// Value of a register, without the effects of a read; 0 for one that is not there.
    pub fn register(&self, register: u8) -> u8 {
        let value = self.registers.get(usize::from(register));
        value.copied().unwrap_or(0)
    }

    /// Sets the supply voltage, V; no output exceeds it.
    pub const fn set_supply(&mut self, volts: f64) {
        self.supply_v = volts;
    }

    /// Makes the chip too hot, or lets it cool. A hot chip drives nothing, and keeps its flag until that is read.
    pub fn set_hot(&mut self, at: Nanos, hot: bool) {
        self.advance(at);
        self.hot = hot;
        self.look = self.now;
    }

    /// Takes the power away and gives it back: registers are as at power-on.
    pub fn power_cycle(&mut self, at: Nanos) {
        self.advance(at);
        self.reset();
        self.powered = self.now;
    }

    /// Lets time pass until `to`; a time in the past changes nothing.
    pub fn advance(&mut self, to: Nanos) {
        while self.now < to {
            if self.look <= self.now {
                self.decide();
            }
            let end = self.play.map_or(to, |(_, until)| to.min(until));
            let end = end.min(self.look).max(self.now);
            let seconds = end.since(self.now).as_secs_f64();
            self.motor.pass(&self.output, seconds);
            if let Drive::Wave { omega, phase, .. } = &mut self.output {
                *phase = (*phase + *omega * seconds) % TAU;
            }
            self.now = end;
            if let Some((play, until)) = self.play
                && until <= self.now
            {
                self.go_on(play);
            }
        }
    }

    /// Tells whether the chip answers to a 7-bit address.
    pub const fn answers(&self, address: u8, _read: bool) -> bool {
        address == reg::ADDRESS
    }

    /// START with an address byte; returns the ACK.
    pub fn start(&mut self, at: Nanos, address: u8, read: bool) -> bool {
        self.advance(at);
        self.next = if read { Next::Data } else { Next::Register };
        address == reg::ADDRESS && at >= self.powered + AWAKE_AFTER
    }

    /// A byte from the controller; returns the ACK.
    pub fn write(&mut self, at: Nanos, byte: u8) -> bool {
        self.advance(at);
        match self.next {
            Next::Register => {
                self.pointer = byte;
                self.next = Next::Data;
            }
            Next::Data => {
                let register = self.pointer;
                self.pointer = self.pointer.wrapping_add(1);
                self.set(register, byte);
            }
        }
        true
    }

    /// A byte to the controller. Flags of the status register end as they are read.
    pub fn read(&mut self, at: Nanos) -> u8 {
        self.advance(at);
        let register = self.pointer;
        self.pointer = self.pointer.wrapping_add(1);
        let value = match register {
            reg::VBAT if self.is_active() => (self.supply_v / reg::VBAT_V).min(255.0) as u8,
            _ => self.register(register),
        };
        if register == reg::STATUS {
            let hot = if self.hot { OVER_TEMPERATURE } else { 0 };
            self.registers[usize::from(reg::STATUS)] = reg::RESET[usize::from(reg::STATUS)] | hot;
        }
        value
    }

    /// STOP.
    pub fn stop(&mut self, at: Nanos) {
        self.advance(at);
        self.next = Next::Register;
    }

    const fn settings(&self) -> Settings<'_> {
        Settings(&self.registers)
    }

    fn mode(&self) -> u8 {
        self.register(reg::MODE) & 0x07
    }

    fn is_active(&self) -> bool {
        self.register(reg::MODE) & 0x40 == 0
    }

    fn reset(&mut self) {
        self.registers = reg::RESET;
        self.play = None;
        self.look = self.now;
    }

    /// A write of a register takes effect at its ACK.
    fn set(&mut self, register: u8, byte: u8) {
        let index = usize::from(register);
        let Some(slot) = self.registers.get_mut(index) else {
            return;
        };
        let mask = reg::WRITABLE[index];
        *slot = *slot & !mask | byte & mask;
        match register {
            reg::MODE if byte & 0x80 != 0 => return self.reset(),
            reg::MODE => self.end_play(),
            reg::GO if byte & 1 == 0 => self.end_play(),
            reg::GO => self.begin_play(),
            _ => {}
        }
        // A wave goes on to its next look; high impedance and standby come at once.
        let is_wave = matches!(self.output, Drive::Wave { .. });
        if !is_wave || !self.is_active() || register == reg::LIBRARY {
            self.look = self.now;
        }
    }

    fn end_play(&mut self) {
        self.play = None;
        self.registers[usize::from(reg::GO)] = 0;
    }

    fn begin_play(&mut self) {
        if self.play.is_some() {
            return;
        }
        match (self.is_active(), self.mode()) {
            (true, 0) => self.play_from(0, 0),
            (true, 6) => self.play = Some((Play::Diagnosis, self.now + DIAGNOSIS)),
            (true, 7) => {
                let length = self.settings().calibration_s() * 1e9;
                self.play = Some((Play::Calibration, self.now + Nanos(length as u64)));
            }
            _ => self.end_play(),
        }
    }

    /// Plays a sequence from an entry's part on.
    fn play_from(&mut self, mut entry: u8, mut part: usize) {
        while entry < reg::ENTRIES {
            let value = self.register(reg::SEQUENCE + entry);
            if value == 0 {
                break;
            }
            let ms = match value & 0x80 {
                0 => self.parts(value).get(part).map(|(_, ms)| u64::from(*ms)),
                _ => (part == 0).then_some(u64::from(value & 0x7F) * 10),
            };
            if let Some(ms) = ms {
                let until = self.now + Nanos::from_micros(ms * 1000);
                self.play = Some((Play::Sequence { entry, part }, until));
                return;
            }
            (entry, part) = (entry + 1, 0);
        }
        self.end_play();
    }

    /// Parts of an effect; none by the empty library.
    fn parts(&self, effect: u8) -> &'static [effects::Part] {
        match self.register(reg::LIBRARY) & 0x07 {
            0 => &[],
            _ => effects::parts(effect),
        }
    }

    /// Ends a part of what plays.
    fn go_on(&mut self, play: Play) {
        match play {
            Play::Sequence { entry, part } => self.play_from(entry, part + 1),
            Play::Diagnosis => self.conclude(self.is_whole()),
            Play::Calibration => {
                let calibrated = self.calibrate();
                self.conclude(calibrated);
            }
        }
        self.look = self.now;
    }

    fn conclude(&mut self, good: bool) {
        let status = &mut self.registers[usize::from(reg::STATUS)];
        *status = *status & !DIAG_RESULT | if good { 0 } else { DIAG_RESULT };
        self.end_play();
    }

    /// Tells whether the motor is there, whole, and of the kind that the registers state.
    const fn is_whole(&self) -> bool {
        let lra = matches!(self.motor, Motor::Lra(_));
        self.motor.fault().is_none() && lra == self.settings().is_lra()
    }

    /// Writes what a calibration found; returns whether it found anything.
    fn calibrate(&mut self) -> bool {
        let settings = self.settings();
        let (hz, emf) = (self.motor.hz(), self.motor.emf());
        let rated = settings.rated_v(hz);
        let half_s = 0.5 / hz;
        let guessed = !settings.is_lra() || (settings.drive_s() / half_s - 1.0).abs() <= GUESS;
        if !(self.is_whole() && guessed && rated > 0.0 && emf > 0.0) {
            return false;
        }
        let gains = settings.emf_gains();
        let code = |gain: f64| libm::round(emf * gain * reg::EMF_PER_V);
        let fits = (0..4).rev().find(|i| code(gains[*i]) <= 255.0);
        let Some(index) = fits else {
            return false;
        };
        self.registers[usize::from(reg::A_CAL_BEMF)] = code(gains[index]) as u8;
        let losses = libm::round(255.0 * (1.0 - emf / rated).max(0.0));
        self.registers[usize::from(reg::A_CAL_COMP)] = losses as u8;
        let feedback = &mut self.registers[usize::from(reg::FEEDBACK)];
        *feedback = *feedback & !0x03 | index as u8;
        true
    }

    /// Drive that is asked for now, -1 to 1 of full; `None` in standby or where the chip is too hot.
    fn asked(&self) -> Option<f64> {
        if !self.is_active() || self.hot {
            return None;
        }
        Some(match (self.mode(), self.play) {
            (5, _) => self.settings().asked(self.register(reg::RTP_INPUT)),
            (_, Some((Play::Sequence { entry, part }, _))) => {
                let value = self.register(reg::SEQUENCE + entry);
                let part = self.parts(value & 0x7F).get(part).filter(|_| value < 0x80);
                part.map_or(0.0, |(share, _)| *share)
            }
            (_, Some((Play::Diagnosis | Play::Calibration, _))) => 1.0,
            _ => 0.0,
        })
    }

    /// Looks at the motor and sets the output until the next look.
    fn decide(&mut self) {
        if self.hot {
            self.registers[usize::from(reg::STATUS)] |= OVER_TEMPERATURE;
            self.end_play();
        }
        let asked = self.asked();
        let wants = asked.is_some_and(|share| share != 0.0);
        if wants && self.motor.fault() == Some(MotorFault::Short) {
            self.registers[usize::from(reg::STATUS)] |= OVER_CURRENT;
            self.end_play();
            return self.off();
        }
        let Some(share) = asked.filter(|_| self.register(reg::LIBRARY) & 0x10 == 0) else {
            return self.off();
        };
        let settings = self.settings();
        let (hz, full) = (self.motor.hz(), settings.full_emf_v());
        let speed = if full > 0.0 {
            self.motor.emf() / full
        } else {
            0.0
        };
        let is_steered =
            !settings.is_open_loop() && !matches!(self.play, Some((Play::Calibration, _)));
        if share == 0.0 && (!is_steered || speed < AT_REST) {
            return self.off();
        }
        let volts = match (is_steered, settings.is_open_loop()) {
            (false, true) => share * settings.clamp_v(),
            (false, false) => share * settings.rated_v(hz),
            (true, _) => {
                let goal = share.max(0.0);
                let missing = goal - speed;
                let gain = settings.loop_gain();
                let gain = if missing < 0.0 {
                    gain * settings.brake()
                } else {
                    gain
                };
                (goal + gain * missing) * settings.rated_v(hz)
            }
        };
        let most = settings.clamp_v().min(self.supply_v).max(0.0);
        let volts = volts.clamp(-most, most);
        let (output, seconds) = match &self.motor {
            _ if !settings.is_lra() => (Drive::Steady(volts), settings.drive_s()),
            Motor::Lra(lra) if !settings.is_open_loop() => {
                // Tracking: the wave is in phase with the mass's speed. From rest it begins as a sine.
                let phase = match lra.amplitude_m() > 0.0 {
                    true => lra.speed_phase(),
                    false => -FRAC_PI_2,
                };
                (wave(volts, hz, phase), 0.5 / hz)
            }
            _ => {
                let hz = settings.open_hz();
                let phase = match self.output {
                    Drive::Wave { phase, .. } => phase,
                    _ => -FRAC_PI_2,
                };
                (wave(volts, hz, phase), 0.5 / hz)
            }
        };
        if settings.is_lra() && !settings.is_open_loop() {
            let period = libm::round(1.0 / hz / reg::PERIOD_S);
            self.registers[usize::from(reg::LRA_PERIOD)] = period as u8;
        }
        self.output = output;
        self.look = self.now + Nanos((seconds * 1e9) as u64).max(Nanos(1));
    }

    /// Drives nothing until something is written.
    fn off(&mut self) {
        // In standby the outputs have 15 kohm to ground, which brakes nothing.
        self.output = match self.is_active() && self.register(reg::LIBRARY) & 0x10 == 0 {
            true => Drive::Steady(0.0),
            false => Drive::Open,
        };
        self.look = Nanos::MAX;
    }
}

#[cfg(test)]
mod tests;
