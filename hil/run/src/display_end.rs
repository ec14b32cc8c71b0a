//! The display end of a run: boards behind a bus, the line that cuts them, and what hangs on their outputs.

use embedded_hal::i2c::I2c;
use palpate_core::driver::{Banks, DriverError, Traffic};
use palpate_core::illusion::DisplayWire;
use palpate_core::physics::ParameterError;
use palpate_core::projector::{LoopError, Projector};
use palpate_core::skin::SkinSource;
use palpate_core::units::{Board, Duration, Instant, Prescale};
use palpate_emulators::display::amplifier::AmplifierConfig;
use palpate_emulators::display::amplifier::supply::SupplySource;
use palpate_emulators::display::i2c::fault::{I2cFault, I2cFaults, Shared};
use palpate_emulators::display::i2c::{BusClock, I2cHandle};
use palpate_emulators::display::observed::RegisterWriter;
use palpate_emulators::person::channels::Felt;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{DisplayConfig, OutputEdge, ThermalSample, WirePlace, WornDisplay};
use palpate_files::{Bench, BenchKind, Drive, Setup};
use palpate_records::i2c::Transfer;
use palpate_records::trace::{Event, Header};

use crate::Keep;
use crate::actuator_bus::ActuatorBus;
use crate::band::{Band, FeltBand};
use crate::boards;
use crate::effects::{Faultable, FaultyDisplay};
use crate::failure::Failure;
use crate::feel::{FullDrive, feel, sample_wires};
use crate::margins::Currents;
use crate::place::Place;
use crate::plan;
use crate::recorder::{Onset, Recorder};
use crate::script::{FaultReport, Script};
use crate::skin_end::FaultySkin;

/// The finger is looked at no less often than this, even where no stimulus comes.
const LOOK: Duration = Duration::from_millis(250);
/// So many temperatures are looked through at once for the warmest.
const LOOKS: usize = 1 << 12;
/// Transfers kept of a run's actuator bus, the last ones: some hours of them.
const I2C_LOG: usize = 1 << 20;

/// The line that cuts every output whatever the chips' registers say, and needs no bus.
pub trait OutputEnable {
    /// Releases it, or cuts.
    fn set_enabled(&self, now: Instant, enabled: bool);

    /// How notes say that the outputs were cut, or that they could not be.
    fn words(&self) -> &'static str;
}

/// The display end of a session. What has an empty default is what only emulated hardware can do.
pub trait DisplayEnd {
    /// The bus of the boards.
    type I2c: I2c;

    /// The boards, and the line that cuts them.
    fn parts(&mut self) -> (&mut Banks<Self::I2c>, &dyn OutputEnable);

    /// One call of the loop, through the guard to the boards.
    ///
    /// # Errors
    /// The first error of an end.
    fn poll<S: SkinSource>(
        &mut self,
        now: Instant,
        projector: &mut Projector,
        skin: &mut S,
        recorder: &mut Recorder,
    ) -> Result<bool, LoopError<S::Error, DriverError>> {
        projector.poll(now, skin, self.parts().0, recorder)
    }

    /// Whether the guard only looks on: its stops are noted and end nothing.
    fn is_observed(&self) -> bool {
        false
    }

    /// What updates came to on the buses of the boards.
    fn traffic(&mut self) -> Traffic {
        self.parts().0.traffic()
    }

    /// Lets time pass until `now`.
    ///
    /// # Errors
    /// [`Failure::Device`] for an emulator that contradicts itself.
    fn advance_to(&mut self, now: Instant, events: &mut Vec<Event>) -> Result<(), Failure> {
        let _ = (now, events);
        Ok(())
    }

    /// Looks at wires and person after a turn that may have begun a stimulus.
    fn look(&mut self, now: Instant, onset: bool, projector: &Projector, recorder: &mut Recorder) {
        let _ = (now, onset, projector, recorder);
    }

    /// Lets scripted faults begin and end that are due at `now`; with `last` those that are on end.
    fn fail(&mut self, now: Instant, last: bool, skin: FaultySkin<'_>, events: &mut Vec<Event>) {
        let _ = (now, last, skin, events);
    }

    /// When the next scripted fault begins or ends.
    fn next_fault(&self) -> Instant {
        Instant::FAR_FUTURE
    }

