//! What a law gives to feel, worked out without hardware in between: no guard, no history of heat.
//!
//! Laws are compared here, at one drive and by one person. What a run gives to feel on a bench, where limits
//! and warm wires count, is `run`'s.

use palpate_core::illusion::{
    Display, Drive, Illusion, IllusionError, Map, ModelSettings, Steps, build,
};
use palpate_core::physics::{Bow, TissueParameters, WireParameters};
use palpate_core::projector::sensor_area;
use palpate_core::units::{Milliamps, Point, Prescale, Ticks};
use palpate_emulators::person::channels::{Kick, Perceiver, Person};
use palpate_emulators::worn::START_C;
use palpate_records::felt::{FeltPath, FeltScore};
use palpate_records::trace::{Event, FeltAt, PlaceUm, event};

use palpate_files::{Setup, load_bench, load_person};
use palpate_run::Failure;
use palpate_run::plan;

/// The published drive: 100 of 4096 ticks at every level.
const DRIVE: Drive = Drive {
    alpha: 0.0,
    beta: 100.0 / 4096.0,
    floor: 1.0,
    steps: Steps::Even,
};
/// Pulses of a burst of 35 ms.
const PULSES: u8 = 7;
/// The chip's clock divider in a run.
const PRESCALE: Prescale = Prescale::new(30);
/// Time between onsets, microseconds.
pub const SOA_US: u64 = 58_500;
/// A contact this close to the display's hull counts as inside it, mm.
const HULL_MARGIN: f32 = 1e-3;

/// A display with a law on a person's finger, at a current.
#[derive(Debug)]
pub struct Worn {
    display: Display,
    law: Box<dyn Illusion>,
    person: Person,
    /// Displacement a tick of pulse width gives, um.
    um_per_tick: f64,
    activation: Vec<f32>,
}

/// What a path gave to feel.
#[derive(Clone, Copy, Debug)]
pub struct PathScore {
    /// By the energy and the amplitude centroid.
    pub felt: [FeltScore; 2],
    /// Least and most energy inside the display over one wire's, dB.
    pub energy_db: (f64, f64),
}

impl Worn {
    /// With a law of the core.
    ///
    /// # Errors
    /// [`IllusionError`] where the law does not fit the display.
    pub fn new(
        display: &Display,
        settings: &ModelSettings,
        person: Person,
        current: Milliamps,
    ) -> Result<Self, IllusionError> {
        let wire = WireParameters::FINAL;
        let amps = f64::from(current.0) * 1e-3;
        let tick_s = PRESCALE.tick_ns() as f64 * 1e-9;
        let bow = Bow::new(&wire, &TissueParameters::DEFAULT).map_or(0.0, |bow| bow.gain);
        let um_per_kelvin = bow * wire.mechanics.expansion_martensite * wire.length_m * 1e6;
        let joules = amps * amps * wire.resistance_ohm * tick_s * wire.wire_share;
        Ok(Self {
            law: build(display, settings)?,
            activation: vec![0.0; display.wires().len()],
            display: display.clone(),
            um_per_tick: joules / wire.heat_capacity() * um_per_kelvin,
            person,
        })
    }

    /// Activations for a contact, by wire.
    pub fn activate(&mut self, at: Point) -> &[f32] {
        self.law.activate(at, &mut self.activation);
        &self.activation
    }

    /// Lets a person meet the stimulus of a contact, each wire touching the skin by `touch(wire)`: the same pulses on every
    /// wire, of which only the energy is known, so the tissue is lifted by each at once and sinks back.
    fn meet(&mut self, perceiver: &mut Perceiver, at: Point, touch: impl Fn(usize) -> f64) {
        self.law.activate(at, &mut self.activation);
        let period_s = PRESCALE.period_ns() as f64 * 1e-9;
        for (wire, &a) in self.activation.iter().enumerate() {
            let um = touch(wire) * self.um_per_tick * f64::from(DRIVE.width(a).get());
            let kick = |n: u8| Kick {
                at_s: f64::from(n) * period_s,
                um,
            };
            let kicks: Vec<Kick> = (0..PULSES).map(kick).collect();
            perceiver.kicks(wire, &kicks, SOA_US as f64 * 1e-6);
        }
        perceiver.settle();
    }

