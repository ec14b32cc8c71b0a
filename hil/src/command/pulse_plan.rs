//! Pulse of `hil pulse`: the smallest one whose bursts the wearer feels by the wire's response, as a scene of a bench, and
//! the guard's answer to it.

use palpate_core::contact::Levels;
use palpate_core::guard::{Predicted, Used};
use palpate_core::projector::Projector;
use palpate_core::schedule::{Entry, Reason, Stimulus};
use palpate_core::units::{Duration, Instant, Ticks};
use palpate_files::{Bench, Loaded, Pass, Scene, Setup, Source, load_layout};
use palpate_live::real::Heat;
use palpate_run::plan::milliamps;
use palpate_run::{Failure, build, place};

use crate::cli::PulseArgs;

/// Time at which the wire is heated, s: the skin's boards are heard by then.
const BEFORE_S: f64 = 0.7;
/// Time that the pulse may still need to end, s.
const AFTER_S: f64 = 0.05;
/// Levels of a scene count from the wearer's threshold: at none above it lies the smallest pulse that is felt.
const FELT_DB: f64 = 0.0;
/// Reference frames, too many for the scene's length: a touch meanwhile makes no contact and heats nothing.
const NO_REFERENCE: u32 = 100_000;
/// Ticks of a PWM period.
const TICKS: f64 = 4096.0;
/// Length of a motor's burst, long enough for it to be felt by a hand that holds it.
const BUZZ: Duration = Duration::from_millis(60);

/// One pulse of one wire of a bench.
pub(super) struct PulsePlan {
    bench: Loaded<Bench>,
    layout: String,
    /// The display, of a bench of several.
    pub finger: Option<String>,
    /// The wire's number on its display.
    pub wire: u16,
    place_mm: [f64; 2],
    width: Ticks,
    length: Duration,
    /// Pulses in that time, one but where a bench's periods are shorter than a stimulus may be.
    pub pulses: u64,
    /// `true` where the wire's wearer is expected to feel bursts of such pulses.
    pub felt: bool,
}

/// The guard's answer to the pulse, with the heat and dose that are kept of earlier runs.
pub(super) struct Judged {
    /// Entry that the guard passes.
    pub entry: Entry,
    /// Rise of the coil that it predicts at the end of a motor's burst, and its limit, K; `None` for a wire.
    pub coil_k: Option<(f64, f64)>,
    /// Nominal width, us.
    pub width_us: f64,
    /// Duty: the share of a period.
    pub duty: f64,
    /// Energy that it is booked with, mJ.
    pub energy_mj: f64,
    /// The warmest skin that it predicts.
    pub predicted: Predicted,
    /// The share of each limit that is used once the pulse is over.
    pub used: Used,
}

/// Stimulus of a plan's scene.
enum Part {
    /// No pulse: the skin is heard.
    Silence,
    /// No pulse, by the law that knows from which width on a pulse is felt.
    Table,
    /// The pulse.
    Pulse,
}

impl PulsePlan {
    /// The smallest pulse of a wire whose bursts are felt on a bench; where its limits let none be felt, the widest that they pass.
    ///
    /// # Errors
    /// [`Failure::Input`] for a wire or display that the bench does not have, and what does not fit together.
    pub fn new(bench: Loaded<Bench>, args: &PulseArgs) -> Result<Self, Failure> {
        check_finger(&bench.value, args.finger.as_deref())?;
        let mut plan = Self {
            bench,
            layout: args.layout.clone(),
            finger: args.finger.clone(),
            wire: args.wire,
            place_mm: [0.0; 2],
            width: Ticks::ZERO,
            length: Duration::from_millis(1),
            pulses: 1,
            felt: true,
        };
        let own = alone(&plan.setup(&Part::Silence)?);
        let wires = &own.display.value.wires_mm;
        plan.place_mm = *wires.get(usize::from(args.wire)).ok_or_else(|| {
            let of = plan.finger.as_ref();
            let of = of.map_or_else(String::new, |name| format!(", display `{name}`"));
            Failure::Input(format!(
                "WIRE: expected a {} of bench `{}`{of}, 0 to {}, found {}",
                plan.actuator(),
                plan.bench.value.name,
                wires.len().saturating_sub(1),
                args.wire
            ))
        })?;
        if plan.bench.value.haptics.is_some() {
            plan.length = BUZZ;
            return Ok(plan);
        }
        let (projector, felt) = plan.table()?;
        plan.felt = felt;
        plan.width = match felt {
            true => projector.width(1.0).max(Ticks::new(1)),
            false => projector.guard().widest(),
        };
        let prescale = projector.guard().prescale();
        // Ticks of the table are ticks of the pulse.
        plan.bench.value.drive.pwm_hz = Some(prescale.hz());
        let half_ns = prescale.period_ns() / 2;
        // No stimulus of a scene is shorter than a millisecond. A channel goes off in the middle of its last pulse's period.
        let halves = 1_000_000_u64.div_ceil(half_ns).max(1);
        plan.pulses = halves / 2 + 1;
        plan.length = Duration::from_micros((2 * plan.pulses - 1) * half_ns / 1000);
        Ok(plan)
    }

