//! The renderer: from contacts to pulses on wires that are felt at the contacts, within what heat allows.
//!
//! It asks the guard before it plans, so that the guard has nothing left to change. Wires of one contact are scaled
//! together: the level gives way before the place does.

mod borne;
mod pattern;
mod reached;
mod reserve;
mod response;
mod tracks;

pub use borne::Borne;
pub use pattern::{CADENCE, Pattern, PatternError};
pub use reached::Reached;
pub use response::Response;

use alloc::boxed::Box;
use alloc::vec;

use crate::guard::Guard;
use crate::illusion::{Calibration, Illusion, Inverse, Sharing, Target};
use crate::listed::listed;
use crate::schedule::Reason;
use crate::units::{Duration, Instant, Ticks};

use reserve::{Reserve, SESSION};
use tracks::Tracks;

/// Largest part that a burst takes of what rows of power leave. These
/// rows remember many bursts: a contact that comes to rest fades slowly.
const SLOW: f32 = 0.25;
/// Largest part that a burst takes of what the other rows leave.
const FAST: f32 = 0.6;
/// Largest rise of a contact's scale from one onset to the next: 1.65 dB, the smallest difference in intensity that was
/// just noticeable on an index pad (Israr 2006).
const RISE: f32 = 1.209_2;
/// A scale from which a contact may begin at once: 14 dB under full level. Nothing
/// is felt there on a bench of which full level is a few just noticeable differences
/// over threshold. A contact that had to stop altogether comes back from here.
const SILENT: f32 = 0.2;
/// Time constant with which a wearer is believed to add up energy in the Pacinian channel, s (`docs/felt.md`). An emulated
/// person has its own, which may differ.
const LEAK_S: f32 = 0.2;
/// A vibration of at most so many pulses gains by becoming a tap.
const FEW: u8 = 4;
/// Times that widths are corrected where a fingertip bears less than all contacts want.
const CORRECTIONS: u32 = 3;

listed! {
    /// Styles in which a felt contact is rendered.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Style: name {
        /// A vibration: bursts of at least 30 ms.
        #[default]
        Smooth = "smooth",
        /// Taps: bursts of two pulses, which are felt more strongly at the same power.
        Tap = "tap",
        /// Taps while the contact rests, a vibration while it moves. Where the current is so small that a vibration
        /// takes many pulses, two of them are weaker at any power, and it stays a vibration.
        Auto = "auto",
    }
}

impl Style {
    /// Returns true if a contact that rests or moves is rendered as taps.
    const fn taps(self, rests: bool, pattern: &Pattern) -> bool {
        match self {
            Self::Smooth => false,
            Self::Tap => true,
            Self::Auto => rests && pattern.pulses(false) <= FEW,
        }
    }
}

/// Settings of the renderer.
#[derive(Debug)]
pub struct RenderSettings {
    /// Law that places contacts.
    pub law: Inverse,
    /// Vibration or taps.
    pub style: Style,
    /// Pulses and cadence.
    pub pattern: Pattern,
    /// Felt amplitude of a pulse by its width.
    pub response: Response,
    /// Amplitude of a vibration's pulses on one wire at full level, in the response's unit: the most that a contact of
    /// weight 1 shall have. [`Response::largest`] where no level is asked for.
    pub full: f32,
    /// Rule by which several contacts share wires.
    pub sharing: Sharing,
    /// Calibration of this person by wire. Thresholds are the published laws': here a weak wire may be below its own,
    /// since all wires of a contact are felt together.
    pub calibration: Calibration,
}

/// Pulses of one wire at an onset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Volley {
    /// Width of a pulse; zero for a wire that stays off.
    pub width: Ticks,
    /// Time for which the wire is on.
    pub length: Duration,
}

/// The renderer and all its memory.
#[derive(Debug)]
pub struct Renderer {
    settings: RenderSettings,
    reserves: Box<[Reserve]>,
    tracks: Tracks,
    /// Amplitude of one contact on each wire, then its pulses.
    one: Box<[f32]>,
    counts: Box<[u8]>,
    /// Amplitude of all contacts on each wire.
    amplitudes: Box<[f32]>,
    volleys: Box<[Volley]>,
    borne: Borne,
    reached: Reached,
}

impl Renderer {
    /// A renderer for the wires of a guard at rest; the last time that it allocates.
    pub fn new(settings: RenderSettings, guard: &Guard, wires: usize) -> Self {
        let rate_uw = guard.sustained_uw(SESSION);
        Self {
            borne: settings.borne(guard, wires),
            settings,
            reserves: vec![Reserve::new(rate_uw); wires].into(),
            tracks: Tracks::default(),
            one: vec![0.0; wires].into(),
            counts: vec![0; wires].into(),
            amplitudes: vec![0.0; wires].into(),
            volleys: vec![Volley::default(); wires].into(),
            reached: Reached::default(),
        }
    }

    /// Nearness of contacts to full level so far.
    pub const fn reached(&self) -> Reached {
        self.reached
    }

    /// Part of full level that one wire bears.
    pub const fn borne(&self) -> Borne {
        self.borne
    }

    /// The width of a vibration's pulses at this weight on one wire that bears them.
    pub fn width(&self, weight: f32) -> Ticks {
        self.settings.response.width(self.settings.full * weight)
    }

