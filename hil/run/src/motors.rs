//! The display end of a bench of motors: drivers behind a bus or a sound card, and the motors on a person's finger, in virtual
//! time.

use embedded_hal::i2c::I2c;
use palpate_core::codec::drv2605::{ADDRESS, RTP_INPUT};
use palpate_core::driver::{Actuators, Audio, Driver, Haptics};
use palpate_core::guard::{Guard, GuardedVibration, MotorLimits, Plant};
use palpate_core::projector::Projector;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Duration, Instant, Milliamps, Ticks};
use palpate_emulators::display::i2c::fault::{I2cFault, I2cFaults, Shared};
use palpate_emulators::display::i2c::{Error, I2cHandle};
use palpate_emulators::haptic::card::CardHandle;
use palpate_emulators::motors::{LOOK, MotorPlace, WornMotors};
use palpate_emulators::person::channels::Felt;
use palpate_emulators::time::Nanos;
use palpate_files::{BenchHaptics, Drive, Setup};
use palpate_records::i2c::Transfer;
use palpate_records::margin::{Limited, Margin};
use palpate_records::trace::Event;
use serde::Serialize;

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
use crate::{Keep, Sound};

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

/// Stands in for that line on a sound card, which is silent once it has no samples.
struct NoSamples;

impl OutputEnable for NoSamples {
    fn set_enabled(&self, _now: Instant, _enabled: bool) {}

    fn cuts(&self) -> bool {
        true
    }

    fn words(&self) -> &'static str {
        "outputs silent: the sound card has no samples"
    }
}

/// Driver of the motors or coils of a bench.
enum MotorDriver {
    /// DRV2605L chips on a bus.
    Chips(Haptics<Shared<I2cHandle>>),
    /// Channels of a sound card.
    Card(Audio<CardHandle>),
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
pub struct EmulatedMotors {
    worn: WornMotors,
    i2c: Shared<I2cHandle>,
    driver: MotorDriver,
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
        let places = motors::places(setup, haptics);
        let (mut worn, card) = motors::worn(haptics, &places).map_err(|e| bad(e.to_string()))?;
        let person = motors::wearer(setup, haptics);
        worn.worn_by(person).map_err(|e| bad(e.to_string()))?;
        let layer = I2cFault::new(worn.bus(), I2cFaults::default(), seed, "actuator bus");
        let i2c = Shared::new(layer);
        let driver = match card {
            Some(card) => MotorDriver::Card(card),
            None => {
                // The drivers wake before the run begins.
                worn.advance(AWAKE).map_err(|e| bad(e.to_string()))?;
                let chips = Haptics::new(i2c.clone(), &motors::channels(haptics));
                MotorDriver::Chips(chips.map_err(|e| bad(e.to_string()))?)
            }
        };
        Ok(Self {
            drive: bench.drive,
            place: Place::whole(bench),
            i2c,
            driver,
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
            Margin::new(
                Limited::MotorVoltage,
                totals.drive_v,
                motors::peak_v(haptics),
            ),
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
        let passed = match &mut self.driver {
            MotorDriver::Chips(_) => self.worn.advance(until),
            MotorDriver::Card(card) => play(card, &mut self.worn, until),
        };
        passed.map_err(|e| Failure::Device(e.to_string()))
    }

    pub(crate) fn score(&mut self, projector: &Projector, recorder: &mut Recorder) {
        let felt: Option<Felt> = self.worn.onset();
        let pending = self.pending.take();
        feel(pending, felt, projector, &self.full, recorder, None);
    }
}

impl DisplayEnd for EmulatedMotors {
    type Update = GuardedVibration;

