//! The display end of a bench of wires: boards behind a bus, the line that cuts them, and wires on a person's finger, in
//! virtual time.

mod config;

pub use config::emulated;

use palpate_core::driver::{Driver, DriverError, Traffic};
use palpate_core::guard::Guarded;
use palpate_core::projector::Projector;
use palpate_core::units::{Board, Duration, Instant, Prescale};
use palpate_emulators::display::i2c::I2cHandle;
use palpate_emulators::display::i2c::fault::{I2cFault, I2cFaults, Shared};
use palpate_emulators::display::observed::RegisterWriter;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{Aside, OutputEdge, Standing, ThermalSample, WornDisplay};
use palpate_files::{Drive, Setup};
use palpate_records::i2c::Transfer;
use palpate_records::margin::Margin;
use palpate_records::trace::{Event, Header, event};

use crate::Keep;
use crate::actuator_bus::ActuatorBus;
use crate::boards;
use crate::display_end::{DisplayEnd, I2C_LOG, OutputEnable};
use crate::effects::{Faultable, FaultyDisplay};
use crate::failure::Failure;
use crate::feel::{FullDrive, feel, sample_wires};
use crate::heat::{EmulatedHeat, HeatReport};
use crate::margins::Currents;
use crate::place::Place;
use crate::plan;
use crate::policy::{refuse_hardware, refuse_observed};
use crate::recorder::{Onset, Recorder};
use crate::script::{FaultReport, Script};
use crate::skin_end::FaultySkin;
use crate::states::{FeltState, States};
use crate::unit::{EmulatedDriver, NoLine, UnitReport};
use config::{config, no_bench};

/// Longest time between two looks at the finger, even where no stimulus comes.
const LOOK: Duration = Duration::from_millis(250);
/// Temperature samples of a run that keeps a summary alone, before all but the warmest are dropped.
const LOOKS: usize = 1 << 12;

/// Chips, amplifiers and wires on a person's finger, in virtual time, with the scene's faults.
pub struct EmulatedDisplay {
    display: WornDisplay,
    i2c: Shared<I2cHandle>,
    driver: EmulatedDriver,
    /// Writes the requested stimuli to the boards in place of their driver, where the guard only observes.
    writer: Option<RegisterWriter>,
    script: Script,
    /// Place of the display among those of the bench.
    place: Place,
    drive: Drive,
    prescale: Prescale,
    /// The onset whose stimulus is still felt.
    pending: Option<Onset>,
    /// Energy of one wire at full drive, as the person feels it.
    full: FullDrive,
    /// Time of the next look at the finger.
    next_look: Instant,
    /// Temperatures over time, if they are kept; only the warmest where a summary is enough.
    samples: Option<Vec<ThermalSample>>,
    summary: bool,
    /// The run in both states of its wires, where a summary or report shows them.
    states: Option<States>,
    /// Currents of all wires so far.
    currents: Currents,
    /// A Peltier module under the fingertip, where the bench has one.
    heat: Option<EmulatedHeat>,
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

    /// A display at its place among several of a bench, on the bus that carries its boards.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub(crate) fn at(
        setup: &Setup,
        (place, bus): (Place, Option<&ActuatorBus>),
        projector: &Projector,
        seed: u64,
    ) -> Result<Self, Failure> {
        let bench = &setup.bench.value;
        refuse_hardware(bench)?;
        plan::wires_only(&setup.bench, plan::NO_WIRES)?;
        refuse_observed(setup)?;
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
        for seat in &setup.scene.value.seats {
            display.seat(seat.wire, &seat.points_s_part);
        }
        // What is felt of a pass counts for no figure.
        if setup.pass.itself().is_none() {
            let person = plan::emulated_person(setup);
            let impossible =
                |e| Failure::Input(format!("person `{}`: {e}", setup.person.value.name));
            display.worn_by(person).map_err(impossible)?;
        }
        let full = FullDrive::new(setup, projector)?;
        let boards = plan::boards(bench);
        let prescale = projector.guard().prescale();
        let writer = || {
            let writer = RegisterWriter::new(i2c.clone(), &boards);
            let full_scale = plan::milliamps(bench.drive.current_ma);
            let writer = match &bench.dac {
                Some(dac) => writer.with_converters(&dac.addresses, full_scale),
                None => writer,
            };
            match place.alone {
                true => writer,
                false => writer.sharing(&place.channels),
            }
        };
        let heat = EmulatedHeat::find(setup);
        let lines = (i2c.clone(), display.bus());
        let module = heat.as_ref().and_then(EmulatedHeat::lent);
        let driver = EmulatedDriver::new(bench, projector, lines, (&place, module), seed)?;
        Ok(Self {
            writer: setup.is_observed().then(writer),
            driver,
            script: Script::new(&setup.scene.value.faults, projector.layout()),
            drive: bench.drive,
            place,
            prescale,
            pending: None,
            full,
            next_look: Instant::ZERO,
            samples: None,
            summary: false,
            states: None,
            currents: Currents::new(projector.display().wires().len()),
            heat,
            display,
            i2c,
        })
    }

    /// Tells whether the run's figures have a band beside them: where states are compared, on the only display of a bench.
    pub(crate) const fn has_band(&self) -> bool {
        self.states.is_some() && self.place.name.is_none()
    }

    /// Felt level and error by the state in which the wires began, where both are compared; `known` where the true path is
    /// known. The comparison ends.
    pub fn states(&mut self, known: bool) -> Vec<FeltState> {
        let other = self.display.take_other();
        let states = self.states.take();
        states.map_or_else(Vec::new, |states| states.finish(known, &other))
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

    /// Lets time pass until `until`, and a unit's program run whenever it is due.
    fn pass_with_unit(&mut self, until: Nanos, events: &mut Vec<Event>) -> Result<(), Failure> {
        while let Some(at) = self.driver.unit().and_then(|unit| unit.due(until)) {
            self.pass(at, events)?;
            if let Some(unit) = self.driver.unit() {
                unit.run(at, events);
            }
        }
        self.pass(until, events)
    }

    /// Report of the Peltier module, where the bench has one.
    pub fn heat(&self) -> Option<HeatReport> {
        self.heat.as_ref().map(EmulatedHeat::report)
    }

    /// The margins of that module.
    pub(crate) fn heat_margins(&self) -> Vec<Margin> {
        self.heat
            .as_ref()
            .map_or_else(Vec::new, EmulatedHeat::margins)
    }

    /// Report of the bench's driver unit, where it has one.
    pub fn unit(&mut self) -> Option<UnitReport> {
        self.driver.unit().map(|unit| unit.report())
    }

    fn pass(&mut self, until: Nanos, events: &mut Vec<Event>) -> Result<(), Failure> {
        if let Some(heat) = &mut self.heat {
            heat.advance(until);
            self.display.warm(heat.face_c());
        }
        let advanced = self.display.advance(until, &mut |e| events.push(edge(&e)));
        advanced.map_err(|e| Failure::Device(e.to_string()))
    }

    /// Scores the newest onset by its sensation until now; otherwise its successor scores it.
    pub fn score(&mut self, projector: &Projector, recorder: &mut Recorder) {
        let felt = self.display.onset();
        self.display.other_onset();
        let pending = self.pending.take();
        let mut states = self.states.as_mut();
        if let Some(states) = &mut states {
            states.onset();
        }
        feel(pending, felt, projector, &self.full, recorder, states);
    }
}

