//! The renderer: from contacts to pulses on wires that are felt at the contacts, within what heat allows.
//!
//! It asks the guard before it plans, so that the guard has nothing left to change. Wires of one contact are scaled
//! together: the level gives way before the place does.

mod borne;
mod pattern;
mod pulse;
mod reached;
mod reserve;
mod response;
mod tracks;

pub use borne::Borne;
pub use pattern::{CADENCE, Pattern, PatternError};
pub use pulse::Density;
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
    /// Responses of a texture's bursts, each with its number of pulses, ascending; none where no texture is felt.
    pub woven: Box<[(u8, Response)]>,
    /// Amplitude of a vibration's pulses on one wire at full level, in the response's unit: the most that a contact of
    /// weight 1 shall have. [`Response::full`] where no level is asked for.
    pub full: f32,
    /// Amplitude of a vibration's pulses on one wire that is felt as strongly as a texture shall be, in the response's unit.
    pub texture: f32,
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

impl RenderSettings {
    /// Response to bursts of so many pulses that a texture leaves; of whole bursts for `None`.
    fn answer(&self, woven: Option<u8>) -> &Response {
        let row = woven.and_then(|pulses| {
            let enough = self.woven.iter().find(|(row, _)| *row >= pulses);
            enough.or(self.woven.last())
        });
        row.map_or(&self.response, |(_, response)| response)
    }
}

/// Bursts of which another has chosen the length, such as those of a texture or a known stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stated {
    /// Time for which every wire is on.
    pub length: Duration,
    /// Pulses that a texture leaves of every burst; `None` for as many as fit in.
    pub woven: Option<u8>,
    /// Part of a whole burst's energy that the guard books for what is left of it.
    pub booked: f32,
}

impl Stated {
    /// Bursts without a texture.
    pub const fn whole(length: Duration) -> Self {
        Self {
            length,
            woven: None,
            booked: 1.0,
        }
    }
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

    /// Pulses of every wire at the onset `at` for these contacts, within what the guard leaves. All bursts are as
    /// `stated`; else the pattern says.
    pub fn render(
        &mut self,
        at: Instant,
        targets: &[Target],
        stated: Option<Stated>,
        guard: &Guard,
    ) -> &[Volley] {
        self.amplitudes.fill(0.0);
        self.volleys.fill(Volley::default());
        let mut scale = f32::INFINITY;
        for target in targets {
            scale = scale.min(self.aim(at, target, stated, guard));
        }
        let part = self.widen(at, stated, guard);
        self.reached.add(scale * part);
        self.spend(at, stated, guard);
        &self.volleys
    }

    /// Takes the pulses from the reserves of their wires.
    fn spend(&mut self, at: Instant, stated: Option<Stated>, guard: &Guard) {
        for (reserve, volley) in self.reserves.iter_mut().zip(&self.volleys) {
            if volley.width > Ticks::ZERO {
                let whole_nj = guard.energy_nj(volley.width, volley.length);
                let booked_nj = |s: Stated| (whole_nj as f32 * s.booked) as u64;
                reserve.spend(at, stated.map_or(whole_nj, booked_nj));
            }
        }
    }

    /// Adds amplitudes and pulses of one contact, scaled to what its wires bear, to those of others. Returns the part
    /// of full level that is left to the contact; infinite for a contact beyond the display.
    fn aim(&mut self, at: Instant, target: &Target, stated: Option<Stated>, guard: &Guard) -> f32 {
        let RenderSettings {
            law,
            style,
            pattern,
            full,
            sharing,
            calibration,
            ..
        } = &self.settings;
        let response = self.settings.answer(stated.and_then(|s| s.woven));
        let booked = stated.map_or(1.0, |s| s.booked);
        let track = self.tracks.follow(target.place, at);
        let tap = style.taps(track.rests, pattern);
        let lasts = |pulses: u8| stated.map_or(pattern.lasts(pulses), |s| s.length);
        let period_ns = guard.prescale().period_ns();
        let fit = |length: Duration| (length.as_micros() * 1000).div_ceil(period_ns);
        let most = stated.map_or(pattern.pulses(tap), |s| {
            let fit = fit(s.length).clamp(1, 255) as u8;
            s.woven.map_or(fit, |pulses| pulses.clamp(1, fit))
        });
        match stated {
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
                let reserve = &self.reserves[wire];
                let most = bearable(guard, reserve, wire, (at, lasts(*n)), booked);
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
    fn widen(&mut self, at: Instant, stated: Option<Stated>, guard: &Guard) -> f32 {
        let response = self.settings.answer(stated.and_then(|s| s.woven));
        let booked = stated.map_or(1.0, |s| s.booked);
        let bears = SLOW * guard.fingertip_nj(at) as f32;
        let mut left = 1.0;
        for _ in 0..=CORRECTIONS {
            let mut total = 0;
            for (volley, amplitude) in self.volleys.iter_mut().zip(&self.amplitudes) {
                if *amplitude > 0.0 {
                    volley.width = response.width(*amplitude);
                    total += guard.energy_nj(volley.width, volley.length);
                }
            }
            let total_nj = total as f32 * booked;
            if total_nj <= bears {
                break;
            }
            let part = bears / total_nj;
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

/// The widest pulse, ticks, of which a wire bears a burst of this length, or what is left of it that books so large a part.
fn bearable(
    guard: &Guard,
    reserve: &Reserve,
    wire: usize,
    (at, length): (Instant, Duration),
    booked: f32,
) -> f32 {
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
    (left / (tick * booked)).min(f32::from(budget.widest.get()))
}

#[cfg(test)]
#[path = "render_tests.rs"]
mod tests;