    /// A driver's error in full.
    fn explain(&self, error: &DriverError) -> String {
        error.to_string()
    }

    /// Keeps a stop of the guard until a person has looked; says what ends the run.
    fn keep_stopped(&mut self, cause: &str) -> Failure {
        Failure::Guard(cause.to_owned())
    }
}

/// Chips, amplifiers and wires on a person's finger, in virtual time, with the scene's faults.
pub struct EmulatedDisplay {
    display: WornDisplay,
    i2c: Shared<I2cHandle>,
    banks: Banks<Shared<I2cHandle>>,
    /// What drives the boards in place of their driver where the guard only looks on.
    writer: Option<RegisterWriter>,
    script: Script,
    /// Where it stands among the displays of the bench.
    place: Place,
    drive: Drive,
    prescale: Prescale,
    /// The onset whose stimulus is still felt.
    pending: Option<Onset>,
    /// What one wire at full drive gives to feel.
    full: FullDrive,
    /// The finger is looked at again then.
    next_look: Instant,
    /// Temperatures over time, if they are kept; only the warmest where a summary is enough.
    samples: Option<Vec<ThermalSample>>,
    summary: bool,
    /// What would be felt in other corners, where that is shown.
    band: Option<Band>,
    /// What flowed.
    currents: Currents,
}

impl EmulatedDisplay {
    /// A setup's display with the bench's boards, nothing started yet.
    ///
    /// # Errors
    /// [`Failure::Input`] for a bench that cannot be, or one of hardware.
    pub fn new(setup: &Setup, projector: &Projector, seed: u64) -> Result<Self, Failure> {
        let whole = Place::whole(&setup.bench.value);
        Self::at(setup, (whole, None), projector, seed)
    }

