//! The limits applied to one stimulus: pulse width, burst, supply, energy and heat, in this order.

use crate::schedule::{Reason, Stimulus, stagger};
use crate::units::{Channel, Duration, Instant, Milliamps, Ticks};

use super::limits::BURST_GAP;
use super::{Guard, Running, Setting};

/// Divisor of what is left of a budget: each burst leaves one part in four, so that a contact at rest fades.
const FADE: u64 = 4;

/// The part of a stimulus that the limits pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Passed {
    pub(super) width: Ticks,
    pub(super) until: Instant,
    pub(super) reason: Option<Reason>,
    /// Current that the amplifier shall be set to; `None` where the amplifier has a current of its own.
    pub(super) current: Option<Milliamps>,
    /// Electrical energy to book for it, nJ.
    energy_nj: u64,
}

impl Passed {
    /// Nothing of a stimulus, for a reason.
    pub(super) const fn nothing(until: Instant, reason: Option<Reason>) -> Self {
        Self {
            reason,
            ..Self::of_motor(Ticks::ZERO, until, None)
        }
    }

    /// A level of a motor, which has neither current nor energy to book.
    pub(super) const fn of_motor(level: Ticks, until: Instant, reason: Option<Reason>) -> Self {
        Self {
            width: level,
            until,
            reason,
            current: None,
            energy_nj: 0,
        }
    }
}

/// A burst in progress or the last one of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Burst {
    pub(super) start: Instant,
    pub(super) spent_nj: u64,
    end: Instant,
}

impl Burst {
    /// The end of its last stimulus.
    pub(super) const fn end(&self) -> Instant {
        self.end
    }

    /// The end of the burst so far: `now`, or the end of its last stimulus if that came before.
    pub(super) fn until(&self, now: Instant) -> Instant {
        self.end.min(now)
    }
}

/// The share of a budget's remainder that one burst may take: three quarters, rounded down.
pub(super) const fn faded(left: u64) -> u64 {
    left - left.div_ceil(FADE)
}

impl Guard {
    /// Passes the widest pulse and the latest end that the limits leave of a stimulus, and books it.
    pub(super) fn clamp(&mut self, index: usize, at: Instant, s: &Stimulus) -> Passed {
        let passed = self.judge(index, at, s);
        self.book(index, at, passed.until, passed.energy_nj);
        passed
    }

    /// Books a stimulus as it is, whatever the limits leave of it, with the reason for which they would have changed
    /// it.
    pub(super) fn note(&mut self, index: usize, at: Instant, s: &Stimulus) -> Passed {
        let Passed {
            reason, current, ..
        } = self.judge(index, at, s);
        // As it was asked for, up to what a converter can say.
        let control = self.current_control().filter(|_| current.is_some());
        let current = control.map(|control| s.peak.min(control.full_scale));
        let plant = self.counting(index, current);
        let energy_nj = match s.until > at {
            true => plant.energy_nj(s.width.get(), s.until.since(at)),
            false => 0,
        };
        self.book(index, at, s.until, energy_nj);
        Passed {
            width: s.width,
            until: s.until,
            reason,
            current,
            energy_nj,
        }
    }

    /// Judges a stimulus against every limit and books nothing.
    fn judge(&mut self, index: usize, at: Instant, s: &Stimulus) -> Passed {
        let commanded = self.commanded(index, at, s);
        let current = commanded.map(|(current, _)| current);
        let nothing = |reason| Passed {
            current,
            ..Passed::nothing(s.until, reason)
        };
        if self.motors.is_some() {
            return nothing(Some(Reason::Plant));
        }
        if self.latched().is_some() {
            return nothing(Some(Reason::Latched));
        }
        if s.width == Ticks::ZERO || s.until <= at {
            return nothing(None);
        }
        let mut reason = commanded.and_then(|(_, reason)| reason);
        let mut width = s.width.get();

        let widest = self.widest().get();
        if width > widest {
            (width, reason) = (widest, Some(Reason::PulseWidth));
        }

        // A burst that goes on: what is left of its time. From its first edge to its last it may take
        // longer than asked by one pulse and the bus, and the gap before it may be as much shorter.
        let burst = self.burst_at(index, at);
        let latest = self.latest(&burst);
        let mut until = s.until;
        if until > latest {
            (until, reason) = (latest, Some(Reason::Burst));
        }
        if until <= at {
            return nothing(Some(Reason::Burst));
        }

        // Supply: the wires already on, and this one, at their worst instant, each with the most that its amplifier can
        // give.
        let (on, off) = stagger(Channel(self.wires[index].place.1), Ticks::new(width));
        if !self.supply_bears(index, Setting { on, off }) {
            return nothing(Some(Reason::SupplyCurrent));
        }

        // Energy: narrow the pulses to the least that is left anywhere.
        let span = until.since(at);
        let (left, cause) = self.energy_left(index, at, until, burst.spent_nj);
        let plant = self.counting(index, current);
        let mut energy = plant.energy_nj(width, span);
        if energy > left {
            let fits = u128::from(width) * u128::from(left) / u128::from(energy);
            (width, reason) = (fits as u16, Some(cause)); // less than `width`, since left < energy
            energy = plant.energy_nj(width, span);
        }
        Passed {
            width: Ticks::new(width),
            until,
            reason,
            current,
            energy_nj: energy,
        }
    }

