//! Voice coils on the channels of a sound card: levels in, frames of samples out.
//!
//! Every channel is one sine of a fixed frequency under an envelope that goes to the guarded level in straight lines. Time is
//! the count of frames since the start of the run.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::{Actuators, AudioFault, AudioPlanError, Driver, DriverError, Traffic};
use crate::guard::GuardedVibration;
use crate::units::{Board, Duration, Instant};

/// Anything that plays frames of samples of 16 bits: a sound card, a file, a pipe, an emulated card.
pub trait AudioSink {
    /// Frames between a write and its sound, at most.
    fn latency(&self) -> u32;

    /// Drops what is not played yet, and begins anew with as much silence as [`Self::latency`] says.
    ///
    /// # Errors
    /// [`AudioFault`] of a card that does not begin.
    fn restart(&mut self) -> Result<(), AudioFault>;

    /// Takes whole frames: a sample of each channel, one frame after the other.
    ///
    /// # Errors
    /// [`AudioFault`] of a card that has run dry, or takes nothing.
    fn write(&mut self, samples: &[i16]) -> Result<(), AudioFault>;
}

/// Channels of a card and the sine on them.
#[derive(Clone, Debug, PartialEq)]
pub struct AudioPlan {
    /// Frames per second.
    pub rate_hz: u32,
    /// Frequency of the sine, Hz.
    pub sine_hz: f64,
    /// Frames in which an envelope goes from nothing to the highest level.
    pub ramp: u32,
    /// Peak of the highest level, as a part of full scale.
    pub full: f64,
    /// Channel of each actuator, counted from zero.
    pub channels: Vec<u8>,
}

impl AudioPlan {
    /// Samples in a frame: up to the last channel that an actuator has.
    pub fn width(&self) -> usize {
        let last = self.channels.iter().max();
        last.map_or(0, |last| usize::from(*last) + 1)
    }

    fn check(&self) -> Result<(), AudioPlanError> {
        if self.rate_hz == 0 {
            return Err(AudioPlanError::NoRate);
        }
        if !(self.sine_hz > 0.0 && self.sine_hz <= f64::from(self.rate_hz) / 4.0) {
            return Err(AudioPlanError::Sine(self.sine_hz, self.rate_hz));
        }
        if !(self.full > 0.0 && self.full <= 1.0) {
            return Err(AudioPlanError::Level(self.full));
        }
        if !(1..=MOST).contains(&self.channels.len()) {
            return Err(AudioPlanError::Count(self.channels.len()));
        }
        for (number, channel) in (0..).zip(&self.channels) {
            if *channel >= WIDEST {
                return Err(AudioPlanError::NoChannel(number, *channel));
            }
            if self.channels[..usize::from(number)].contains(channel) {
                return Err(AudioPlanError::ChannelTwice(number, *channel));
            }
        }
        Ok(())
    }
}

/// Most actuators of one finger: an update has so many channels.
const MOST: usize = 16;
/// Most channels of a card.
const WIDEST: u8 = 32;
/// Frames that are made at a time.
const BLOCK: usize = 64;
/// A sample at full scale.
pub const FULL_SCALE: i16 = i16::MAX;

/// Envelope of one actuator, in levels.
#[derive(Clone, Copy, Debug, Default)]
struct Envelope {
    now: f64,
    goal: u8,
}

impl Envelope {
    /// The next value, at most `step` nearer to the goal.
    fn next(&mut self, step: f64) -> f64 {
        let goal = f64::from(self.goal);
        self.now = goal.clamp(self.now - step, self.now + step);
        self.now
    }
}

/// Voice coils on a sound card. To the loop they are board 0, an actuator its channel.
///
/// Whoever holds it lets it [`render`](Self::render) up to the present at least every [`AudioSink::latency`], or the card runs
/// dry. After [`Actuators::all_off`] the last sound ends within [`Self::tail`].
#[derive(Debug)]
pub struct Audio<S> {
    sink: S,
    plan: AudioPlan,
    envelopes: Box<[Envelope]>,
    block: Box<[i16]>,
    /// Frames so far.
    frames: u64,
    /// Part of a period at the next frame, 0 to 1.
    phase: f64,
    fault: Option<AudioFault>,
    traffic: Traffic,
}

