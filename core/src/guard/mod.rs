//! The last stage before the driver: nothing reaches a wire that has not passed here.
//!
//! The guard clamps, shortens or refuses; it keeps what was requested beside what it applied, with the
//! reason. What it returns, [`Guarded`], is the only thing a driver accepts, and only this module can
//! make one. Switching off needs no guard.

mod limits;
mod power;

pub use limits::{BURST_GAP, HARD, Limits};

use alloc::boxed::Box;
use core::fmt;

use crate::illusion::Wire;
use crate::schedule::{Entry, Reason, Stimulus, stagger};
use crate::units::{Board, Duration, Instant, Milliamps, Prescale, Ticks};

use power::{Bucket, Window};

/// The oscillators seen on real chips, Hz: the slowest makes the longest pulses, the fastest the most.
const OSCILLATOR_HZ: (u64, u64) = (23_000_000, 27_400_000);

/// A burst takes at most this part of the energy that is left: one in two.
const FADE: u64 = 2;

/// What one channel shall do from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Tick at which the pulse starts in each period.
    pub on: u16,
    /// Tick at which it ends; equal to `on` for a channel that is off.
    pub off: u16,
}

/// An update of one board that the guard has passed. Only the guard can make one: its fields are
/// private and there is no other constructor, so a driver that takes a `Guarded` takes nothing else.
///
/// ```compile_fail
/// # use palpate_core::{guard::Guarded, units::{Board, Instant}};
/// let forged = Guarded { at: Instant::ZERO, board: Board(0), channels: [None; 16] };
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Guarded {
    at: Instant,
    board: Board,
    channels: [Option<Setting>; 16],
}

impl Guarded {
    /// When the update is to take effect.
    pub const fn at(&self) -> Instant {
        self.at
    }

    /// The board it is for.
    pub const fn board(&self) -> Board {
        self.board
    }

    /// The channels to change, by number; `None` leaves a channel as it is.
    pub const fn channels(&self) -> &[Option<Setting>; 16] {
        &self.channels
    }
}

/// What the guard must know of the hardware it protects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plant {
    /// PRE_SCALE of the boards.
    pub prescale: Prescale,
    /// Resistance of one wire with its leads, milliohms.
    pub wire_milliohm: u32,
    /// Largest current an amplifier can be asked for.
    pub peak: Milliamps,
}

/// Why a guard cannot protect this hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantError {
    /// Resistance or current is zero or absurd (over 1 kOhm or 100 A).
    OutOfRange,
}

impl fmt::Display for PlantError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("expected a wire resistance of 1 to 1000000 milliohms and a peak current of 1 to 100000 mA")
    }
}

impl core::error::Error for PlantError {}

/// What the guard remembers of one wire.
#[derive(Clone, Debug)]
struct WireState {
    place: (Board, u8),
    power: Bucket,
    /// Start and energy so far (nJ) of the burst in progress or last ended, and when it ends.
    burst: Option<(Instant, u64, Instant)>,
    /// What the channel does now.
    now: Option<Running>,
}

/// A channel that is on.
#[derive(Clone, Copy, Debug)]
struct Running {
    setting: Setting,
    /// Current it draws while high.
    peak: Milliamps,
    /// When it has to end.
    until: Instant,
}

/// The guard of one fingertip: static limits of the table, from above.
#[derive(Clone, Debug)]
pub struct Guard {
    limits: Limits,
    plant: Plant,
    wires: Box<[WireState]>,
    fingertip: Bucket,
    latched: Option<&'static str>,
}

impl Guard {
    /// A guard over a display's wires. Limits looser than [`HARD`] are tightened to it.
    ///
    /// # Errors
    /// When the plant's figures are none a wire can have.
    pub fn new(limits: Limits, plant: Plant, wires: &[Wire]) -> Result<Self, PlantError> {
        let plausible = |x: u32, most: u32| (1..=most).contains(&x);
        if !(plausible(plant.wire_milliohm, 1_000_000) && plausible(plant.peak.0, 100_000)) {
            return Err(PlantError::OutOfRange);
        }
        let limits = limits.tightened();
        let state = |w: &Wire| WireState {
            place: (w.board, w.channel.0),
            power: bucket((1, limits.wire_1s_uw), (10, limits.wire_10s_uw)),
            burst: None,
            now: None,
        };
        Ok(Self {
            limits,
            plant,
            wires: wires.iter().map(state).collect(),
            fingertip: bucket((1, limits.fingertip_1s_uw), (60, limits.fingertip_60s_uw)),
            latched: None,
        })
    }