    /// The onsets of a path, which a person begins to feel at rest.
    ///
    /// # Errors
    /// A person that cannot be, by the name of what is wrong.
    pub fn follow(
        &mut self,
        path: &[Point],
        touch: impl Fn(usize, f64) -> f64,
    ) -> Result<Vec<event::Felt>, Failure> {
        let wires = self.display.wires().iter();
        let places: Vec<_> = wires
            .map(|w| (f64::from(w.place.x), f64::from(w.place.y)))
            .collect();
        let mut perceiver =
            Perceiver::new(self.person, &places).map_err(|e| Failure::Input(e.to_string()))?;
        let place = |(x, y): (f64, f64)| PlaceUm::from(Point::new(x as f32, y as f32));
        let mut onset = |(k, &at): (u64, &Point)| {
            let t_us = k * SOA_US;
            perceiver.onset();
            self.meet(&mut perceiver, at, |wire| touch(wire, t_us as f64 * 1e-6));
            let met = perceiver.felt(START_C);
            event::Felt {
                t_us,
                target: PlaceUm::from(at),
                inside: self.display.contains(at, HULL_MARGIN),
                met: met.map(|met| FeltAt {
                    energy: place(met.energy_mm),
                    amplitude: place(met.amplitude_mm),
                    level_mdb: (met.levels.db() * 1e3).round() as i32,
                    tap: met.tap(),
                }),
                ..event::Felt::default()
            }
        };
        Ok((0..).zip(path).map(&mut onset).collect())
    }

    /// The score of a path with even contact.
    ///
    /// # Errors
    /// As [`Worn::follow`].
    pub fn score(&mut self, path: &[Point]) -> Result<PathScore, Failure> {
        let onsets = self.follow(path, |_, _| 1.0)?;
        let wires: Vec<PlaceUm> = self
            .display
            .wires()
            .iter()
            .map(|w| PlaceUm::from(w.place))
            .collect();
        let full = f64::from(DRIVE.width(1.0).get());
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let inside = path.iter().zip(&onsets).filter(|(_, onset)| onset.inside);
        for (&at, _) in inside {
            self.law.activate(at, &mut self.activation);
            let ticks = |&a: &f32| f64::from(Ticks::get(DRIVE.width(a))) / full;
            let energy: f64 = self.activation.iter().map(|a| ticks(a).powi(2)).sum();
            let db = 10.0 * energy.max(1e-6).log10();
            (least, most) = (least.min(db), most.max(db));
        }
        let mut felt = FeltPath::on(&wires, SOA_US);
        onsets
            .iter()
            .for_each(|onset| felt.add(&Event::Felt(*onset)));
        Ok(PathScore {
            felt: felt.scores(),
            energy_db: (least, most),
        })
    }
}

/// The scenes whose paths the thesis's figure 5.5 shows.
pub const PATHS: [&str; 4] = [
    "sphere-along",
    "sphere-across",
    "sphere-diagonal",
    "sphere-circle",
];

/// Where a scene's sphere is at each onset, mapped onto a display.
///
/// # Errors
/// [`Failure`] where scene and display do not fit.
pub fn path_on(scene: &str, display: &Display) -> Result<Vec<Point>, Failure> {
    let setup = Setup::load(scene, "emulated")?;
    let layout = plan::layout(&setup.sensor.value)?;
    let value = &setup.scene.value;
    let area = sensor_area(&layout, value.drives, value.compression.scope);
    let map = Map::new(area, None, display.bounds())
        .map_err(|e| Failure::Input(format!("scene `{scene}`: {e}")))?;
    let onsets = (value.length_s * 1e6) as u64 / SOA_US;
    let at = |k: u64| {
        let touch = value
            .touches
            .iter()
            .find_map(|t| t.at((k * SOA_US) as f64 * 1e-6))?;
        Some(map.apply(Point::new(touch.x_mm as f32, touch.y_mm as f32)))
    };
    Ok((0..onsets).filter_map(at).collect())
}

/// The person of every headline, with [`Worn`]'s wires.
///
/// # Errors
/// [`Failure`] where the file cannot be read.
pub fn person() -> Result<Person, Failure> {
    let typical = load_person("typical")?.value;
    Ok(plan::person(
        &typical,
        &WireParameters::FINAL,
        &TissueParameters::DEFAULT,
    ))
}

/// The current of a shipped bench.
///
/// # Errors
/// [`Failure`] where the file cannot be read.
pub fn current(bench: &str) -> Result<Milliamps, Failure> {
    Ok(plan::milliamps(load_bench(bench)?.value.drive.current_ma))
}