    /// The same at its place among several displays of a bench, on the bus that carries its boards.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn at(
        setup: &Setup,
        (place, bus): (Place, Option<&ActuatorBus>),
        projector: &Projector,
        seed: u64,
    ) -> Result<Self, Failure> {
        let bench = &setup.bench.value;
        refuse_hardware(bench)?;
        let wires = projector.display().wires();
        let (mut display, i2c) = match bus {
            Some(bus) => (bus.connect(&place, &config(setup, wires))).map_err(no_bench(bench))?,
            None => {
                let display = emulated(setup, wires)?;
                let none = I2cFaults::default();
                let layer = I2cFault::new(display.bus(), none, seed, "actuator bus");
                (display, Shared::new(layer))
            }
        };
        let person = plan::person(&setup.person.value);
        let impossible = |e| Failure::Input(format!("person `{}`: {e}", setup.person.value.name));
        display.worn_by(person).map_err(impossible)?;
        let full = FullDrive::new(setup, projector)?;
        let boards = plan::boards(bench);
        let prescale = projector.guard().prescale();
        let mut writer = RegisterWriter::new(i2c.clone(), &boards);
        let mut banks = Banks::new([(i2c.clone(), &*boards)], prescale);
        if !place.alone {
            writer = writer.sharing(&place.channels);
            banks = banks.sharing(&place.channels);
        }
        Ok(Self {
            writer: setup.is_observed().then_some(writer),
            banks,
            script: Script::new(&setup.scene.value.faults, projector.layout()),
            drive: bench.drive,
            place,
            prescale,
            pending: None,
            full,
            next_look: Instant::ZERO,
            samples: None,
            summary: false,
            band: None,
            currents: Currents::new(projector.display().wires().len()),
            display,
            i2c,
        })
    }

    /// Keeps currents and temperatures, for the margins, and if wanted the newest messages of the bus. Temperatures
    /// grow with the length of a run, but where a summary is all that is wanted.
    ///
    /// # Errors
    /// [`Failure::Device`] where the bus cannot keep a log.
    pub fn keep(&mut self, keep: Keep) -> Result<(), Failure> {
        self.display.keep_flows();
        self.samples = Some(Vec::new());
        self.summary = keep.summary;
        if keep.i2c {
            let kept = self.display.bus().with(|bus| bus.keep_log(I2C_LOG));
            kept.map_err(|e| Failure::Device(format!("actuator bus: {e}")))?;
        }
        Ok(())
    }

    /// Has all corners of what is not measured felt beside, for [`EmulatedDisplay::band`].
    ///
    /// # Errors
    /// [`Failure::Input`] for a wire or person that cannot be.
    pub fn compare(&mut self, setup: &Setup, header: &Header) -> Result<(), Failure> {
        self.band = Some(Band::new(setup, header, &mut self.display)?);
        Ok(())
    }

    /// What all corners came to, where they are compared and a contact was inside the display; `known` where the path is.
    pub fn band(&self, known: bool) -> Option<FeltBand> {
        self.band.as_ref()?.finish(known)
    }

    /// What crossed its bus, if that was kept and no other display is on it.
    pub fn transfers(&self) -> Vec<Transfer> {
        match self.place.name {
            None => boards::transfers(&self.display.bus(), self.place.bus),
            Some(_) => Vec::new(),
        }
    }

    /// The emulated hardware.
    pub const fn hardware(&mut self) -> &mut WornDisplay {
        &mut self.display
    }

    /// Temperatures and currents since the last time, oldest first; a wire that is on is cut here.
    pub fn take_samples(&mut self) -> (Vec<ThermalSample>, Currents) {
        let samples = self.samples.as_mut().map(std::mem::take);
        let flows = self.display.take_flows();
        self.currents.add(flows);
        (
            samples.unwrap_or_default(),
            std::mem::take(&mut self.currents),
        )
    }

    /// What became of the scene's faults.
    pub fn faults(&self) -> Vec<FaultReport> {
        self.script.report()
    }

    /// Waits until an all-off of `end` has taken effect: with the end of a period, so for two of them.
    ///
    /// # Errors
    /// As [`DisplayEnd::advance_to`].
    pub fn settle(
        &mut self,
        end: Instant,
        projector: &Projector,
        recorder: &mut Recorder,
    ) -> Result<(), Failure> {
        self.score(projector, recorder);
        let until = Nanos::from(end) + Nanos(2 * self.prescale.period_ns());
        self.pass(until, &mut recorder.events)?;
        self.sample();
        Ok(())
    }

    fn sample(&mut self) {
        if let Some(samples) = &mut self.samples {
            samples.extend(self.display.sample());
            if self.summary && samples.len() >= LOOKS {
                let warmest = samples.iter().max_by(|a, b| a.mean_c.total_cmp(&b.mean_c));
                *samples = warmest.copied().into_iter().collect();
            }
            let flows = self.display.ended_flows();
            self.currents.add(flows);
        }
    }

    fn pass(&mut self, until: Nanos, events: &mut Vec<Event>) -> Result<(), Failure> {
        let advanced = self.display.advance(until, &mut |e| events.push(edge(&e)));
        advanced.map_err(|e| Failure::Device(e.to_string()))
    }

    /// Scores what was felt of the newest onset, which is over.
    fn score(&mut self, projector: &Projector, recorder: &mut Recorder) {
        let felt = self.display.onset();
        let others: Vec<Option<Felt>> = self.display.other_onsets().collect();
        let pending = self.pending.take();
        let compared = (self.band.as_mut(), &*others);
        feel(pending, felt, projector, &self.full, recorder, compared);
    }
}

impl DisplayEnd for EmulatedDisplay {
    type I2c = Shared<I2cHandle>;

    fn parts(&mut self) -> (&mut Banks<Shared<I2cHandle>>, &dyn OutputEnable) {
        (&mut self.banks, &self.display)
    }

    fn poll<S: SkinSource>(
        &mut self,
        now: Instant,
        projector: &mut Projector,
        skin: &mut S,
        recorder: &mut Recorder,
    ) -> Result<bool, LoopError<S::Error, DriverError>> {
        match &mut self.writer {
            Some(writer) => projector.observe(now, skin, writer, recorder),
            None => projector.poll(now, skin, &mut self.banks, recorder),
        }
    }

    fn is_observed(&self) -> bool {
        self.writer.is_some()
    }

    fn traffic(&mut self) -> Traffic {
        let written = self.writer.as_ref().map(RegisterWriter::traffic);
        written.unwrap_or_else(|| self.banks.traffic())
    }

    fn advance_to(&mut self, now: Instant, events: &mut Vec<Event>) -> Result<(), Failure> {
        self.pass(Nanos::from(now), events)
    }