    /// Books the energy of a stimulus; without energy there is no stimulus to book.
    fn book(&mut self, index: usize, at: Instant, until: Instant, energy_nj: u64) {
        if energy_nj == 0 {
            return;
        }
        self.spend(index, at, until, energy_nj);
        self.extend_burst(index, at, until, energy_nj);
    }

    /// Goes on with a burst until `until`, or begins one.
    pub(super) fn extend_burst(
        &mut self,
        index: usize,
        at: Instant,
        until: Instant,
        energy_nj: u64,
    ) {
        let burst = self.burst_at(index, at);
        self.wires[index].burst = Some(Burst {
            start: burst.start,
            spent_nj: burst.spent_nj.saturating_add(energy_nj),
            end: until,
        });
    }

    /// The burst that a stimulus at `at` would continue, or begin.
    pub(super) fn burst_at(&self, index: usize, at: Instant) -> Burst {
        let slack = self.burst_slack();
        let goes_on = |b: &Burst| at < b.end + BURST_GAP + slack;
        self.wires[index].burst.filter(goes_on).unwrap_or(Burst {
            start: at,
            spent_nj: 0,
            end: at,
        })
    }

    /// The latest end of a burst's stimuli.
    pub(super) fn latest(&self, burst: &Burst) -> Instant {
        (burst.start + self.limits.burst) - self.burst_slack()
    }

    /// Returns true if the burst row passes a stimulus of this wire whole. A renderer that asks first can rest a wire
    /// that would be cut off. [`Self::admit`] alone decides what is driven.
    pub fn has_time(&self, wire: usize, at: Instant, until: Instant) -> bool {
        wire < self.wires.len() && until <= self.latest(&self.burst_at(wire, at))
    }

    /// The widest pulse that the pulse row passes.
    pub fn widest(&self) -> Ticks {
        Ticks::new(self.plant.widest(self.limits.pulse_width_ns))
    }

    /// Energy, nJ, that a stimulus may bring, and the limit that bounds it. A burst takes only a part of what is left
    /// of the budgets that fill again, so that a contact at rest fades instead of stepping down.
    fn energy_left(
        &mut self,
        index: usize,
        at: Instant,
        until: Instant,
        spent_nj: u64,
    ) -> (u64, Reason) {
        let (heat_nj, cause) = self.heat_left(index, at, until);
        // The whole guard fades or does not, and the stimuli of an onset may come here in another order.
        let part = match self.fades {
            true => faded,
            false => |left| left,
        };
        let wire = &mut self.wires[index];
        let rows = [
            (
                self.limits.burst_energy_nj.saturating_sub(spent_nj),
                Reason::Burst,
            ),
            (part(heat_nj), cause),
            (part(wire.power.left_nj(at)), Reason::WirePower),
            (part(self.fingertip.left_nj(at)), Reason::FingertipPower),
        ];
        rows.into_iter()
            .fold((u64::MAX, Reason::Burst), |least, row| {
                if row.0 < least.0 { row } else { least }
            })
    }

    /// The least energy, nJ, that the rows of heat leave, and the row; unbounded without those rows.
    fn heat_left(&mut self, index: usize, at: Instant, until: Instant) -> (u64, Reason) {
        let off = until + self.plant.surplus();
        let latency = self.plant.latency();
        let Some(heat) = &mut self.heat else {
            return (u64::MAX, Reason::SkinPeak);
        };
        let tissue = &mut heat.tissues[index];
        let booking = tissue.booking(at, off, latency);
        let (joules, cause) = tissue.room(&mut heat.budget, booking);
        // The cast saturates: nothing left is zero.
        ((joules * 1e9) as u64, cause)
    }

