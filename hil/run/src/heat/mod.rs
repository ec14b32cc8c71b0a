//! A Peltier module under the fingertip of an emulated bench: the regulator's turns, their report, and the face's
//! temperature for the wires' guard. A driver unit regulates its module by itself.

mod remote;
mod report;

use palpate_core::driver::Actuators;
use palpate_core::peltier::{LIMITS, Regulator};
use palpate_core::physics::Thermistor;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_emulators::display::peltier::{Peltier, PeltierHandle};
use palpate_emulators::time::Nanos;
use palpate_files::{SKIN_C, SceneMaterial, Setup};
use palpate_records::margin::{Limited, Margin};
use palpate_records::trace::Event;

use crate::unit::RemoteUnit;
pub use remote::RemoteHeat;
pub use report::HeatReport;
use report::{Account, Seen};

/// Regulation of a Peltier module, by host or unit.
enum Regulated {
    /// The host itself, by the scene's materials.
    Here(Box<Regulator>, Vec<SceneMaterial>),
    /// A driver unit; the host asks for a face.
    ByUnit(Box<RemoteHeat>),
}

/// An emulated module and its regulator.
pub(crate) struct EmulatedHeat {
    module: PeltierHandle,
    /// Regulator that a driver unit gets for the module.
    regulator: Regulator,
    regulated: Regulated,
    account: Account,
    told_cut: bool,
}

impl EmulatedHeat {
    /// The module of a setup's bench, if it has one.
    pub(crate) fn find(setup: &Setup) -> Option<Self> {
        let heat = setup.bench.value.heat?;
        let (parameters, thermistor) = (heat.parameters(), Thermistor::default());
        let regulator = Regulator::new(parameters, thermistor);
        let materials = &setup.scene.value.materials;
        Some(Self {
            module: PeltierHandle::new(Peltier::new(parameters, thermistor, heat.air_c)),
            regulated: match setup.bench.value.unit {
                None => Regulated::Here(Box::new(regulator.clone()), materials.clone()),
                Some(_) => Regulated::ByUnit(Box::new(RemoteHeat::find(setup)?)),
            },
            regulator,
            account: Account::default(),
            told_cut: false,
        })
    }

    /// Module and regulator that a driver unit works with; `None` where the host regulates.
    pub(crate) fn lent(&self) -> Option<(PeltierHandle, Regulator)> {
        let by_unit = matches!(self.regulated, Regulated::ByUnit(_));
        by_unit.then(|| (self.module.clone(), self.regulator.clone()))
    }

    /// Lets time pass until `until`.
    pub(crate) fn advance(&mut self, until: Nanos) {
        self.module.with(|module| module.advance(until));
    }

    /// The module, for faults that break it.
    pub(crate) fn module(&self) -> PeltierHandle {
        self.module.clone()
    }

    /// The face on the skin, degrees C.
    pub(crate) fn face_c(&self) -> f64 {
        self.module.with(|module| module.state().face_c)
    }

    /// Takes a turn of the regulator, where one is due: the wires' heat, the current, the record.
    pub(crate) fn turn(
        &mut self,
        now: Instant,
        projector: &mut Projector,
        unit: Option<&mut RemoteUnit>,
        events: &mut Vec<Event>,
    ) {
        let (aim_c, reason) = match (&mut self.regulated, unit) {
            (Regulated::Here(regulator, materials), _) => {
                if now < regulator.next() {
                    return;
                }
                regulator.see(now, &self.module.with(|module| module.reading()));
                let warmest_c = regulator.warmest_c();
                let wanted = remote::wanted(now, materials, warmest_c, projector);
                let turned = regulator.turn(now, wanted);
                let Ok(()) = self.module.apply(&turned.update);
                (turned.aim_c, turned.reason)
            }
            (Regulated::ByUnit(host), Some(unit)) => {
                let before = host.turns();
                // The unit's notes tell of its reports; the record here is of the module itself.
                host.turn(now, unit.driver(), projector, &mut Vec::new());
                if host.turns() == before {
                    return;
                }
                host.said()
            }
            (Regulated::ByUnit(_), None) => return,
        };
        let (state, is_cut) = self.module.with(|module| (module.state(), module.is_cut()));
        let seen = Seen {
            face_c: state.face_c,
            sink_c: state.sink_c,
            milliamps: state.milliamps,
            aim_c,
            reason,
        };
        self.account.take(now, &seen, events);
        if is_cut && !self.told_cut {
            self.told_cut = true;
            let limit_c = LIMITS.thermostat_c;
            let text = format!("Peltier module cut by its thermostat at {limit_c:.0} C");
            events.push(Event::note(now, text));
        }
    }

    /// Switches the module off.
    pub(crate) fn off(&mut self) {
        let Ok(()) = self.module.all_off();
    }

    /// Report of the module so far.
    pub(crate) fn report(&self) -> HeatReport {
        let (peaks, thermostat) = self
            .module
            .with(|module| (*module.peaks(), module.is_cut()));
        let mut report = HeatReport {
            coldest_face_c: peaks.face_c[0],
            warmest_face_c: peaks.face_c[1],
            warmest_sink_c: peaks.sink_c,
            fastest_ramp_k_s: peaks.ramp_k_s,
            energy_j: peaks.electrical_j,
            thermostat,
            ..HeatReport::default()
        };
        self.account.fill(&mut report);
        report
    }

    /// Margins of the module: each limit and the worst value so far.
    pub(crate) fn margins(&self) -> Vec<Margin> {
        let peaks = self.module.with(|module| *module.peaks());
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
