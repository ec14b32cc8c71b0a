//! A Peltier module under the fingertip of an emulated bench: the regulator's turns, what they come to, and what the wires'
//! guard is told of the face.

use palpate_core::driver::Actuators;
use palpate_core::peltier::{LIMITS, PeltierReason, Regulator, UNCERTAINTY_K, Wanted};
use palpate_core::physics::Thermistor;
use palpate_core::projector::Projector;
use palpate_core::units::{Duration, Instant};
use palpate_emulators::display::peltier::Peltier;
use palpate_emulators::time::Nanos;
use palpate_files::{SKIN_C, SceneMaterial, Setup, warmth_c};
use palpate_records::margin::{Limited, Margin};
use palpate_records::trace::Event;
use serde::Serialize;

use crate::recorder::milli_c;

/// Between two records of the module.
const RECORD: Duration = Duration::from_millis(100);

/// What came of a Peltier module.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys say what they are, with their units
pub struct HeatReport {
    pub coldest_face_c: f64,
    pub warmest_face_c: f64,
    pub warmest_sink_c: f64,
    pub fastest_ramp_k_s: f64,
    /// How far the face was from what it was to be, root mean square over all turns that drove it; null for none.
    pub error_k: Option<f64>,
    pub energy_j: f64,
    /// Turns of the regulator, a hundred a second.
    pub turns: u64,
    /// Turns in which its guard let less flow than was asked for.
    pub held_back: u64,
    /// Times that a sensor switched it off.
    pub stops: u32,
    /// Whether the thermostat cut it.
    pub thermostat: bool,
}

impl HeatReport {
    /// In a line.
    #[must_use]
    pub fn words(&self) -> String {
        let error = self
            .error_k
            .map_or("-".to_owned(), |k| format!("{k:.2} K RMSE"));
        let cut = match self.thermostat {
            true => ", CUT by its thermostat",
            false => "",
        };
        format!(
            "face {:.1} to {:.1} C, {error} from what it aims at, {:.1} K/s at most; sink {:.1} C at most; {:.1} J; {} of {} turns held back, {} stops{cut}",
            self.coldest_face_c,
            self.warmest_face_c,
            self.fastest_ramp_k_s,
            self.warmest_sink_c,
            self.energy_j,
            self.held_back,
            self.turns,
            self.stops
        )
    }
}

/// An emulated module and what regulates it.
pub(crate) struct EmulatedHeat {
    module: Peltier,
    regulator: Regulator,
    materials: Vec<SceneMaterial>,
    /// What aims were missed by, K2, and in how many turns.
    missed: (f64, u64),
    turns: u64,
    held_back: u64,
    stops: u32,
    /// What is known to be off, and why.
    told: Option<PeltierReason>,
    told_cut: bool,
    recorded: Option<Instant>,
}

impl EmulatedHeat {
    /// The module of a setup's bench, if it has one.
    pub(crate) fn of(setup: &Setup) -> Option<Self> {
        let heat = setup.bench.value.heat?;
        let (parameters, thermistor) = (heat.parameters(), Thermistor::default());
        Some(Self {
            module: Peltier::new(parameters, thermistor, heat.air_c),
            regulator: Regulator::new(parameters, thermistor),
            materials: setup.scene.value.materials.clone(),
            missed: (0.0, 0),
            turns: 0,
            held_back: 0,
            stops: 0,
            told: None,
            told_cut: false,
            recorded: None,
        })
    }

    /// Lets time pass until `until`.
    pub(crate) fn advance(&mut self, until: Nanos) {
        self.module.advance(until);
    }

    /// The module, for what breaks it.
    pub(crate) const fn module(&mut self) -> &mut Peltier {
        &mut self.module
    }

    /// The face on the skin, degrees C.
    pub(crate) fn face_c(&self) -> f64 {
        self.module.state().face_c
    }