    /// Pulses of every wire at the onset `at` for these contacts, within what the guard leaves. With `length` all
    /// bursts are as long, such as those of a texture or a known stroke; else the pattern says.
    pub fn render(
        &mut self,
        at: Instant,
        targets: &[Target],
        length: Option<Duration>,
        guard: &Guard,
    ) -> &[Volley] {
        self.amplitudes.fill(0.0);
        self.volleys.fill(Volley::default());
        let mut scale = f32::INFINITY;
        for target in targets {
            scale = scale.min(self.aim(at, target, length, guard));
        }
        let part = self.widen(at, guard);
        self.reached.add(scale * part);
        for (reserve, volley) in self.reserves.iter_mut().zip(&self.volleys) {
            if volley.width > Ticks::ZERO {
                reserve.spend(at, guard.energy_nj(volley.width, volley.length));
            }
        }
        &self.volleys
    }

    /// Adds amplitudes and pulses of one contact, scaled to what its wires bear, to those of others. Returns the part
    /// of full level that is left to the contact; infinite for a contact beyond the display.
    fn aim(
        &mut self,
        at: Instant,
        target: &Target,
        length: Option<Duration>,
        guard: &Guard,
    ) -> f32 {
        let RenderSettings {
            law,
            style,
            pattern,
            response,
            full,
            sharing,
            calibration,
        } = &self.settings;
        let track = self.tracks.follow(target.place, at);
        let tap = style.taps(track.rests, pattern);
        let period_ns = guard.prescale().period_ns();
        let fit = length.map(|l| (l.as_micros() * 1000).div_ceil(period_ns));
        let lasts = |pulses: u8| length.unwrap_or(pattern.lasts(pulses));
        let most = fit.map_or(pattern.pulses(tap), |n| n.clamp(1, 255) as u8);
        match length {
            None => law.split(target.place, most, &mut self.one, &mut self.counts),
            Some(_) => {
                law.activate(target.place, &mut self.one);
                self.counts.fill(most);
            }
        }
        // As much energy in fewer pulses.
        let pulses = f32::from(pattern.pulses(false)) / f32::from(most);
        let full = full * libm::sqrtf(pulses);
        let mut scale = f32::INFINITY;
        for (wire, (one, n)) in self.one.iter_mut().zip(&self.counts).enumerate() {
            if *one > 0.0 {
                *one *= full * calibration.gain(wire);
                let most = bearable(guard, &self.reserves[wire], wire, at, lasts(*n));
                scale = scale.min(response.amplitude(most) / *one);
            }
        }
        let borne = scale;
        let most = match track.scale {
            None => first(pattern),
            Some(before) => (before * RISE).clamp(SILENT, 1.0),
        };
        let scale = scale.min(most);
        // Beyond the display nothing is felt: the burst with which a contact comes in is its first.
        if borne.is_finite() {
            track.scale = Some(scale.min(1.0));
        }
        let wires = self.one.iter().zip(&self.counts);
        for (wire, (one, n)) in wires.enumerate().filter(|(_, (one, _))| **one > 0.0) {
            let mine = one * scale * target.weight;
            let all = &mut self.amplitudes[wire];
            if mine > *all {
                self.volleys[wire].length = lasts(*n);
            }
            *all = match sharing {
                Sharing::Strongest | Sharing::Slices => all.max(mine),
                Sharing::Sum => libm::sqrtf(*all * *all + mine * mine),
            };
        }
        // No wire of it is on: nothing bounded its scale.
        if borne.is_finite() {
            scale.min(1.0)
        } else {
            borne
        }
    }

    /// Converts amplitudes to widths. Where all together want more than the fingertip bears, all contacts get weaker
    /// alike: each keeps its part of the power. Returns the part of every amplitude that is left.
    fn widen(&mut self, at: Instant, guard: &Guard) -> f32 {
        let bears = SLOW * guard.fingertip_nj(at) as f32;
        let mut left = 1.0;
        for _ in 0..=CORRECTIONS {
            let mut total = 0;
            for (volley, amplitude) in self.volleys.iter_mut().zip(&self.amplitudes) {
                if *amplitude > 0.0 {
                    volley.width = self.settings.response.width(*amplitude);
                    total += guard.energy_nj(volley.width, volley.length);
                }
            }
            if total as f32 <= bears {
                break;
            }
            let part = bears / total as f32;
            self.amplitudes.iter_mut().for_each(|a| *a *= part);
            left *= part;
        }
        left
    }
}

/// Ratio of a contact's first burst to those that follow: a person
/// adds up energy with a leak, and a first burst has none before it.
fn first(pattern: &Pattern) -> f32 {
    let soa_s = pattern.timing().soa.as_micros() as f32 * 1e-6;
    libm::sqrtf(1.0 / (1.0 - libm::expf(-soa_s / LEAK_S)))
}

/// The widest pulse, ticks, of which a wire bears a burst of this length.
fn bearable(guard: &Guard, reserve: &Reserve, wire: usize, at: Instant, length: Duration) -> f32 {
    let Some(budget) = guard.budget(wire, at, at + length) else {
        return 0.0;
    };
    let part = |(row, left): &(Reason, u64)| match row {
        Reason::WirePower | Reason::FingertipPower => SLOW * *left as f32,
        _ => FAST * *left as f32,
    };
    let rows = budget.energy_nj.iter().map(part);
    let left = rows.fold(SLOW * reserve.left_nj(at), f32::min);
    let tick = guard.energy_nj(Ticks::new(1000), length) as f32 / 1000.0;
    (left / tick).min(f32::from(budget.widest.get()))
}

#[cfg(test)]
#[path = "render_tests.rs"]
mod tests;
