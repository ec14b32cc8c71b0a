//! Reset, SLEEP and RESTART, the clock, OE and the supply (data sheet 7.3.1.1, 7.3.5, 7.4, 7.5, 7.6).

use palpate_core::codec::pca9685::{PRE_SCALE_RESET, SUBADR_RESET, WAKE_US, mode1, mode2};

use super::channel::Channel;
use super::clock::Counter;
use super::{Hazard, Oscillator, Pca9685, pins, registers};
use crate::time::Nanos;

impl Pca9685 {
    /// Drives the OE pin; high switches the outputs to what OUTNE says [7.4].
    pub fn set_output_enable_pin(&mut self, at: Nanos, high: bool) {
        self.act(at);
        self.oe_high = high;
        self.look_for_oe_hazard();
        self.settle();
    }

    /// Takes the supply away: pins float, the chip answers nothing and forgets everything.
    pub fn power_off(&mut self, at: Nanos) {
        self.act(at);
        self.reset();
        self.powered = false;
        self.settle();
    }

    /// Gives the supply back: reset values, asleep, all full off [7.5].
    pub fn power_on(&mut self, at: Nanos) {
        self.act(at);
        if !self.powered {
            self.powered = true;
            self.reset();
            self.settle();
        }
    }

    /// A brown-out too short to see: reset values from `at` on [7.5].
    pub fn power_cycle(&mut self, at: Nanos) {
        self.power_off(at);
        self.power_on(at);
    }

    /// Changes the internal oscillator from `at` on, phase kept exactly.
    pub fn set_oscillator(&mut self, at: Nanos, oscillator: Oscillator) {
        self.act(at);
        self.config.oscillator = oscillator;
        self.retune();
    }

    /// Puts a clock of `hz` on the EXTCLK pin, zero for none; counts only once EXTCLK is set [7.3.1].
    pub fn set_external_clock(&mut self, at: Nanos, hz: u32) {
        self.act(at);
        self.external = u64::from(hz.min(50_000_000)) * 1000;
        self.retune();
        self.try_start();
        self.settle();
    }

    fn retune(&mut self) {
        let millihertz = self.millihertz();
        if let Some(counter) = &mut self.counter {
            counter.retune(self.now, millihertz);
        }
    }

    pub(super) fn on_external_clock(&self) -> bool {
        self.mode1 & mode1::EXTCLK != 0
    }

    /// The clock in force, millihertz.
    pub(super) fn millihertz(&self) -> u64 {
        if self.on_external_clock() {
            self.external
        } else {
            self.config.oscillator.millihertz_at(self.now)
        }
    }

    /// Reset values [7.5]; the only thing that clears EXTCLK.
    pub(super) fn reset(&mut self) {
        self.mode1 = mode1::RESET;
        self.restart = false;
        self.mode2 = mode2::RESET;
        self.addresses = SUBADR_RESET;
        self.pre = PRE_SCALE_RESET;
        self.bus = registers::Bus::default();
        self.counter = None;
        self.start_at = None;
        self.stopping = false;
        self.invalidate_leds();
        self.look_for_oe_hazard();
    }

    /// A write to MODE1 takes effect with its ACK.
    pub(super) fn write_mode1(&mut self, value: u8) {
        let slept = self.mode1 & mode1::SLEEP != 0;
        let sleeps = value & mode1::SLEEP != 0;
        // The switch is made by writing SLEEP and EXTCLK while asleep, and never back [7.3.1].
        let external = mode1::EXTCLK & (self.mode1 | if slept && sleeps { value } else { 0 });
        self.mode1 = external | value & !(mode1::EXTCLK | mode1::RESTART);
        if sleeps && !slept {
            self.fall_asleep();
        }
        if slept && !sleeps {
            self.stable_at = self.now + Nanos::from_micros(WAKE_US);
            self.try_start();
        }
        let asks = value & mode1::RESTART != 0 && !sleeps;
        if asks && (self.restart || self.stopping) {
            if self.now < self.stable_at {
                self.hazard(Hazard::RestartTooEarly);
            } else {
                self.resume();
            }
        }
    }

    /// Running outputs finish their cycle; then the oscillator stops.
    fn fall_asleep(&mut self) {
        self.start_at = None;
        if self.counter.is_some() {
            self.stopping = true;
        } else if !self.restart {
            self.stop_clock();
        }
    }

    /// The oscillator stops: paused if outputs were active; after an orderly shutdown the LED registers
    /// are no longer valid [7.3.1.1], which is modelled as their reset values.
    pub(super) fn stop_clock(&mut self) {
        self.counter = None;
        self.stopping = false;
        if self.channels.iter().any(Channel::wants_on) {
            self.restart = true;
        } else if self.mode1 & mode1::SLEEP != 0 {
            self.invalidate_leds();
        }
    }

    fn invalidate_leds(&mut self) {
        self.channels = std::array::from_fn(|_| Channel::new());
    }

    /// RESTART is cleared: all channels start again from the beginning of a cycle.
    fn resume(&mut self) {
        self.restart = false;
        if self.stopping {
            self.stopping = false;
            self.counter = None;
        }
        self.try_start();
    }

    /// LED registers were committed: ends a pause, starts a held counter [7.3.1.1].
    pub(super) fn led_committed(&mut self) {
        let awake = self.mode1 & mode1::SLEEP == 0;
        if self.restart || (self.stopping && awake) {
            self.resume();
        } else {
            self.try_start();
        }
        if !self.stopping && self.channels.iter().all(Channel::is_off) {
            self.counter = None; // an immediate update switched the last one off: held
        }
    }

    /// Starts the counter, or sets the time when it will start, if there is any reason to.
    fn try_start(&mut self) {
        let awake = self.powered && self.mode1 & mode1::SLEEP == 0 && !self.restart;
        if awake && self.counter.is_none() && self.channels.iter().any(Channel::wants_on) {
            let at = self.now.max(self.stable_at);
            self.start_at = Some(at);
            if at <= self.now {
                self.start_counter();
            }
        }
    }

    /// Starts from zero, with PRE_SCALE and the LED registers as they are.
    pub(super) fn start_counter(&mut self) {
        self.start_at = None;
        let millihertz = self.millihertz();
        if millihertz == 0 || !self.channels.iter().any(Channel::wants_on) {
            return;
        }
        self.counter = Some(Counter::start(self.now, self.pre, millihertz));
        for channel in &mut self.channels {
            channel.start();
        }
    }

    pub(super) fn look_for_oe_hazard(&mut self) {
        let drives_all = self.powered && self.oe_high && pins::oe_drives_all(self.mode2);
        if drives_all && !self.oe_hazard {
            self.hazard(Hazard::OutputEnableDrivesAll);
        }
        self.oe_hazard = drives_all;
    }
}
