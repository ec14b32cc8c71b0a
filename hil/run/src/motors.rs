//! The display end of a bench of motors: drivers behind a bus, and the motors on a person's finger, in virtual time.

use embedded_hal::i2c::I2c;
use palpate_core::codec::drv2605::{ADDRESS, RTP_INPUT};
use palpate_core::driver::{Driver, Haptics};
use palpate_core::guard::GuardedVibration;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_emulators::display::i2c::I2cHandle;
use palpate_emulators::display::i2c::fault::{I2cFault, I2cFaults, Shared};
use palpate_emulators::motors::{MotorPlace, WornMotors};
use palpate_emulators::person::channels::Felt;
use palpate_emulators::time::Nanos;
use palpate_files::{BenchHaptics, Drive, Setup};
use palpate_records::i2c::Transfer;
use palpate_records::margin::{Limited, Margin};
use palpate_records::trace::Event;
use serde::Serialize;

use crate::Keep;
use crate::boards;
use crate::display_end::{DisplayEnd, I2C_LOG};
use crate::effects::{Faultable, FaultyDisplay};
use crate::failure::Failure;
use crate::feel::{FullDrive, feel};
use crate::output_enable::OutputEnable;
use crate::place::Place;
use crate::plan::motors;
use crate::recorder::{Onset, Recorder};
use crate::script::{FaultReport, Script};
use crate::skin_end::FaultySkin;

/// Time after power-on in which drivers wake.
const AWAKE: Nanos = Nanos::from_micros(1000);
/// Time in which a driven motor comes to rest.
const REST: Nanos = Nanos::from_micros(200_000);

/// Stands in for the line that cuts outputs: drivers of motors have none in common.
struct NoLine;

impl OutputEnable for NoLine {
    fn set_enabled(&self, _now: Instant, _enabled: bool) {}

    fn cuts(&self) -> bool {
        false
    }

    fn words(&self) -> &'static str {
        "no line cuts the motors: they shake on until the bus answers"
    }
}

/// Report of the motors of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotorReport {
    /// Kind of the motors.
    pub kind: &'static str,
    /// Largest amplitude of a face on the skin, um.
    pub face_um: f64,
    /// Largest rise of a coil over the air, K.
    pub coil_rise_k: f64,
    /// Daily exposure of the hand by ISO 5349-1 if nothing else shook it that day, m/s2.
    pub exposure_m_s2: f64,
    /// Hours of this until the action value of Directive 2002/44/EC; null for a hand at rest.
    pub action_h: Option<f64>,
}

impl MotorReport {
    /// Motion and heat in a line of a terminal.
    pub(crate) fn short(&self) -> String {
        format!(
            "{:.0} um at most; coil {:.1} K over the air",
            self.face_um, self.coil_rise_k
        )
    }

    /// Exposure in a line of a terminal.
    pub(crate) fn words(&self) -> String {
        let hours = match self.action_h {
            Some(hours) if hours < 24.0 => format!("after {hours:.1} h of it"),
            _ => "not in a day of it".to_owned(),
        };
        format!(
            "A(8) {:.2} m/s2; action value 2.5 {hours}",
            self.exposure_m_s2
        )
    }
}

/// Drivers and motors on a person's finger.
pub(crate) struct EmulatedMotors {
    worn: WornMotors,
    i2c: Shared<I2cHandle>,
    driver: Haptics<Shared<I2cHandle>>,
    drive: Drive,
    place: Place,
    haptics: BenchHaptics,
    script: Script,
    /// The onset whose stimulus is still felt.
    pending: Option<Onset>,
    full: FullDrive,
}

impl EmulatedMotors {
    /// Motors of a setup at rest.
    ///
    /// # Errors
    /// [`Failure::Input`] for a bench that cannot be.
    pub(crate) fn new(
        setup: &Setup,
        haptics: &BenchHaptics,
        projector: &Projector,
        seed: u64,
    ) -> Result<Self, Failure> {
        let bench = &setup.bench.value;
        let bad = |e: String| Failure::Input(format!("bench `{}`: {e}", bench.name));
        let (motor, contact) = (motors::motor(haptics), motors::contact(haptics));
        let mut worn = WornMotors::new(&motor, contact, &motors::places(setup, haptics));
        let person = motors::wearer(setup, haptics);
        worn.worn_by(person).map_err(|e| bad(e.to_string()))?;
        // The drivers wake before the run begins.
        worn.advance(AWAKE).map_err(|e| bad(e.to_string()))?;
        let layer = I2cFault::new(worn.bus(), I2cFaults::default(), seed, "actuator bus");
        let i2c = Shared::new(layer);
        let driver = Haptics::new(i2c.clone(), &motors::channels(haptics));
        Ok(Self {
            drive: bench.drive,
            place: Place::whole(bench),
            i2c,
            driver: driver.map_err(|e| bad(e.to_string()))?,
            // A driver that does not start here does not start in the run either, which says so.
            full: FullDrive::with_energy(
                full_energy(setup, haptics, projector).unwrap_or(0.0),
                projector,
            ),
            script: Script::new(&setup.scene.value.faults, projector.layout()),
            haptics: haptics.clone(),
            pending: None,
            worn,
        })
    }