    /// A turn of the regulator, where one is due: what the wires bear, the current, the record.
    pub(crate) fn turn(
        &mut self,
        now: Instant,
        projector: &mut Projector,
        events: &mut Vec<Event>,
    ) {
        if now < self.regulator.next() {
            return;
        }
        self.regulator.see(now, &self.module.reading());
        let wanted_c = warmth_c(&self.materials, now.as_micros() as f64 * 1e-6);
        // The wires make room for what is wanted; what they have booked already, the face makes room for.
        let reserved_c = (wanted_c + UNCERTAINTY_K).min(LIMITS.face_c[1]);
        let bears_c = projector.warm(now, self.regulator.warmest_c(), reserved_c);
        let stopped = projector.guard().latched().is_some();
        let wanted = (!stopped).then_some(Wanted {
            face_c: wanted_c,
            ceiling_c: bears_c - UNCERTAINTY_K,
        });
        let turned = self.regulator.turn(now, wanted);
        let Ok(()) = self.module.apply(&turned.update);
        self.turns += 1;
        if let Some(aim_c) = turned.aim_c {
            let error = self.face_c() - aim_c;
            self.missed = (self.missed.0 + error * error, self.missed.1 + 1);
            self.held_back += u64::from(turned.reason.is_some());
        }
        self.tell(
            now,
            turned.aim_c.is_none().then_some(turned.reason).flatten(),
            events,
        );
        if self.recorded.is_none_or(|at| now >= at + RECORD) {
            self.recorded = Some(now);
            let state = self.module.state();
            events.push(Event::Face {
                t_us: now.as_micros(),
                face_mc: milli_c(state.face_c).unwrap_or(i32::MAX),
                aim_mc: turned.aim_c.and_then(milli_c),
                sink_mc: milli_c(state.sink_c).unwrap_or(i32::MAX),
                milliamps: state.milliamps,
            });
        }
    }

    /// Says once that the module goes off, and that it goes on.
    fn tell(&mut self, now: Instant, off: Option<PeltierReason>, events: &mut Vec<Event>) {
        let mut note = |text: String| {
            events.push(Event::Note {
                t_us: now.as_micros(),
                text,
            });
        };
        if off != self.told {
            match off {
                Some(reason) => note(format!("Peltier module off: {}", reason.word())),
                None => note("Peltier module on again".to_owned()),
            }
            self.stops += u32::from(matches!(off, Some(PeltierReason::Sensor(_))));
            self.told = off;
        }
        if self.module.is_cut() && !self.told_cut {
            self.told_cut = true;
            note(format!(
                "Peltier module cut by its thermostat at {:.0} C",
                LIMITS.thermostat_c
            ));
        }
    }

    /// Nothing flows any more.
    pub(crate) fn off(&mut self) {
        let Ok(()) = self.module.all_off();
    }

    /// What came of it.
    pub(crate) fn report(&self) -> HeatReport {
        let peaks = self.module.peaks();
        let (sum, count) = self.missed;
        HeatReport {
            coldest_face_c: peaks.face_c[0],
            warmest_face_c: peaks.face_c[1],
            warmest_sink_c: peaks.sink_c,
            fastest_ramp_k_s: peaks.ramp_k_s,
            error_k: (count > 0).then(|| (sum / count as f64).sqrt()),
            energy_j: peaks.electrical_j,
            turns: self.turns,
            held_back: self.held_back,
            stops: self.stops,
            thermostat: self.module.is_cut(),
        }
    }

    /// Its limits and the worst that came of them.
    pub(crate) fn margins(&self) -> Vec<Margin> {
        let peaks = self.module.peaks();
        let [coldest, warmest] = LIMITS.face_c;
        let [heating, cooling] = peaks.milliamps.map(|ma| f64::from(ma) * 1e-3);
        [
            (Limited::FaceWarm, peaks.face_c[1], warmest),
            (
                Limited::FaceCold,
                SKIN_C - peaks.face_c[0],
                SKIN_C - coldest,
            ),
            (Limited::FaceRamp, peaks.ramp_k_s, LIMITS.ramp_k_s),
            (Limited::Sink, peaks.sink_c, LIMITS.sink_c),
            (
                Limited::PeltierCurrent,
                heating.max(cooling),
                LIMITS.heating_a.max(LIMITS.cooling_a),
            ),
        ]
        .map(|(of, worst, limit)| Margin::new(of, worst, limit))
        .into()
    }
}