impl DisplayEnd for EmulatedDisplay {
    type Update = Guarded;

    fn parts(&mut self) -> (&mut dyn Driver, &dyn OutputEnable) {
        match &mut self.driver {
            EmulatedDriver::Wired(banks) => (banks, &self.display),
            EmulatedDriver::Unit(unit) => (&mut **unit, &NoLine),
        }
    }

    fn registers(&mut self) -> Option<&mut RegisterWriter> {
        self.writer.as_mut()
    }

    fn before_call(&mut self, now: Instant, projector: &mut Projector, events: &mut Vec<Event>) {
        if let Some(heat) = &mut self.heat {
            heat.turn(now, projector, self.driver.unit(), events);
        }
    }

    fn after_call(&mut self, now: Instant, heard: Option<Instant>) {
        if let Some(unit) = self.driver.unit() {
            unit.tell(now, heard);
        }
    }

    fn take_transfers(&mut self) -> Vec<Transfer> {
        match self.place.name {
            None => boards::transfers(&self.display.bus(), self.place.bus),
            Some(_) => Vec::new(),
        }
    }

    fn traffic(&mut self) -> Traffic {
        let written = self.writer.as_ref().map(RegisterWriter::traffic);
        written.unwrap_or_else(|| self.driver.boards().traffic())
    }

    fn advance_to(&mut self, now: Instant, events: &mut Vec<Event>) -> Result<(), Failure> {
        self.pass_with_unit(Nanos::from(now), events)
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
                unit: self.driver.unit(),
                heat: self.heat.as_ref().map(EmulatedHeat::module),
                motors: None,
            }),
        };
        self.script.step(now, last, &mut bench, events);
    }

    fn next_fault(&self) -> Instant {
        self.script.next()
    }

    fn keep(&mut self, keep: Keep) -> Result<(), Failure> {
        self.display.keep_flows();
        self.samples = Some(Vec::new());
        self.summary = keep.summary;
        if keep.i2c {
            let kept = self.display.bus().with(|bus| bus.keep_log(I2C_LOG));
            kept.map_err(|e| Failure::Device(format!("actuator bus: {e}")))?;
        }
        Ok(())
    }

    fn compare(&mut self, setup: &Setup, header: &Header, aside: Option<Aside>) {
        self.states = Some(States::new(setup, header, (&mut self.display, aside)));
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
        if let Some(heat) = &mut self.heat {
            heat.off();
        }
        let mut until = Nanos::from(end) + Nanos(2 * self.prescale.period_ns());
        if self.driver.unit().is_some() {
            // Whatever the network does to the last datagram, the unit is off by then.
            until = until + Nanos::from_micros(projector.guard().limits().stale.as_micros());
        }
        self.pass_with_unit(until, &mut recorder.events)?;
        self.sample();
        Ok(())
    }

    fn bus_now(&mut self) -> Nanos {
        self.display.bus_now()
    }

    fn standing(&self, with_totals: bool) -> Option<Standing> {
        Some(self.display.standing(with_totals))
    }

    fn face_c(&self) -> Option<f64> {
        self.heat.as_ref().map(EmulatedHeat::face_c)
    }

    /// Explains an error with the board's number on the bench.
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
            DriverError::Current(board, output, expected, found) => {
                DriverError::Current(of(board), output, expected, found)
            }
            DriverError::NoConverter(board, output) => DriverError::NoConverter(of(board), output),
            DriverError::Unit(_) | DriverError::Haptic(_) | DriverError::Audio(_) => *error,
        };
        error.to_string()
    }
}

const fn edge(e: &OutputEdge) -> Event {
    Event::Edge(event::Edge {
        t_ns: e.at.0,
        board: e.board,
        channel: e.channel,
        high: e.high,
    })
}