    /// The loop whose table of responses says which pulse is felt, and whether any is.
    fn table(&self) -> Result<(Projector, bool), Failure> {
        let made = |part| build(&alone(&self.setup(&part)?), 1, Levels::Off);
        match made(Part::Table) {
            Ok(projector) => Ok((projector, true)),
            // Nothing is felt within the limits, or the law has no place for so few wires.
            Err(failure)
                if failure
                    .key()
                    .is_some_and(|key| key.starts_with("illusion.")) =>
            {
                Ok((made(Part::Silence)?, false))
            }
            Err(failure) => Err(failure),
        }
    }

    /// Word for an actuator of the bench.
    pub const fn actuator(&self) -> &'static str {
        match self.bench.value.haptics {
            Some(_) => "motor",
            None => "wire",
        }
    }

    /// The bench's name, and the display's where there are several.
    pub fn place(&self) -> String {
        let bench = format!("bench `{}`", self.bench.value.name);
        match &self.finger {
            Some(finger) => format!("{bench}, display `{finger}`"),
            None => bench,
        }
    }

    /// The scene that sends the pulse.
    ///
    /// # Errors
    /// [`Failure`] with what does not fit together.
    pub fn pulse(&self) -> Result<Setup, Failure> {
        self.setup(&Part::Pulse)
    }

    /// The pulse's setup without the pulse.
    ///
    /// # Errors
    /// The errors of [`Self::pulse`].
    pub fn silence(&self) -> Result<Setup, Failure> {
        self.setup(&Part::Silence)
    }

    fn setup(&self, part: &Part) -> Result<Setup, Failure> {
        let source = Source::new("the scene of a pulse", self.text(part)?);
        let scene: Loaded<Scene> = Loaded::read(source)?;
        let mut setup = Setup::join(scene, self.bench.clone())?;
        // One wire is to be heated, and no other.
        setup.pass = Pass::LeftOut;
        Ok(setup)
    }

    fn text(&self, part: &Part) -> Result<String, Failure> {
        let tau_s = self.length.as_secs_f64();
        let length_s = BEFORE_S + tau_s + AFTER_S;
        let mut text = format!(
            "name = \"pulse\"\ndescription = \"One pulse of one wire\"\nlength_s = {length_s:?}\nreference_frames = {NO_REFERENCE}\n"
        );
        text += &format!(
            "layout = {}\n",
            serde_json::Value::from(self.layout.as_str())
        );
        let [x, y] = self.place_mm;
        let stroke = format!(
            "start_s = {BEFORE_S:?}, length_s = {tau_s:?}, from_mm = [{x:?}, {y:?}], to_mm = [{x:?}, {y:?}]"
        );
        let strokes = match part {
            Part::Pulse => format!("strokes = [{{ {stroke} }}]\n"),
            Part::Silence | Part::Table => String::new(),
        };
        let illusion = match part {
            Part::Silence => "model = \"nearest\"".to_owned(),
            Part::Table => format!("model = \"inverse\"\nlevel_db = {FELT_DB:?}"),
            // A contact is a motor's highest level.
            Part::Pulse if self.bench.value.haptics.is_some() => {
                format!("model = \"nearest\"\ntau_d_ms = {:?}", tau_s * 1e3)
            }
            Part::Pulse => format!(
                "model = \"nearest\"\nbeta = {:?}\ntau_d_ms = {:?}",
                f64::from(self.width.get()) / TICKS,
                tau_s * 1e3
            ),
        };
        if self.finger.is_none() {
            text += &strokes;
        }
        text += &format!("[illusion]\n{illusion}\n");
        if let Some(finger) = &self.finger {
            let modules: Vec<usize> = (0..self.modules()?).collect();
            let rule = if modules.len() > 1 {
                "rule = \"first\"\n"
            } else {
                ""
            };
            let display = serde_json::Value::from(finger.as_str());
            text += &format!(
                "[[fingers]]\ndisplay = {display}\nmodules = {modules:?}\n{rule}{strokes}"
            );
        }
        Ok(text)
    }

    /// Number of the skin's modules.
    fn modules(&self) -> Result<usize, Failure> {
        Ok(match load_layout(&self.layout)?.value {
            palpate_files::LayoutFile::Sensor(sensor) => sensor.modules.len(),
            palpate_files::LayoutFile::Display(_) => 1,
        })
    }

    /// The guard's answer to the pulse, from the ledger's heat of hardware; an emulated bench is at rest.
    ///
    /// # Errors
    /// [`Failure::Guard`] where heat or dose cannot be read, the dose is spent, or nothing is left for a pulse.
    pub fn judged(&self) -> Result<Judged, Failure> {
        let mut own = alone(&self.pulse()?);
        if own.bench.value.is_hardware() {
            (own, _) = Heat::alone(&own)?;
        }
        let projector = build(&own, 1, Levels::Off)?;
        let mut guard = projector.guard().clone();
        let board = projector.display().wires()[usize::from(self.wire)].board;
        // The guard of motors counts them as spent until it has seen them at rest for a while.
        let motors = guard.motors().copied();
        let at = match motors {
            Some(_) => Instant::from_micros((BEFORE_S * 1e6) as u64),
            None => Instant::ZERO,
        };
        let stimulus = Stimulus {
            wire: self.wire,
            width: projector.width(1.0),
            peak: milliamps(own.bench.value.drive.current_ma),
            at,
            until: at + projector.timing().duration,
        };
        let mut passed = None;
        let ledger = |entry| passed = Some(entry);
        if motors.is_some() {
            guard.admit_vibration(at, board, &[stimulus], ledger);
        } else {
            guard.admit(at, board, &[stimulus], ledger);
        }
        let nothing = |why: &str| {
            Failure::Guard(format!(
                "the guard passes no pulse on {} {} of {}: {why}. Let the wearer rest, then type this again",
                self.actuator(),
                self.wire,
                self.place()
            ))
        };
        let entry = passed.ok_or_else(|| nothing("it does not know the wire"))?;
        if entry.width() == Ticks::ZERO {
            return Err(nothing(entry.reason.map_or("no width", Reason::word)));
        }
        let prescale = guard.prescale();
        Ok(Judged {
            width_us: width_us(&entry, prescale.tick_ns()),
            duty: entry.width().duty(),
            energy_mj: guard.energy_nj(entry.width(), entry.until.since(at)) as f64 * 1e-6,
            predicted: *guard.predicted(),
            used: guard.used(entry.until),
            coil_k: motors.map(|motors| (guard.coil_rise_k(entry.until), motors.rise_k)),
            entry,
        })
    }
}