    /// Books the energy of a wire that is on between `at` and `until`.
    fn spend(&mut self, index: usize, at: Instant, until: Instant, energy_nj: u64) {
        self.wires[index].power.spend(energy_nj);
        self.fingertip.spend(energy_nj);
        if let Some(heat) = &mut self.heat {
            let off = until + self.plant.surplus();
            let tissue = &mut heat.tissues[index];
            let booking = tissue.booking(at, off, self.plant.latency());
            let predicted = tissue.heat(&mut heat.budget, booking, energy_nj as f64 * 1e-9);
            heat.predicted.raise(&predicted);
        }
    }

    /// Books the energy that a wire got beyond the end of its stimulus because it was switched off late.
    pub(super) fn book_late(&mut self, index: usize, was: &Running, off: Instant) {
        let span = off.since(was.until);
        if span == Duration::ZERO {
            return;
        }
        let width = was.setting.width();
        if let Some(motors) = &mut self.motors {
            motors.late(index, width, (was.until, off));
            return;
        }
        let energy = self
            .flowing(index)
            .late_nj(width, was.until.since(was.since), span);
        self.spend(index, was.until, off, energy);
        if let Some(burst) = &mut self.wires[index].burst {
            burst.spent_nj = burst.spent_nj.saturating_add(energy);
            burst.end = burst.end.max(off);
        }
    }

    /// Time by which a burst may exceed its request, and its gap fall short of it: one pulse and the bus.
    fn burst_slack(&self) -> Duration {
        Duration::from_micros(self.limits.pulse_width_ns.div_ceil(1000)) + self.plant.switching()
    }

    /// Returns true if the supply bears wire `index` set as given beside all that is on.
    ///
    /// The supply bears every wire that is on, because each one passed here. A pulse that overlaps no other on its
    /// board leaves the board's peak unchanged, if any other pulse is on there.
    pub(super) fn supply_bears(&self, index: usize, setting: Setting) -> bool {
        let board = self.wires[index].place.0;
        let on_board = self.wires.iter().filter(|w| w.place.0 == board);
        let mut pulses = on_board.filter_map(|w| w.now).peekable();
        let alone = pulses.peek().is_none();
        if !alone && pulses.all(|now| now.setting.is_apart(&setting)) {
            return true;
        }
        let peak = self.supply_peak(|i| match self.wires[i].now {
            _ if i == index => Some(setting),
            now => now.map(|now| now.setting),
        });
        peak <= u64::from(self.limits.supply.0)
    }

    /// Returns true if the supply bears a wire's widest pulse beside the other boards that are on, its own board
    /// being off.
    pub(super) fn supply_is_free(&self, index: usize) -> bool {
        let (board, channel) = self.wires[index].place;
        let (on, off) = stagger(Channel(channel), self.widest());
        let peak = self.supply_peak(|i| match &self.wires[i] {
            _ if i == index => Some(Setting { on, off }),
            other if other.place.0 == board => None,
            other => other.now.map(|now| now.setting),
        });
        peak <= u64::from(self.limits.supply.0)
    }

    /// Largest current, mA, at any instant of a period with the wires set as given. Boards run asynchronously, so
    /// their peaks add.
    pub(super) fn supply_peak(&self, running: impl Fn(usize) -> Option<Setting>) -> u64 {
        // By board, and boards are 0 ..= 15 by construction of a display.
        let mut most = [0; 16];
        for (i, wire) in self.wires.iter().enumerate() {
            let Some(starts) = running(i) else {
                continue;
            };
            // The sum only grows where a pulse starts.
            let board = wire.place.0;
            let on_board = (0..self.wires.len()).filter(|&j| self.wires[j].place.0 == board);
            let on = |s: &Setting| s.on <= starts.on && starts.on < s.off;
            let count = on_board.filter_map(&running).filter(on).count();
            if let Some(most) = most.get_mut(usize::from(board.0)) {
                *most = count.max(*most);
            }
        }
        let most: usize = most.iter().sum();
        most as u64 * u64::from(self.plant.peak.0)
    }
}
