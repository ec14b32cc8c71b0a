//! The renderer beside the published laws: what an onset costs, and how far both centroids are from the contact.
//!
//! Wires are linear here (a pulse twice as wide has twice the amplitude), so that the error is the law's alone, and every
//! onset goes through the guard, so that there is something to read in its budgets.

use std::hint::black_box;

use palpate_core::guard::{Guard, HARD, Plant, WornWire};
use palpate_core::illusion::{
    Calibration, Display, IllusionModel, Mixer, ModelSettings, Sharing, Target, build, inverse,
};
use palpate_core::render::{CADENCE, Pattern, RenderSettings, Renderer, Response, Style, Volley};
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Duration, Instant, Milliamps, Point, Ticks};
use palpate_live::clock;
use palpate_run::Failure;

use crate::findings::{Error, Findings};
use crate::illusion::many;
use crate::scenes::display;
use crate::timing::Samples;

/// Onsets timed; the first tenth warms up.
const ONSETS: u64 = 20_000;
/// The published current, and pulses that carry a moving contact's power at it.
const PEAK: Milliamps = Milliamps(1970);
const PULSES: u8 = 3;
/// Contacts at an onset.
const CONTACTS: [usize; 2] = [1, 4];
/// Targets with one contact: 8 and 128 wires, microseconds.
const TARGETS_US: [f64; 2] = [3.0, 20.0];

/// Both centroids' squared distances from the contact, mm2.
#[derive(Clone, Copy, Debug, Default)]
struct Misses {
    energy: f64,
    amplitude: f64,
    onsets: u64,
}

impl Misses {
    /// Adds an onset: pulses and amplitude of each wire, any unit.
    fn add(&mut self, display: &Display, at: Point, wires: impl Iterator<Item = (f64, f64)>) {
        let mut sums = [[0.0; 3]; 2];
        for (wire, (pulses, amplitude)) in display.wires().iter().zip(wires) {
            let (x, y) = (wire.place.x - at.x, wire.place.y - at.y);
            let weights = [pulses * amplitude * amplitude, amplitude];
            for (sum, weight) in sums.iter_mut().zip(weights) {
                sum[0] += weight;
                sum[1] += weight * f64::from(x);
                sum[2] += weight * f64::from(y);
            }
        }
        let [energy, amplitude] = sums.map(|[all, x, y]| (x * x + y * y) / (all * all));
        self.energy += energy;
        self.amplitude += amplitude;
        self.onsets += 1;
    }

    /// Root mean square by the worse centroid.
    fn error(&self) -> Error {
        let worse = self.energy.max(self.amplitude);
        let mm = (worse / self.onsets as f64).sqrt();
        (mm, "mm RMSE, the worse centroid")
    }
}

/// A display, its guard, its renderer and every published law.
struct Rig {
    display: Display,
    guard: Guard,
    renderer: Renderer,
    laws: Vec<(&'static str, Mixer)>,
    onset: u64,
}

/// Measurements of one method.
#[derive(Default)]
struct Measured {
    us: Samples,
    misses: Misses,
}

impl Rig {
    fn new(display: Display) -> Result<Self, Failure> {
        let failed = |e: String| Failure::Input(format!("bench render: {e}"));
        let wires = display.wires().len();
        let pattern = Pattern::new(CADENCE, PULSES).map_err(|e| failed(e.to_string()))?;
        let plant = Plant {
            prescale: pattern.prescale(),
            peak: PEAK,
            ..Plant::default()
        };
        let guard = Guard::new(HARD, plant, display.wires(), WornWire::default())
            .map_err(|e| failed(e.to_string()))?;
        let settings = RenderSettings {
            law: inverse(&display, &ModelSettings::default()).map_err(|e| failed(e.to_string()))?,
            style: Style::Smooth,
            pattern,
            full: Response::linear(guard.widest()).largest(),
            response: Response::linear(guard.widest()),
            sharing: Sharing::default(),
            calibration: Calibration::even(wires),
        };
        let published = IllusionModel::ALL.into_iter();
        let laws = published.filter(|model| *model != IllusionModel::Inverse);
        let laws = laws.map(|model| {
            let settings = ModelSettings {
                model,
                ..ModelSettings::default()
            };
            let law = build(&display, &settings).map_err(|e| failed(e.to_string()))?;
            Ok((model.name(), Mixer::new(law, Sharing::default(), wires)))
        });
        Ok(Self {
            laws: laws.collect::<Result<_, Failure>>()?,
            renderer: Renderer::new(settings, &guard, wires),
            guard,
            display,
            onset: 0,
        })
    }

    /// Contacts of the next onset: inside the hull, and such that no branch predictor learns them.
    fn targets(&self, count: usize) -> Vec<Target> {
        let wires = self.display.wires();
        let target = |n: usize| {
            let k = self.onset as usize * 4 + n;
            let (a, b) = (
                wires[k * 37 % wires.len()].place,
                wires[(k * 59 + 13) % wires.len()].place,
            );
            let part = (k as f64 * 0.618_034).fract() as f32;
            Target {
                place: Point::new(a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)),
                weight: 1.0,
            }
        };
        (0..count).map(target).collect()
    }