    fn look(&mut self, now: Instant, onset: bool, projector: &Projector, recorder: &mut Recorder) {
        if onset {
            self.score(projector, recorder);
            self.pending = recorder.onset.take();
            sample_wires(now, &mut self.display, projector, recorder);
        }
        if onset || now >= self.next_look {
            self.sample();
            self.display.settle();
            self.next_look = now + LOOK;
        }
    }

    fn fail(&mut self, now: Instant, last: bool, skin: FaultySkin<'_>, events: &mut Vec<Event>) {
        let mut bench = Faultable {
            skin,
            display: Some(FaultyDisplay {
                i2c: &self.i2c,
                chips: self.display.bus(),
                worn: Some(&mut self.display),
                drive: self.drive,
                place: &self.place,
            }),
        };
        if last {
            self.script.finish(now, &mut bench, events);
        } else {
            self.script.step(now, &mut bench, events);
        }
    }

    fn next_fault(&self) -> Instant {
        self.script.next()
    }

    /// With the board's number on the bench.
    fn explain(&self, error: &DriverError) -> String {
        let of = |own: Board| {
            let board = self.place.boards.get(usize::from(own.0));
            Board(board.copied().unwrap_or(own.0))
        };
        let error = match *error {
            DriverError::NoSuchBoard(board) => DriverError::NoSuchBoard(of(board)),
            DriverError::Bus(board, kind) => DriverError::Bus(of(board), kind),
            DriverError::Readback(board, register, expected, found) => {
                DriverError::Readback(of(board), register, expected, found)
            }
        };
        error.to_string()
    }
}

impl OutputEnable for WornDisplay {
    fn set_enabled(&self, now: Instant, enabled: bool) {
        self.set_outputs(Nanos::from(now), enabled);
    }

    fn words(&self) -> &'static str {
        "outputs off by the OE line"
    }
}

const fn edge(e: &OutputEdge) -> Event {
    Event::Edge {
        t_ns: e.at.0,
        board: e.board,
        channel: e.channel,
        high: e.high,
    }
}

/// Refuses a bench of hardware: what is emulated must not be recorded as real.
pub(crate) fn refuse_hardware(bench: &Bench) -> Result<(), Failure> {
    match bench.kind {
        BenchKind::Emulated => Ok(()),
        BenchKind::Real => Err(Failure::Input(format!(
            "bench `{}`: expected kind = \"emulated\", found \"real\": only the program `hil` opens hardware",
            bench.name
        ))),
    }
}

/// The emulated display of a bench: its chips and amplifiers, `wires` on a finger.
///
/// # Errors
/// [`Failure::Input`] for a bench that cannot be.
pub fn emulated(setup: &Setup, wires: &[DisplayWire]) -> Result<WornDisplay, Failure> {
    let bench = &setup.bench.value;
    let display = WornDisplay::new(&config(setup, wires)).map_err(no_bench(bench))?;
    // Refused only from inside another look at the segment, and there is none here.
    let _ = display.bus().with(|segment| {
        let chips = segment.chips_mut().iter_mut();
        chips.for_each(|chip| chip.set_external_clock(Nanos::ZERO, bench.drive.external_hz()));
    });
    Ok(display)
}

fn no_bench(bench: &Bench) -> impl Fn(ParameterError) -> Failure {
    move |e| Failure::Input(format!("bench `{}`: {e}", bench.name))
}

/// How a bench's display is built, with `wires` on a finger.
fn config(setup: &Setup, wires: &[DisplayWire]) -> DisplayConfig {
    let bench = &setup.bench.value;
    let place = |w: &DisplayWire| WirePlace {
        at: w.place,
        board: w.board.0,
        channel: w.channel.0,
    };
    DisplayConfig {
        boards: plan::boards(bench)
            .into_iter()
            .map(|a| (a, bench.drive.oscillator))
            .collect(),
        wires: wires.iter().map(place).collect(),
        amplifier: AmplifierConfig {
            current: plan::milliamps(bench.drive.current_ma),
            rise: Nanos((bench.amplifier.rise_us * 1e3).round() as u64),
            on_ohm: bench.amplifier.on_ohm,
        },
        source: SupplySource {
            volts: bench.amplifier.supply_v.unwrap_or(f64::INFINITY),
            ohm: bench.amplifier.supply_ohm,
        },
        wire: plan::wire(setup),
        tissue: bench.tissue.parameters(),
        clock: BusClock::Fast,
    }
}
