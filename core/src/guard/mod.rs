//! The last stage before the driver: nothing reaches a wire that has not passed here.
//!
//! The guard clamps, shortens or refuses; it keeps what was requested beside what it applied, with the
//! reason. What it returns, [`Guarded`], is the only thing a driver accepts, and only this module can
//! make one. Switching off needs no guard.

mod admission;
mod budget;
mod current;
mod decays;
mod dose;
mod kernel;
mod lasting;
mod limits;
mod memory;
mod motors;
mod observed;
mod overrun;
mod plant;
mod power;
mod rest;
mod setting;
mod table;
mod thermal;
mod used;
mod watchdog;

pub use budget::WireBudget;
pub use current::CurrentControl;
pub use dose::Doses;
pub use kernel::WornWire;
pub use lasting::Booked;
pub use limits::{BURST_GAP, HARD, Limits};
pub use memory::{Memory, MemoryError, WireMemory};
pub use motors::{GuardedVibration, MotorLimits};
pub use observed::Observed;
pub use overrun::Overrun;
pub use plant::{Plant, PlantError};
pub use power::Spent;
pub use setting::Setting;
pub use thermal::Predicted;
pub use used::Used;
pub use watchdog::Cause;

use alloc::boxed::Box;

use crate::illusion::DisplayWire;
use crate::schedule::{Entry, Stimulus, stagger};
use crate::units::{Board, Channel, Duration, Instant, Milliamps, Prescale};

use admission::{Burst, Passed};
use current::Settable;
use motors::Motors;
use overrun::Ending;
use power::{Bucket, Window};
use thermal::Heat;
use watchdog::Watchdog;

/// An update of one board that the guard has passed. Only the guard can make one: its fields are
/// private and there is no other constructor, so a driver that takes a `Guarded` takes nothing else.
///
/// ```compile_fail
/// # use palpate_core::{guard::Guarded, units::{Board, Instant, Milliamps}};
/// let forged = Guarded { at: Instant::ZERO, board: Board(0), channels: [None; 16], ends: [Instant::ZERO; 16], currents: [Milliamps(0); 16] };
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Guarded {
    at: Instant,
    board: Board,
    channels: [Option<Setting>; 16],
    /// End of each channel that goes on.
    ends: [Instant; 16],
    /// Current to which the amplifier of each channel that goes on shall be set.
    currents: [Milliamps; 16],
}

impl Guarded {
    /// Time at which the update is to take effect.
    pub const fn at(&self) -> Instant {
        self.at
    }

    /// The board that the update is for.
    pub const fn board(&self) -> Board {
        self.board
    }

    /// Changes one channel until `end`; a display has none beyond the sixteenth.
    fn set(&mut self, channel: u8, setting: Setting, end: Instant) {
        let channel = usize::from(channel);
        if let (Some(slot), Some(until)) =
            (self.channels.get_mut(channel), self.ends.get_mut(channel))
        {
            (*slot, *until) = (Some(setting), end);
        }
    }

    /// Current to which the amplifier of a channel shall be set before the channel goes on; zero where the amplifier
    /// has a current of its own. `None` for a channel that does not go on.
    pub fn current(&self, channel: u8) -> Option<Milliamps> {
        let setting = self.channels.get(usize::from(channel)).copied().flatten();
        let on = setting.filter(|setting| setting.on < setting.off);
        on.and_then(|_| self.currents.get(usize::from(channel)).copied())
    }

    fn set_current(&mut self, channel: u8, current: Option<Milliamps>) {
        if let Some(slot) = self.currents.get_mut(usize::from(channel)) {
            *slot = current.unwrap_or_default();
        }
    }

    /// End of each channel that goes on, by number: a driver far away must know it beforehand. A channel that goes
    /// off has the time of the update.
    pub const fn ends(&self) -> &[Instant; 16] {
        &self.ends
    }

    /// Returns true if any channel is to change.
    pub fn changes(&self) -> bool {
        self.channels.iter().any(Option::is_some)
    }

    /// The channels to change, by number; `None` leaves a channel as it is.
    pub const fn channels(&self) -> &[Option<Setting>; 16] {
        &self.channels
    }
}

/// The guard's memory of one wire.
#[derive(Clone, Debug)]
struct WireState {
    place: (Board, u8),
    power: Bucket,
    burst: Option<Burst>,
    /// The pulse that the channel is driven with now.
    now: Option<Running>,
    /// The pulse before, where the guard does not know that it has ended.
    ending: Option<Ending>,
}

/// A channel that is on.
#[derive(Clone, Copy, Debug)]
struct Running {
    setting: Setting,
    since: Instant,
    /// Time at which the pulse has to end.
    until: Instant,
}