    /// Every limit of the motors, and the worst that came behind the guard.
    pub(crate) fn margins(&self) -> Vec<Margin> {
        let (totals, haptics) = (self.worn.totals(), &self.haptics);
        vec![
            Margin::new(Limited::MotorVoltage, totals.drive_v, haptics.overdrive_v),
            Margin::new(Limited::MotorTravel, totals.contactor_um, haptics.travel_um),
            Margin::new(Limited::CoilRise, totals.coil_rise_k, haptics.coil_rise_k),
        ]
    }

    /// Report of a run of this length.
    pub(crate) fn report(&self, length: Instant) -> MotorReport {
        let (totals, exposure) = (self.worn.totals(), self.worn.exposure());
        let until_s = exposure.until_action_s(length.as_micros() as f64 * 1e-6);
        MotorReport {
            kind: self.haptics.kind.name(),
            face_um: totals.contactor_um,
            coil_rise_k: totals.coil_rise_k,
            exposure_m_s2: exposure.daily_m_s2(),
            action_h: until_s.is_finite().then_some(until_s / 3600.0),
        }
    }

    fn pass(&mut self, until: Nanos) -> Result<(), Failure> {
        let passed = self.worn.advance(until);
        passed.map_err(|e| Failure::Device(e.to_string()))
    }

    fn score(&mut self, projector: &Projector, recorder: &mut Recorder) {
        let felt: Option<Felt> = self.worn.onset();
        let pending = self.pending.take();
        feel(pending, felt, projector, &self.full, recorder, None);
    }
}

impl DisplayEnd for EmulatedMotors {
    type Update = GuardedVibration;

    fn parts(&mut self) -> (&mut dyn Driver<GuardedVibration>, &dyn OutputEnable) {
        (&mut self.driver, &NoLine)
    }

    fn take_transfers(&mut self) -> Vec<Transfer> {
        boards::transfers(&self.worn.bus(), 0)
    }

    fn advance_to(&mut self, now: Instant, _events: &mut Vec<Event>) -> Result<(), Failure> {
        self.pass(Nanos::from(now))
    }

    fn look(&mut self, _now: Instant, onset: bool, projector: &Projector, recorder: &mut Recorder) {
        if onset {
            self.score(projector, recorder);
            self.pending = recorder.onset.take();
        }
    }

    fn fail(&mut self, now: Instant, last: bool, skin: FaultySkin<'_>, events: &mut Vec<Event>) {
        let mut bench = Faultable {
            skin,
            display: Some(FaultyDisplay {
                i2c: &self.i2c,
                chips: self.worn.bus(),
                worn: None,
                drive: self.drive,
                place: &self.place,
                unit: None,
                heat: None,
                motors: Some(&self.worn),
            }),
        };
        self.script.step(now, last, &mut bench, events);
    }

    fn next_fault(&self) -> Instant {
        self.script.next()
    }

    fn keep(&mut self, keep: Keep) -> Result<(), Failure> {
        if keep.i2c {
            let kept = self.worn.bus().with(|bus| bus.keep_log(I2C_LOG));
            kept.map_err(|e| Failure::Device(format!("actuator bus: {e}")))?;
        }
        Ok(())
    }

    fn faults(&self) -> Vec<FaultReport> {
        self.script.report()
    }

    fn settle(
        &mut self,
        end: Instant,
        projector: &Projector,
        recorder: &mut Recorder,
    ) -> Result<(), Failure> {
        self.score(projector, recorder);
        self.pass(Nanos::from(end) + REST)
    }
}

/// Felt energy of one motor at its highest level for a stimulus, alone and from rest, um2 s; `None` for a driver that does
/// not start.
fn full_energy(setup: &Setup, haptics: &BenchHaptics, projector: &Projector) -> Option<f64> {
    let place = MotorPlace {
        at_mm: (0.0, 0.0),
        behind: None,
    };
    let (motor, contact) = (motors::motor(haptics), motors::contact(haptics));
    let mut alone = WornMotors::new(&motor, contact, &[place]);
    alone.worn_by(motors::wearer(setup, haptics)).ok()?;
    let mut channel = *motors::channels(haptics).first()?;
    channel.behind = None;
    alone.advance(AWAKE).ok()?;
    let mut driver = Haptics::new(alone.bus(), &[channel]).ok()?;
    let ready = driver.start(Instant::ZERO).ok()?;
    let begin = AWAKE + Nanos::from(ready);
    alone.advance(begin).ok()?;
    alone.onset();
    // An emulated chip of its own, which nobody wears, needs no guard.
    let mut bus = alone.bus();
    bus.write(ADDRESS, &[RTP_INPUT, GuardedVibration::FULL])
        .ok()?;
    let end = begin + Nanos::from_micros(projector.timing().duration.as_micros());
    alone.advance(end).ok()?;
    bus.write(ADDRESS, &[RTP_INPUT, 0]).ok()?;
    alone.advance(end + REST).ok()?;
    Some(alone.onset()?.energy)
}

#[cfg(test)]
#[path = "motors_tests.rs"]
mod tests;