/// Nominal width of what was passed, us.
fn width_us(entry: &Entry, tick_ns: u64) -> f64 {
    f64::from(entry.width().get()) * tick_ns as f64 * 1e-3
}

/// The setup of the only display that is driven, without the others.
fn alone(setup: &Setup) -> Setup {
    let own = place::fingers(setup).into_iter().next();
    own.map_or_else(|| setup.clone(), |(_, own)| own)
}

/// A display has to be named where there are several, and only there.
fn check_finger(bench: &Bench, finger: Option<&str>) -> Result<(), Failure> {
    let names: Vec<String> = bench
        .displays
        .iter()
        .map(|d| format!("`{}`", d.name))
        .collect();
    let (bench, names) = (&bench.name, names.join(", "));
    match finger {
        None if names.is_empty() => Ok(()),
        None => Err(Failure::Input(format!(
            "--finger: expected one of the displays of bench `{bench}`, {names}: which one has the wire?"
        ))),
        Some(name) if names.is_empty() => Err(Failure::Input(format!(
            "--finger: expected nothing, since bench `{bench}` has one display, found `{name}`"
        ))),
        Some(name)
            if names
                .split(", ")
                .any(|known| known.trim_matches('`') == name) =>
        {
            Ok(())
        }
        Some(name) => Err(Failure::Input(format!(
            "--finger: expected one of the displays of bench `{bench}`, {names}, found `{name}`"
        ))),
    }
}