/// The guard of one fingertip: every limit of the table, from above.
///
/// Heat and dose count from its making; a reset keeps them, as everything else does.
#[derive(Clone, Debug)]
pub struct Guard {
    limits: Limits,
    plant: Plant,
    wires: Box<[WireState]>,
    fingertip: Bucket,
    /// The rows of heat and dose; `None` in a guard that is another guard's last word.
    heat: Option<Box<Heat>>,
    /// The wire of those rows.
    worn: Option<WornWire>,
    /// True if a burst leaves a part of each budget that fills again.
    fades: bool,
    /// Amplifiers whose current is set; `None` for those with a current of their own.
    settable: Option<Box<Settable>>,
    /// The rows of motors, in place of those of wires; `None` in a guard of wires.
    motors: Option<Box<Motors>>,
    watchdog: Watchdog,
    overrun: Option<Overrun>,
    /// True if an overrun was found since the latch was last closed.
    overran: bool,
    /// True while updates are observed only: they drive emulated registers, whatever the guard says of them.
    looks_on: bool,
}

impl Guard {
    /// A guard over a display's wires, each of them a `worn` one. Limits looser than [`HARD`] are tightened to it.
    ///
    /// # Errors
    /// [`PlantError`] when no wire can have the plant's figures, or there are no rows of heat for such a wire or
    /// finger.
    pub fn new(
        limits: Limits,
        plant: Plant,
        wires: &[DisplayWire],
        worn: WornWire,
    ) -> Result<Self, PlantError> {
        Ok(Self {
            fades: true,
            ..Self::last_word(limits, plant, wires, Some(worn))?
        })
    }

    /// The last word of a driver unit, behind a whole guard: what that passed, this one passes unchanged, since a burst may
    /// take all that is left of a budget here. Without a `worn` wire it has the integer rows alone, for a processor without
    /// floating point: pulse, burst, energy, power, supply, staleness and latch.
    ///
    /// # Errors
    /// The errors of [`Self::new`].
    pub fn last_word(
        limits: Limits,
        plant: Plant,
        wires: &[DisplayWire],
        worn: Option<WornWire>,
    ) -> Result<Self, PlantError> {
        plant.check()?;
        let kernel = worn.map(|worn| worn.kernel()).transpose()?;
        let limits = limits.tightened();
        // A burst booked at an onset reaches this far beyond it.
        let reach = limits.burst + plant.latency() + plant.surplus();
        let bucket = |short: (u64, u64), long: (u64, u64)| {
            let window = |(seconds, mean_uw): (u64, u64)| Window {
                length: Duration::from_millis(seconds * 1000),
                mean_uw,
            };
            Bucket::new(window(short), window(long), reach)
        };
        let state = |w: &DisplayWire| WireState {
            place: (w.board, w.channel.0),
            power: bucket((1, limits.wire_1s_uw), (10, limits.wire_10s_uw)),
            burst: None,
            now: None,
            ending: None,
        };
        Ok(Self {
            limits,
            plant,
            wires: wires.iter().map(state).collect(),
            fingertip: bucket((1, limits.fingertip_1s_uw), (60, limits.fingertip_60s_uw)),
            heat: kernel.map(|kernel| Box::new(Heat::new(&limits, kernel, wires.len()))),
            worn,
            fades: false,
            settable: None,
            motors: None,
            watchdog: Watchdog::new(limits.stale, plant.latency()),
            overrun: None,
            overran: false,
            looks_on: false,
        })
    }

    /// The limits in force.
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// PRE_SCALE of the boards that are guarded.
    pub const fn prescale(&self) -> Prescale {
        self.plant.prescale
    }

    /// Time by which a channel may be on beyond its stimulus: the rest of a period at the slowest clock, and the bus.
    pub fn surplus(&self) -> Duration {
        self.plant.surplus()
    }

    /// The most that was predicted under any wire so far, for all that has passed; skin at rest where
    /// [`Self::has_heat`] is false.
    pub fn predicted(&self) -> &Predicted {
        self.heat
            .as_ref()
            .map_or(&Predicted::REST, |heat| &heat.predicted)
    }

    /// The wire and finger of its thermal rows; `None` without them.
    pub const fn worn(&self) -> Option<WornWire> {
        self.worn
    }

    /// Returns true if the guard has the thermal rows.
    pub const fn has_heat(&self) -> bool {
        self.heat.is_some()
    }

    /// The boards as the guard knows them.
    pub const fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Tells the watchdog of a sensor frame received at `at`.
    pub fn hear(&mut self, at: Instant) {
        self.watchdog.hear(at);
    }

    /// Time at which the newest sensor frame was received.
    pub const fn heard(&self) -> Option<Instant> {
        self.watchdog.heard()
    }

    /// Returns true if no sensor frame has come for so long that nothing may be driven.
    pub fn is_stale(&self, now: Instant) -> bool {
        self.watchdog.is_stale(now)
    }

    /// Time at which sensor input becomes too old for anything to be driven.
    pub fn stale_at(&self) -> Instant {
        self.watchdog.deadline()
    }

    /// Lets the watchdog look at `now`, and returns the cause to switch everything off for, if there is one. The loop
    /// calls it at every turn, and at [`Self::deadline`] at the latest.
    pub fn watch(&mut self, now: Instant) -> Option<Cause> {
        let end = self.next_expiry();
        let cause = self.watchdog.look(now, end);
        match self.is_overdue(now) {
            true => Some(Cause::Overrun),
            false => cause,
        }
    }