    /// The limits in force.
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Refuses everything from now on. The first cause is kept.
    pub fn latch(&mut self, cause: &'static str) {
        self.latched.get_or_insert(cause);
    }

    /// Why everything is refused, if it is.
    pub const fn latched(&self) -> Option<&'static str> {
        self.latched
    }

    /// Clears the latch: the documented way back, by a person's decision only.
    pub fn unlatch(&mut self) {
        self.latched = None;
    }

    /// Passes stimuli for one board, together. Wires of that board without a stimulus are switched off
    /// if they were on. Calls `ledger` with every line, refused ones too, in order of the stimuli.
    ///
    /// Stimuli for unknown wires or another board are ignored: there is nothing they could drive.
    pub fn admit(
        &mut self,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        mut ledger: impl FnMut(Entry),
    ) -> Guarded {
        let mut update = self.release(at, board);
        for stimulus in stimuli {
            let index = usize::from(stimulus.wire);
            let Some((owner, channel)) = self.wires.get(index).map(|w| w.place) else {
                continue;
            };
            if owner != board || usize::from(channel) >= update.channels.len() {
                continue;
            }
            let (width, until, reason) = self.clamp(index, at, stimulus);
            let (on, off) = stagger(crate::units::Channel(channel), width);
            let setting = Setting { on, off };
            if width > Ticks::ZERO {
                self.wires[index].now = Some(Running {
                    setting,
                    peak: stimulus.peak,
                    until,
                });
                update.channels[usize::from(channel)] = Some(setting);
            }
            ledger(Entry {
                at,
                board,
                channel: crate::units::Channel(channel),
                on,
                off,
                until,
                requested: stimulus.width,
                reason,
            });
        }
        update
    }

    /// Switches off every wire of one board that is on. Always passes.
    pub fn release(&mut self, at: Instant, board: Board) -> Guarded {
        self.switch_off(at, board, |_| true)
    }

    /// Switches off the wires of one board whose stimulus has ended by `at`. Always passes.
    pub fn expire(&mut self, at: Instant, board: Board) -> Guarded {
        self.switch_off(at, board, |running| running.until <= at)
    }

    /// When the next stimulus ends.
    pub fn next_expiry(&self) -> Option<Instant> {
        self.wires
            .iter()
            .filter_map(|w| w.now)
            .map(|running| running.until)
            .min()
    }

    fn switch_off(
        &mut self,
        at: Instant,
        board: Board,
        which: impl Fn(&Running) -> bool,
    ) -> Guarded {
        let mut update = Guarded {
            at,
            board,
            channels: [None; 16],
        };
        for wire in self.wires.iter_mut().filter(|w| w.place.0 == board) {
            if let (Some(was), Some(slot)) = (
                wire.now.take_if(|now| which(now)),
                update.channels.get_mut(usize::from(wire.place.1)),
            ) {
                *slot = Some(Setting {
                    on: was.setting.on,
                    off: was.setting.on,
                });
            }
        }
        update
    }

    /// Everything off and forgotten as running: after an all-off of the driver.
    pub fn all_off(&mut self) {
        self.wires.iter_mut().for_each(|w| w.now = None);
    }

    /// The widest pulse and the latest end the limits leave of a stimulus, booked as spent.
    fn clamp(
        &mut self,
        index: usize,
        at: Instant,
        s: &Stimulus,
    ) -> (Ticks, Instant, Option<Reason>) {
        let refuse = |reason| (Ticks::ZERO, s.until, Some(reason));
        if self.latched.is_some() {
            return refuse(Reason::Latched);
        }
        if s.width == Ticks::ZERO || s.until <= at {
            return (Ticks::ZERO, s.until, None);
        }
        let mut reason = None;
        let mut width = s.width.get();

        // Pulse width, at the slowest oscillator.
        let slowest_tick_ps = self.tick_ps(OSCILLATOR_HZ.0);
        let longest =
            (self.limits.pulse_width_ns.saturating_mul(1000) / slowest_tick_ps).min(4095) as u16;
        if width > longest {
            (width, reason) = (longest, Some(Reason::PulseWidth));
        }

        // A burst that goes on: what is left of its time and of its energy.
        let previous = self.wires[index]
            .burst
            .filter(|&(_, _, end)| at < end + BURST_GAP);
        let (start, spent) = previous.map_or((at, 0), |(start, spent, _)| (start, spent));
        let mut until = s.until;
        if until > start + self.limits.burst {
            (until, reason) = (start + self.limits.burst, Some(Reason::Burst));
        }
        if until <= at {
            return refuse(Reason::Burst);
        }

        // Supply: the wires already on, and this one, at their worst instant.
        let peak = s.peak.min(self.plant.peak);
        let (on, off) = stagger(
            crate::units::Channel(self.wires[index].place.1),
            Ticks::new(width),
        );
        if self.supply_peak(index, Setting { on, off }, peak) > u64::from(self.limits.supply.0) {
            return refuse(Reason::SupplyCurrent);
        }

        // Energy: burst, then the windows. Narrow the pulses to what is left; of a window no burst takes
        // more than a part of what is left, so that a contact that rests fades instead of stepping down.
        let span = until.since(at);
        let room = [
            (
                self.limits.burst_energy_nj.saturating_sub(spent),
                Reason::Burst,
            ),
            (
                self.wires[index].power.left_nj(at) / FADE,
                Reason::WirePower,
            ),
            (self.fingertip.left_nj(at) / FADE, Reason::FingertipPower),
        ];
        for (left, cause) in room {
            let wanted = self.energy_nj(width, peak, span);
            if wanted > left {
                let fits = u128::from(width) * u128::from(left) / u128::from(wanted.max(1));
                width = fits as u16; // less than `width`, since left < wanted
                reason = Some(cause);
            }
        }
        if width == 0 {
            return (Ticks::ZERO, until, reason);
        }
        let energy = self.energy_nj(width, peak, span);
        let wire = &mut self.wires[index];
        wire.power.spend(energy);
        self.fingertip.spend(energy);
        wire.burst = Some((start, spent.saturating_add(energy), until));
        (Ticks::new(width), until, reason)
    }

    /// Length of a tick at an oscillator frequency, picoseconds, rounded up.
    fn tick_ps(&self, oscillator_hz: u64) -> u64 {
        ((u64::from(self.plant.prescale.get()) + 1) * 1_000_000_000_000).div_ceil(oscillator_hz)
    }

    /// Electrical energy, nJ, of pulses of `width` ticks for a `span`: from above over all oscillators.
    ///
    /// `span / period + 1` pulses can start within a span. With the oscillator at f the n-th part is
    /// `I^2 R width (span f / 4096 + tick)`: the mean does not depend on f, the pulse too many is longest
    /// at the slowest.
    fn energy_nj(&self, width: u16, peak: Milliamps, span: Duration) -> u64 {
        let nanowatt = u128::from(peak.0).pow(2) * u128::from(self.plant.wire_milliohm);
        let extra_ps = u128::from(self.tick_ps(OSCILLATOR_HZ.0)) * u128::from(width);
        let mean_ps = u128::from(span.as_micros()) * 1_000_000 * u128::from(width) / 4096;
        let nj = (nanowatt * (mean_ps + extra_ps)).div_ceil(1_000_000_000_000);
        nj.min(u128::from(u64::MAX / 4)) as u64
    }

    /// Largest current, mA, at any instant of a period with wire `index` set as given and the others as
    /// they are. Boards run asynchronously, so their peaks add.
    fn supply_peak(&self, index: usize, setting: Setting, peak: Milliamps) -> u64 {
        let running = |i: usize| match i == index {
            true => Some((setting, peak)),
            false => self.wires[i].now.map(|now| (now.setting, now.peak)),
        };
        let board_peak = |board: Board| {
            let on_board =
                || (0..self.wires.len()).filter(move |&i| self.wires[i].place.0 == board);
            let total_at = |tick: u16| -> u64 {
                let high = |(s, ma): (Setting, Milliamps)| {
                    (s.on <= tick && tick < s.off).then_some(u64::from(ma.0))
                };
                on_board().filter_map(running).filter_map(high).sum()
            };
            // The sum only grows where a pulse starts.
            on_board()
                .filter_map(running)
                .map(|(s, _)| total_at(s.on))
                .max()
                .unwrap_or(0)
        };
        // Boards are 0 ..= 15 by construction of a display.
        (0..16).map(|b| board_peak(Board(b))).sum()
    }
}

/// A bucket over two windows, each (seconds, mean microwatts).
fn bucket(short: (u64, u64), long: (u64, u64)) -> Bucket {
    let window = |(seconds, mean_uw): (u64, u64)| Window {
        length: Duration::from_millis(seconds * 1000),
        mean_uw,
    };
    Bucket::new(window(short), window(long))
}

#[cfg(test)]
mod tests;
