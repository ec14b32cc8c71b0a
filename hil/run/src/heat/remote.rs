//! A Peltier module that a driver unit regulates: the host's wishes, the face's temperature for its wires' guard, and
//! the unit's reports.

use palpate_core::codec::link::{Face, Warmth};
use palpate_core::driver::UnitDriver;
use palpate_core::peltier::{LIMITS, PERIOD, PeltierReason, UNCERTAINTY_K, Wanted};
use palpate_core::physics::PeltierParameters;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_emulators::display::peltier::electrical_w;
use palpate_files::{SKIN_C, SceneMaterial, Setup, warmth_c};
use palpate_records::trace::Event;

use super::report::{Account, HeatReport, Seen};

/// Tells the wires a face's temperature, and returns the wanted face with the ceiling that the wires leave it. `None`
/// while the guard is stopped.
pub(super) fn wanted(
    now: Instant,
    materials: &[SceneMaterial],
    warmest_c: f64,
    projector: &mut Projector,
) -> Option<Wanted> {
    let face_c = warmth_c(materials, now.as_micros() as f64 * 1e-6);
    // The wires make room for the wanted face; the face makes room for heat that the wires have booked already.
    let reserved_c = (face_c + UNCERTAINTY_K).min(LIMITS.face_c[1]);
    let bears_c = projector.warm(now, warmest_c, reserved_c);
    let stopped = projector.guard().latched().is_some();
    (!stopped).then_some(Wanted {
        face_c,
        ceiling_c: bears_c - UNCERTAINTY_K,
    })
}

/// The host's part in heat that a driver unit regulates.
pub struct RemoteHeat {
    materials: Vec<SceneMaterial>,
    parameters: PeltierParameters,
    account: Account,
    /// Time of the next turn.
    next: Instant,
    /// The unit's report that was taken in last, and when, by the unit's clock.
    newest: Option<(Instant, Face)>,
    /// Extremes over the unit's reports so far.
    seen: HeatReport,
    /// Time and temperature of a face at least a tenth of a second ago, for the ramp.
    before: Option<(Instant, f64)>,
}

/// Degrees C of the link's millidegrees.
fn celsius(mc: u16) -> f64 {
    f64::from(mc) * 1e-3
}

impl RemoteHeat {
    /// The host's part for a setup; `None` where its bench has no module.
    #[must_use]
    pub fn find(setup: &Setup) -> Option<Self> {
        Some(Self {
            materials: setup.scene.value.materials.clone(),
            parameters: setup.bench.value.heat?.parameters(),
            account: Account::default(),
            next: Instant::ZERO,
            newest: None,
            seen: HeatReport {
                coldest_face_c: SKIN_C,
                warmest_face_c: SKIN_C,
                ..HeatReport::default()
            },
            before: None,
        })
    }

    /// Takes a turn, where one is due: tells the wires' guard the face's temperature, and the unit the wanted face.
    pub fn turn(
        &mut self,
        now: Instant,
        driver: &mut UnitDriver,
        projector: &mut Projector,
        events: &mut Vec<Event>,
    ) {
        if now < self.next {
            return;
        }
        self.next = now + PERIOD;
        let report = driver.status().map(|s| (s.now, s.face));
        let Some((report, age)) = report.zip(driver.status_age(now)) else {
            driver.warm(None);
            return;
        };
        // The face may have warmed since the report. The thermostat bounds it, also for a unit without a module.
        let since_k = LIMITS.ramp_k_s * age.as_secs_f64();
        let warmest_c = (celsius(report.1.warmest_mc) + since_k).min(LIMITS.thermostat_c);
        let wanted = wanted(now, &self.materials, warmest_c, projector);
        driver.warm(wanted.map(|wanted| Warmth {
            face_mc: (wanted.face_c * 1e3).round() as u16, // the cast saturates
            ceiling_mc: (wanted.ceiling_c * 1e3) as u16,
        }));
        self.take(now, report, events);
    }

    /// Takes a report of the unit in, once.
    fn take(&mut self, now: Instant, report: (Instant, Face), events: &mut Vec<Event>) {
        let (at, face) = report;
        let last = self.newest.replace(report);
        if last.is_some_and(|(before, _)| at <= before) || face.warmest_mc == 0 {
            return;
        }
        // Where no sensor tells it: no colder and no warmer than it can be.
        let face_c = celsius(if face.face_mc > 0 {
            face.face_mc
        } else {
            face.warmest_mc
        });
        let sink_c = celsius(face.sink_mc);
        let seen = &mut self.seen;
        seen.coldest_face_c = seen.coldest_face_c.min(face_c);
        seen.warmest_face_c = seen.warmest_face_c.max(face_c);
        seen.warmest_sink_c = seen.warmest_sink_c.max(sink_c);
        if let Some((before, _)) = last {
            let amps = f64::from(face.milliamps) * 1e-3;
            let watts = electrical_w(&self.parameters, face_c, sink_c, amps).max(0.0);
            seen.energy_j += watts * at.since(before).as_secs_f64();
        }
        let (then, before_c) = *self.before.get_or_insert((at, face_c));
        let passed_s = at.since(then).as_secs_f64();
        if passed_s >= 0.1 {
            let ramp = (face_c - before_c).abs() / passed_s;
            seen.fastest_ramp_k_s = seen.fastest_ramp_k_s.max(ramp);
            self.before = Some((at, face_c));
        }
        let turn = Seen {
            face_c,
            sink_c,
            milliamps: face.milliamps.into(),
            aim_c: self.said().0,
            reason: face.reason,
        };
        self.account.take(now, &turn, events);
    }

    /// Temperature of the face by the unit's newest report, degrees C.
    pub fn face_c(&self) -> Option<f64> {
        let (_, face) = self.newest?;
        (face.face_mc > 0).then(|| celsius(face.face_mc))
    }

    /// Report of the module, by the unit's sensors.
    pub fn report(&self) -> HeatReport {
        let mut report = self.seen;
        self.account.fill(&mut report);
        report
    }

    /// Reports of the unit that were taken in.
    pub(super) fn turns(&self) -> u64 {
        self.account.turns()
    }

    /// Aim (degrees C) and reason of the unit's newest report.
    pub(super) fn said(&self) -> (Option<f64>, Option<PeltierReason>) {
        let face = self.newest.map_or_else(Face::default, |(_, face)| face);
        ((face.aim_mc > 0).then(|| celsius(face.aim_mc)), face.reason)
    }
}