    /// Time at which sensor input becomes too old for what is driven; a latched guard has noticed.
    pub fn deadline(&self) -> Option<Instant> {
        let driven = self.next_expiry().is_some() && self.latched().is_none();
        driven.then(|| self.stale_at())
    }

    /// Refuses everything from now on. The first cause stays, except that an overrun replaces a failed bus.
    pub fn latch(&mut self, cause: Cause) {
        self.overran = false;
        self.watchdog.latch(cause);
    }

    /// The cause for which everything is refused, if it is.
    pub const fn latched(&self) -> Option<Cause> {
        self.watchdog.latched()
    }

    /// Checks that frames come and that the loop runs on time.
    ///
    /// # Errors
    /// The cause for which nothing may be driven.
    pub fn ready(&self, now: Instant) -> Result<(), Cause> {
        self.watchdog.ready(now)
    }

    /// Opens the latch, for a caller that has made sure that the outputs are off and their link is whole;
    /// [`Projector::reset`](crate::projector::Projector::reset) does.
    ///
    /// # Errors
    /// The cause that persists, as in [`Self::ready`]; the latch stays closed.
    pub fn reset(&mut self, now: Instant) -> Result<(), Cause> {
        self.ready(now)?;
        self.watchdog.open();
        Ok(())
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
        ledger: impl FnMut(Entry),
    ) -> Guarded {
        self.looks_on = false;
        let update = self.release(at, board);
        self.pass(update, stimuli, Self::clamp, ledger)
    }

    /// Admits stimuli like [`Self::admit`], but lets wires without one go on. A stimulus without width ends its wire.
    pub fn change(
        &mut self,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Guarded {
        self.looks_on = false;
        let named = |wire: usize| stimuli.iter().any(|s| usize::from(s.wire) == wire);
        let update = self.switch_off(at, board, |wire, _| named(wire));
        self.pass(update, stimuli, Self::clamp, ledger)
    }

    /// Adds the stimuli of one board, each as `judge` leaves it, to an `update` that ended those before them.
    fn pass(
        &mut self,
        mut update: Guarded,
        stimuli: &[Stimulus],
        judge: impl Fn(&mut Self, usize, Instant, &Stimulus) -> Passed,
        mut ledger: impl FnMut(Entry),
    ) -> Guarded {
        let (at, board) = (update.at, update.board);
        for stimulus in stimuli {
            let index = usize::from(stimulus.wire);
            let Some(channel) = self.channel(index, board) else {
                continue;
            };
            let passed = judge(self, index, at, stimulus);
            let (on, off) = match self.motors {
                Some(_) => (0, passed.width.get()),
                None => stagger(Channel(channel), passed.width),
            };
            let setting = Setting { on, off };
            if on < off && passed.until > at {
                self.wires[index].now = Some(Running {
                    setting,
                    since: at,
                    until: passed.until,
                });
                update.set(channel, setting, passed.until);
                update.set_current(channel, passed.current);
            }
            ledger(Entry {
                at,
                board,
                channel: Channel(channel),
                on,
                off,
                until: passed.until,
                requested: stimulus.width,
                requested_until: stimulus.until,
                current: passed.current,
                reason: passed.reason,
            });
        }
        update
    }

    /// The channel of a wire, if it hangs on this board.
    fn channel(&self, wire: usize, board: Board) -> Option<u8> {
        let place = self.wires.get(wire).map(|w| w.place);
        place.filter(|p| p.0 == board).map(|p| p.1)
    }

    /// Switches off every wire of one board that is on. Always passes.
    pub fn release(&mut self, at: Instant, board: Board) -> Guarded {
        self.switch_off(at, board, |_, _| true)
    }

    /// Switches off the wires of one board whose stimulus has ended by `at`. Always passes.
    pub fn expire(&mut self, at: Instant, board: Board) -> Guarded {
        self.switch_off(at, board, |_, running| running.until <= at)
    }

    /// End of the next stimulus to end.
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
        which: impl Fn(usize, &Running) -> bool,
    ) -> Guarded {
        let mut update = Guarded {
            at,
            board,
            channels: [None; 16],
            ends: [at; 16],
            currents: [Milliamps(0); 16],
        };
        for index in 0..self.wires.len() {
            let wire = &mut self.wires[index];
            let (owner, channel) = wire.place;
            if owner != board {
                continue;
            }
            let Some(was) = wire.now.take_if(|now| which(index, now)) else {
                continue;
            };
            self.told_off(index, was, at);
            let ended = Setting {
                on: was.setting.on,
                off: was.setting.on,
            };
            update.set(channel, ended, at);
        }
        update
    }
}

#[cfg(test)]
mod last_word_tests;
#[cfg(test)]
mod plain_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod thermal_tests;
#[cfg(test)]
mod whole_tests;
