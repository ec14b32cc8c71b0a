//! The response of a wire to a pulse: the amplitude that is felt, by width.

use alloc::boxed::Box;

use crate::units::Ticks;

/// Amplitudes of the default bench's wires, as the typical person feels them: a width in ticks of PRE_SCALE 92, and the
/// root of the filtered energy per pulse, um s^0.5. Wider pulses are felt less than one of 41 ticks.
///
/// The emulators computed it for wires `loose-50um` at 1.2 A, as they do for each run (`hil/run/src/plan/response.rs`). A
/// test of `palpate-tests` computes it anew and compares to the bit.
const THIN_8MM: [(u16, f32); 12] = [
    (0, 0.0),
    (5, 0.009_849_101),
    (9, 0.014_848_241),
    (13, 0.041_054_68),
    (17, 0.074_046_81),
    (21, 0.107_249_38),
    (25, 0.127_982_35),
    (29, 0.139_562_3),
    (33, 0.143_630_61),
    (37, 0.154_205_81),
    (41, 0.154_672_44),
    (49, 0.154_672_44),
];

/// Amplitudes by width of a pulse, any unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Amplitudes by ticks; never falling.
    amplitudes: Box<[f32]>,
}

impl Response {
    /// Response of a wire that expands: in proportion to a pulse's energy, 1 for a pulse of one tick.
    pub fn linear(widest: Ticks) -> Self {
        Self::new((0..=widest.get()).map(f32::from).collect())
    }

    /// Response from an amplitude for each width from no tick on.
    /// A width that is felt less than a narrower one gets the narrower one's amplitude.
    pub fn new(mut amplitudes: Box<[f32]>) -> Self {
        let mut most = 0.0;
        for amplitude in &mut amplitudes {
            most = amplitude.max(most);
            *amplitude = most;
        }
        Self { amplitudes }
    }

    /// Draws straight lines between amplitudes at ascending widths, the first of which is 0.
    pub fn between(known: &[(u16, f32)]) -> Self {
        let amplitudes = known.windows(2).flat_map(|pair| {
            let [(from, low), (to, high)] = [pair[0], pair[1]];
            (from..to).map(move |w| low + (high - low) * f32::from(w - from) / f32::from(to - from))
        });
        let last = known.last().map(|(_, amplitude)| *amplitude);
        Self::new(amplitudes.chain(last).collect())
    }

    /// The response of a thin wire of 8 mm at 1.2 A to three pulses every 117 ms, in ticks of PRE_SCALE 92: `hil run`
    /// emulates such wires by default.
    pub fn thin_8mm(widest: Ticks) -> Self {
        let whole = Self::between(&THIN_8MM).amplitudes;
        let widths = usize::from(widest.get()) + 1;
        Self::new(whole.iter().take(widths).copied().collect())
    }

    /// The largest amplitude: the most that full level can be. Where a wire does with a pulse less, all wires of its
    /// contact are weaker together.
    pub fn largest(&self) -> f32 {
        self.amplitudes.last().copied().unwrap_or(0.0)
    }

    /// The amplitude of pulses not wider than `ticks`.
    pub(super) fn amplitude(&self, ticks: f32) -> f32 {
        // A cast saturates, and what is no number is 0.
        let width = (ticks as usize).min(self.amplitudes.len().saturating_sub(1));
        let amplitude = |width: usize| self.amplitudes.get(width).copied().unwrap_or(0.0);
        let part = (ticks - width as f32).clamp(0.0, 1.0);
        amplitude(width) + part * (amplitude(width + 1).max(amplitude(width)) - amplitude(width))
    }

    /// The width whose amplitude is nearest.
    pub(super) fn width(&self, amplitude: f32) -> Ticks {
        let above = self.amplitudes.partition_point(|a| *a < amplitude);
        let of = |width: usize| self.amplitudes.get(width).copied().unwrap_or(f32::INFINITY);
        let below = above.saturating_sub(1);
        let nearer = if of(above) - amplitude <= amplitude - of(below) {
            above
        } else {
            below
        };
        Ticks::new(nearer.min(self.amplitudes.len().saturating_sub(1)) as u16)
    }
}

#[cfg(test)]
#[path = "response_tests.rs"]
mod tests;