    fn parts(&mut self) -> (&mut dyn Driver<GuardedVibration>, &dyn OutputEnable) {
        match &mut self.driver {
            MotorDriver::Chips(chips) => (chips, &NoLine),
            MotorDriver::Card(card) => (card, &NoSamples),
        }
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
                motors: Some(&mut self.worn),
            }),
        };
        self.script.step(now, last, &mut bench, events);
    }

    fn next_fault(&self) -> Instant {
        self.script.next()
    }

    fn keep(&mut self, keep: Keep) -> Result<(), Failure> {
        if let (Some(coils), true) = (self.worn.coils_mut(), keep.audio) {
            coils.card().card().keep();
        }
        if keep.i2c {
            let kept = self.worn.bus().with(|bus| bus.keep_log(I2C_LOG));
            kept.map_err(|e| Failure::Device(format!("actuator bus: {e}")))?;
        }
        Ok(())
    }

    fn take_sound(&mut self) -> Option<Sound> {
        let audio = self.haptics.audio.as_ref()?;
        let coils = self.worn.coils_mut()?;
        let samples = coils.card().card().take_played();
        Some(Sound {
            rate_hz: audio.rate_hz,
            channels: coils.width(),
            samples,
        })
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

/// Lets a sound card play until a time: its driver stays a look ahead, so that it never runs dry.
fn play(card: &mut Audio<CardHandle>, worn: &mut WornMotors, until: Nanos) -> Result<(), Error> {
    while worn.now() < until {
        let end = until.min(worn.now() + LOOK);
        card.render(Instant::from_micros(end.0 / 1000));
        worn.advance(end)?;
    }
    Ok(())
}

/// Felt energy of one motor at its highest level for a stimulus, alone and from rest, um2 s; `None` for a driver that does
/// not start.
fn full_energy(setup: &Setup, haptics: &BenchHaptics, projector: &Projector) -> Option<f64> {
    let mut haptics = haptics.clone();
    if let Some(audio) = &mut haptics.audio {
        audio.channels.truncate(1);
    }
    let place = MotorPlace {
        at_mm: (0.0, 0.0),
        behind: None,
    };
    let (mut alone, card) = motors::worn(&haptics, &[place]).ok()?;
    alone.worn_by(motors::wearer(setup, &haptics)).ok()?;
    let length = projector.timing().duration;
    match card {
        Some(card) => play_once(card, &mut alone, &haptics, projector)?,
        None => {
            let mut channel = *motors::channels(&haptics).first()?;
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
            let end = begin + Nanos::from_micros(length.as_micros());
            alone.advance(end).ok()?;
            bus.write(ADDRESS, &[RTP_INPUT, 0]).ok()?;
            alone.advance(end + REST).ok()?;
        }
    }
    Some(alone.onset()?.energy)
}

/// Plays a stimulus of the highest level on the first channel of a card, past limits that nobody who wears it could have.
fn play_once(
    mut card: Audio<CardHandle>,
    alone: &mut WornMotors,
    haptics: &BenchHaptics,
    projector: &Projector,
) -> Option<()> {
    let length = projector.timing().duration;
    let (at, until) = (Instant::ZERO, Instant::ZERO + length);
    let limits = MotorLimits {
        travel_um: f64::MAX,
        rise_k: f64::MAX,
        burst: length + Duration::from_millis(1000),
        duty: 1.0,
        ..motors::limits(haptics)
    };
    let place = projector.display().wires().first()?;
    let (board, wire) = (place.board, 0);
    let table = *projector.guard().limits();
    let mut guard =
        Guard::of_motors(table, limits, Plant::default(), std::slice::from_ref(place)).ok()?;
    guard.hear(at);
    let stimulus = Stimulus {
        wire,
        width: Ticks::new(Ticks::PER_PERIOD),
        peak: Milliamps(0),
        at,
        until,
    };
    card.start(at).ok()?;
    let on = guard.admit_vibration(at, board, &[stimulus], |_| ())?;
    card.apply(&on).ok()?;
    play(&mut card, alone, Nanos::from(until)).ok()?;
    card.apply(&guard.expire_vibration(until, board)?).ok()?;
    play(&mut card, alone, Nanos::from(until) + REST).ok()
}

#[cfg(test)]
#[path = "motors_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "voice_coil_tests.rs"]
mod voice_coils;