    /// One onset of every method, the renderer's first, which goes through the guard; how many stimuli that changed.
    fn onset(&mut self, count: usize, warm: bool, all: &mut [Measured]) -> u64 {
        self.onset += 1;
        let at = Instant::ZERO + Duration::from_micros(CADENCE.as_micros() * self.onset);
        let targets = self.targets(count);
        self.guard.hear(at);
        let begun = clock::now();
        let volleys = black_box(self.renderer.render(at, &targets, None, &self.guard));
        let us = begun.elapsed().as_secs_f64() * 1e6;
        let period_ns = self.guard.prescale().period_ns();
        let pulses = |volley: &Volley| (volley.length.as_micros() * 1000).div_ceil(period_ns);
        let made = volleys.iter().map(|v| {
            let width = f64::from(v.width.get());
            (pulses(v) as f64, width)
        });
        if warm {
            all[0].us.push(us);
            all[0].misses.add(&self.display, targets[0].place, made);
        }
        let volleys = volleys.to_vec();
        let limited = self.admit(at, &volleys);
        for ((_, mixer), measured) in self.laws.iter_mut().zip(&mut all[1..]) {
            let begun = clock::now();
            let activations = black_box(mixer.activate(&targets));
            let us = begun.elapsed().as_secs_f64() * 1e6;
            if warm {
                let made = activations.iter().map(|a| (1.0, f64::from(*a)));
                measured.us.push(us);
                measured.misses.add(&self.display, targets[0].place, made);
            }
        }
        limited
    }

    /// Hands an onset to the guard, board by board.
    fn admit(&mut self, at: Instant, volleys: &[Volley]) -> u64 {
        let mut limited = 0;
        let boards: u8 = self
            .display
            .wires()
            .iter()
            .map(|w| w.board.0)
            .max()
            .unwrap_or(0);
        for board in (0..=boards).map(Board) {
            let mine = self.display.wires().iter().zip(volleys).enumerate();
            let mine = mine.filter(|(_, (wire, v))| wire.board == board && v.width > Ticks::ZERO);
            let stimuli: Vec<Stimulus> = mine
                .map(|(wire, (_, volley))| Stimulus {
                    wire: wire as u16,
                    width: volley.width,
                    peak: PEAK,
                    at,
                    until: at + volley.length,
                })
                .collect();
            let update = self.guard.admit(at, board, &stimuli, |entry| {
                limited += u64::from(entry.reason.is_some());
            });
            black_box(update);
            let mut ends: Vec<Instant> = stimuli.iter().map(|s| s.until).collect();
            ends.sort_unstable();
            for until in ends {
                black_box(self.guard.expire(until, board));
            }
        }
        limited
    }

    fn measure(&mut self, contacts: usize, onsets: u64) -> (Vec<Measured>, u64) {
        let mut all: Vec<Measured> = (0..=self.laws.len()).map(|_| <_>::default()).collect();
        let limited = (0..onsets)
            .map(|n| self.onset(contacts, n >= onsets / 10, &mut all))
            .sum();
        (all, limited)
    }
}

/// Times an onset of the renderer and of every published law.
///
/// # Errors
/// Fixtures that do not fit together.
pub fn measure() -> Result<Findings, Failure> {
    let mut found = Findings::new("render");
    let mut limited = 0;
    for (display, target_us) in [display("thimble-8")?, many()?].into_iter().zip(TARGETS_US) {
        let wires = display.wires().len();
        for contacts in CONTACTS {
            let mut rig = Rig::new(display.clone())?;
            let (all, changed) = rig.measure(contacts, ONSETS);
            limited += changed;
            let names = ["default"].into_iter().chain(rig.laws.iter().map(|l| l.0));
            let case = match contacts {
                1 => format!("{wires} wires, one contact"),
                n => format!("{wires} wires, {n} contacts"),
            };
            for (name, measured) in names.zip(&all) {
                // Several contacts have no one place.
                let error = match contacts {
                    1 => measured.misses.error(),
                    _ => crate::findings::NO_ERROR,
                };
                found.row(&case, name, error, measured.us.median());
            }
            if contacts == 1 {
                found.target(&format!("renderer, {case}"), all[0].us.median(), target_us);
            }
        }
    }
    found.words.push(format!(
        "default is the whole renderer of `inverse`, the guard's budgets read; the others are laws alone, with as many pulses \
         on each wire. Wires are linear, contacts lie inside the array. The guard changed {limited} of the renderer's stimuli."
    ));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_renderer_is_nearer_than_every_published_law_and_the_guard_changes_nothing() {
        for array in [display("thimble-8").unwrap(), many().unwrap()] {
            let mut rig = Rig::new(array).unwrap();
            let (all, limited) = rig.measure(1, 400);
            assert_eq!(limited, 0);
            let ours = all[0].misses.error().0;
            for ((name, _), law) in rig.laws.iter().zip(&all[1..]) {
                let theirs = law.misses.error().0;
                assert!(ours < theirs, "{ours:.3} mm, {name} {theirs:.3} mm");
            }
        }
    }
}