impl<S: AudioSink> Audio<S> {
    /// Coils at rest; nothing is written yet.
    ///
    /// # Errors
    /// [`AudioPlanError`] of the first part of the plan that cannot be.
    pub fn new(sink: S, plan: AudioPlan) -> Result<Self, AudioPlanError> {
        plan.check()?;
        Ok(Self {
            envelopes: alloc::vec![Envelope::default(); plan.channels.len()].into(),
            block: alloc::vec![0; BLOCK * plan.width()].into(),
            sink,
            plan,
            frames: 0,
            phase: 0.0,
            fault: None,
            traffic: Traffic::default(),
        })
    }

    /// Longest time from switching off to silence: the envelope's way to zero, and the frames that the card still has.
    pub fn tail(&self) -> Duration {
        let frames = u64::from(self.plan.ramp) + u64::from(self.sink.latency());
        Duration::from_micros((frames * MICROS).div_ceil(u64::from(self.plan.rate_hz)))
    }

    /// Writes every frame before `until`. A fault of the card is kept for the next update, and ends every envelope.
    pub fn render(&mut self, until: Instant) {
        let until = until.as_micros() * u64::from(self.plan.rate_hz) / MICROS;
        let width = self.plan.width();
        while self.frames < until {
            let count = (until - self.frames).min(BLOCK as u64) as usize; // at most BLOCK
            self.frames += count as u64;
            if self.fault.is_none() {
                self.fill(count);
                let written = self.sink.write(&self.block[..count * width]);
                self.fault = written.err();
            }
            if self.fault.is_some() {
                self.envelopes.fill(Envelope::default());
            }
        }
    }

    /// Makes the next frames.
    fn fill(&mut self, count: usize) {
        let (plan, width) = (&self.plan, self.plan.width());
        let block = &mut self.block[..count * width];
        block.fill(0);
        let turn = plan.sine_hz / f64::from(plan.rate_hz);
        let step = f64::from(GuardedVibration::FULL) / f64::from(plan.ramp.max(1));
        let scale = plan.full * f64::from(FULL_SCALE) / f64::from(GuardedVibration::FULL);
        let silent = |e: &Envelope| e.goal == 0 && e.now <= 0.0;
        if self.envelopes.iter().all(silent) {
            self.phase = (self.phase + turn * count as f64) % 1.0;
            return;
        }
        for frame in block.chunks_exact_mut(width) {
            let sine = scale * libm::sin(core::f64::consts::TAU * self.phase);
            for (envelope, channel) in self.envelopes.iter_mut().zip(&plan.channels) {
                // Towards zero, so that rounding passes no level.
                frame[usize::from(*channel)] = (sine * envelope.next(step)) as i16;
            }
            self.phase = (self.phase + turn) % 1.0;
        }
    }

    fn healthy(&self) -> Result<(), DriverError> {
        self.fault.map_or(Ok(()), |f| Err(DriverError::Audio(f)))
    }
}

/// Microseconds of a second.
const MICROS: u64 = 1_000_000;

impl<S: AudioSink> Actuators<GuardedVibration> for Audio<S> {
    type Error = DriverError;

    /// Levels take effect at the frame of the update's time.
    fn apply(&mut self, update: &GuardedVibration) -> Result<(), DriverError> {
        self.render(update.at());
        self.healthy()?;
        let before = self.traffic.channels;
        for (envelope, level) in self.envelopes.iter_mut().zip(update.levels()) {
            match level {
                Some(level) if level == envelope.goal => self.traffic.unchanged_channels += 1,
                Some(level) => {
                    envelope.goal = level;
                    self.traffic.channels += 1;
                }
                None => {}
            }
        }
        match self.traffic.channels == before {
            true => self.traffic.unchanged_updates += 1,
            false => self.traffic.writes += 1,
        }
        Ok(())
    }

    /// Lets every envelope go to zero. A card with a fault is silent, and says so.
    fn all_off(&mut self) -> Result<(), DriverError> {
        self.envelopes.iter_mut().for_each(|e| e.goal = 0);
        self.healthy()
    }

    fn confirmed(&self, asked: Instant) -> Instant {
        asked + self.tail()
    }
}

impl<S: AudioSink> Driver<GuardedVibration> for Audio<S> {
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.envelopes.fill(Envelope::default());
        self.fault = Some(AudioFault::Underrun);
        // Frames before now are over: the card had none of them.
        self.render(now);
        self.sink.restart().map_err(DriverError::Audio)?;
        self.fault = None;
        Ok(now)
    }

    fn verify(&mut self) -> Result<(), DriverError> {
        self.healthy()
    }

    fn retries(&self) -> u64 {
        0
    }

    fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn boards(&self) -> Vec<Board> {
        alloc::vec![Board(0)]
    }
}

#[cfg(test)]
#[path = "audio_tests.rs"]
mod tests;
