//! The actuator side of a bench: I2C segment, chips, amplifiers, supply, wires on a finger, and the
//! person who wears it. The counterpart of [`crate::sensor::rig`].

mod beside;
mod rack;
mod rise;
mod stage;
mod standing;
mod totals;
mod wearing;

pub use beside::Aside;
pub use rack::Rack;
pub use standing::Standing;
pub use totals::DisplayTotals;

use std::collections::VecDeque;

use palpate_core::physics::{ParameterError, TissueParameters, WireParameters};
use palpate_core::units::{Channel, Milliamps, Point};

use crate::display::amplifier::supply::{Load, Supply, SupplySource};
use crate::display::amplifier::{AmplifierConfig, AmplifierFault};
use crate::display::dac7578::Dac7578;
use crate::display::i2c::{BusClock, Error as I2cError, I2cHandle};
use crate::display::pca9685::{Edge, Pca9685, Pin};
use crate::display::solver::record::Peaks;
use crate::person::channels::{Felt, Person};
use crate::time::Nanos;
use beside::Beside;
use rack::Connection;
use rise::Rise;
use stage::Stage;
use wearing::Wearing;

/// Tissue at rest unless stated, degrees C: a warm face of a Peltier module counts from here.
pub const START_C: f64 = 33.0;

/// Place of a wire, and the channel that drives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WirePlace {
    /// Place on the unrolled display, mm.
    pub at: Point,
    /// Index of its chip.
    pub board: u8,
    /// Channel of that chip.
    pub channel: u8,
}

/// Settings of a display.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayConfig {
    /// 7-bit address and oscillator factor of each chip.
    pub boards: Vec<(u8, f64)>,
    /// 7-bit address of the converter beside each chip; empty where the amplifiers have a current of their own. For boards
    /// that no other display uses.
    pub converters: Vec<u8>,
    /// The wires in the display's order.
    pub wires: Vec<WirePlace>,
    /// The amplifiers.
    pub amplifier: AmplifierConfig,
    /// Supply of all amplifiers.
    pub source: SupplySource,
    /// Every wire's parameters.
    pub wire: WireParameters,
    /// Parameters of the finger's tissue.
    pub tissue: TissueParameters,
    /// I2C clock.
    pub clock: BusClock,
}

/// An edge of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutputEdge {
    /// Time of the edge.
    pub at: Nanos,
    /// Index of the chip.
    pub board: u8,
    /// Channel of that chip.
    pub channel: u8,
    /// High or not.
    pub high: bool,
}

/// A stretch of one wire's current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// The wire, in the display's order.
    pub wire: usize,
    /// Start.
    pub from: Nanos,
    /// End.
    pub to: Nanos,
    /// Electrical power between the wire's terminals, W.
    pub watts: f64,
}

/// The finger at one instant, worst over its wires.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalSample {
    /// Time of the sample.
    pub at: Nanos,
    /// Hottest wire since the sample before, degrees C.
    pub wire_c: f64,
    /// Hottest tissue at 0.1 mm since the sample before, degrees C.
    pub shallow_c: f64,
    /// Hottest tissue at 0.4 mm since the sample before, degrees C.
    pub deep_c: f64,
    /// Hottest mean of the tissue at 0.1 mm over the last ten seconds, degrees C; before the start all was at rest.
    pub mean_c: f64,
}

/// The window of the mean tissue temperature.
const MEAN_WINDOW: Nanos = Nanos::from_micros(10_000_000);

/// The display side of a bench.
#[derive(Debug)]
pub struct WornDisplay {
    chips: Connection,
    stage: Stage,
    source: SupplySource,
    supply: Supply,
    /// Load of each wire, in their order.
    loads: Vec<Load>,
    places: Vec<WirePlace>,
    parameters: WireParameters,
    tissue: TissueParameters,
    /// The wires, and who feels them.
    worn: Wearing,
    /// Other wires in their place, through which the same currents flow.
    other: Option<Beside>,
    now: Nanos,
    /// Edges of one step, in the order of time: the same memory for every step.
    pending: Vec<(usize, Edge)>,
    /// Start of each wire's present stretch of current, and its electrical power, W.
    flowing: Vec<(Nanos, f64)>,
    /// Kept only where a caller takes them: an emulator may be served for days.
    flows: Option<Vec<Flow>>,
    /// Integrals of each wire's tissue temperature at past samples, for the mean.
    past: VecDeque<(Nanos, Vec<f64>)>,
    /// A warm face under the wires, where there is one.
    warmed: Option<Rise>,
}

impl WornDisplay {
    /// Builds chips, amplifiers and wires, all at rest and off.
    ///
    /// # Errors
    /// A physical parameter that cannot be computed with, by name.
    pub fn new(config: &DisplayConfig) -> Result<Self, ParameterError> {
        let rack = Rack::new(&config.boards, &config.converters, config.clock);
        let whole = (0..config.boards.len()).map(|chip| (chip, u16::MAX));
        Self::on(&rack, &whole.collect::<Vec<_>>(), config)
    }

    /// Builds a display on chips that other displays use too: for each of its boards the place on the rack's bus, and a
    /// bit for each channel of the display. `boards` and `clock` of `config` are the rack's to say.
    ///
    /// # Errors
    /// [`ParameterError`] for a physical parameter that cannot be computed with, by name.
    pub fn on(
        rack: &Rack,
        boards: &[(usize, u16)],
        config: &DisplayConfig,
    ) -> Result<Self, ParameterError> {
        let worn = Wearing::new(&config.wire, &config.tissue, config.wires.len())?;
        Ok(Self {
            chips: rack.connect(boards),
            stage: Stage::new(config.amplifier, boards.len()),
            source: config.source,
            supply: Supply::default(),
            loads: vec![
                Load {
                    asked: 0.0,
                    ohm: config.wire.resistance_ohm + config.amplifier.on_ohm.max(0.0),
                    amps: 0.0,
                };
                config.wires.len()
            ],
            worn: worn.with_dose(),
            other: None,
            places: config.wires.clone(),
            parameters: config.wire,
            tissue: config.tissue,
            now: Nanos::ZERO,
            pending: Vec::new(),
            flowing: vec![(Nanos::ZERO, 0.0); config.wires.len()],
            flows: None,
            past: VecDeque::new(),
            warmed: None,
        })
    }

    /// The bus that a driver holds.
    pub fn bus(&self) -> I2cHandle {
        self.chips.bus()
    }

    /// Time of the display's bus: a transaction carries it beyond the time of the displays on it.
    pub fn bus_now(&self) -> Nanos {
        self.chips.bus_now()
    }

    /// Cuts the OE lines of its boards, or lets go of them. A board that displays share drives once none holds it cut.
    pub fn set_outputs(&self, now: Nanos, enabled: bool) {
        self.chips.set_outputs(now, enabled);
    }

    /// Does something to a chip, by its number among this display's.
    pub fn on_chip(&self, board: usize, work: impl FnOnce(&mut Pca9685)) {
        self.chips.on_chip(board, work);
    }

    /// Does something to the converter that sets a wire's current, and to its output there; nothing where there is none.
    pub fn on_converter(&self, wire: usize, work: impl FnOnce(&mut Dac7578, Channel)) {
        if let Some(place) = self.places.get(wire) {
            let output = Channel(place.channel);
            let work = |converter: &mut Dac7578| work(converter, output);
            self.chips.on_converter(usize::from(place.board), work);
        }
    }

    /// Lets time pass until `to`; edges go through the amplifiers into the wires and to `sink`.
    ///
    /// # Errors
    /// [`I2cError::BusBusy`] from inside a look at the segment.
    pub fn advance(
        &mut self,
        to: Nanos,
        sink: &mut impl FnMut(OutputEdge),
    ) -> Result<(), I2cError> {
        self.chips.take(to, &mut self.pending)?;
        for &(board, edge) in &self.pending {
            self.stage.edge(board, edge);
            sink(OutputEdge {
                at: edge.at,
                board: board as u8, // at most 16 chips on a bus
                channel: edge.channel.0,
                high: edge.pin == Pin::High,
            });
        }
        self.pending.clear();
        self.stage.follow(&self.chips, to)?;
        let due = self.stage.due(to);
        for index in 0..due {
            if let Some(at) = self.stage.apply(index) {
                self.flow(at);
            }
        }
        self.stage.done(due);
        self.now = self.now.max(to);
        Ok(())
    }

    /// Lets the currents that the amplifiers ask for flow from `at` on, as far as the supply has them.
    fn flow(&mut self, at: Nanos) {
        for (load, place) in self.loads.iter_mut().zip(&self.places) {
            load.asked = self.stage.current(place).amps();
        }
        self.source.share(&mut self.loads);
        let mut sum = 0.0;
        for wire in 0..self.loads.len() {
            let load = self.loads[wire];
            sum += load.amps;
            self.worn.wires[wire].set_current(at, load.amps);
            if let Some(other) = &mut self.other {
                other.set_current(wire, at, load.amps);
            }
            let (since, before) = self.flowing[wire];
            let watts = load.amps * load.amps * self.parameters.resistance_ohm;
            if watts.to_bits() != before.to_bits() {
                self.flowing[wire] = (at, watts);
                self.keep(wire, since, at, before);
            }
        }
        self.supply.set(at, Milliamps((sum * 1e3).round() as u32));
    }

    fn keep(&mut self, wire: usize, from: Nanos, to: Nanos, watts: f64) {
        if let Some(flows) = &mut self.flows
            && watts > 0.0
            && to > from
        {
            flows.push(Flow {
                wire,
                from,
                to,
                watts,
            });
        }
    }

    /// Keeps every stretch of current from now on, for [`WornDisplay::take_flows`].
    pub fn keep_flows(&mut self) {
        self.flows.get_or_insert_default();
    }

    /// Every stretch of current since they are kept or were last taken, up to now; a wire that is on now is
    /// cut there.
    pub fn take_flows(&mut self) -> Vec<Flow> {
        for wire in 0..self.worn.wires.len() {
            let (since, watts) = self.flowing[wire];
            self.flowing[wire].0 = since.max(self.now);
            self.keep(wire, since, self.now, watts);
        }
        self.ended_flows()
    }

    /// The stretches of current that have ended since they are kept or were last taken.
    pub fn ended_flows(&mut self) -> Vec<Flow> {
        self.flows.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Temperatures of the finger since the last sample; `None` without wires.
    pub fn sample(&mut self) -> Option<ThermalSample> {
        let now = self.now;
        let mut integrals = Vec::with_capacity(self.worn.wires.len());
        let mut worst = Peaks::NONE;
        for wire in &mut self.worn.wires {
            worst.raise(&wire.window_floor(now));
        }
        for wire in &mut self.worn.wires {
            worst.raise(&wire.window_peaks(now, &worst));
            integrals.push(wire.dose(now).unwrap_or_default().celsius_s);
        }
        let begin = now.since(MEAN_WINDOW);
        while self.past.get(1).is_some_and(|next| next.0 <= begin) {
            self.past.pop_front();
        }
        // Between samples the integral is taken as straight; before the start all was at rest.
        let length = MEAN_WINDOW.as_secs_f64();
        let rest = (length - now.since(begin).as_secs_f64()) * self.tissue.body_c;
        let mean = |wire: usize| {
            let mut then = 0.0;
            if let (Some(a), Some(b)) = (self.past.front(), self.past.get(1)) {
                let part = begin.since(a.0).as_secs_f64() / b.0.since(a.0).as_secs_f64();
                then = a.1[wire] + (b.1[wire] - a.1[wire]) * part;
            }
            (integrals[wire] - then + rest) / length
        };
        let mean_c = (0..integrals.len()).map(mean).fold(f64::MIN, f64::max);
        if self.past.back().is_none_or(|last| last.0 < now) {
            if self.past.is_empty() {
                self.past
                    .push_back((Nanos::ZERO, vec![0.0; integrals.len()]));
            }
            self.past.push_back((now, integrals));
        }
        if self.worn.wires.is_empty() {
            return None;
        }
        let sample = ThermalSample {
            at: now,
            wire_c: worst.wire_c,
            shallow_c: worst.shallow_c,
            deep_c: worst.deep_c,
            mean_c,
        };
        Some(match &mut self.warmed {
            Some(rise) => rise.add(sample),
            None => sample,
        })
    }

    /// Puts a face of this temperature, degrees C, on the skin under the wires from now on.
    pub fn warm(&mut self, face_c: f64) {
        self.warmed.get_or_insert_default().set(self.now, face_c);
    }

    /// Breaks or repairs the amplifier of a wire, now; a wire that is not there is left alone.
    pub fn set_fault(&mut self, wire: usize, fault: Option<AmplifierFault>) {
        let Some(place) = self.places.get(wire) else {
            return;
        };
        let now = self.now;
        if self.stage.set_fault(now, place, fault) {
            self.flow(now);
        }
    }

    /// Temperature of a wire now, degrees C; `None` if there is no such wire.
    pub fn wire_c(&mut self, wire: usize) -> Option<f64> {
        let now = self.now;
        self.worn.wires.get_mut(wire).map(|w| w.temperature(now))
    }

    /// Temperature of the tissue 0.1 mm deep under a wire now, degrees C; `None` if there is no such wire.
    pub fn tissue_c(&mut self, wire: usize) -> Option<f64> {
        let now = self.now;
        let rise_k = self.warmed.as_ref().map_or(0.0, |rise| rise.k);
        self.worn
            .wires
            .get_mut(wire)
            .map(|w| w.tissue(now).0 + rise_k)
    }

    /// A person puts the display on, now: wires are felt from here on. Until the next [`WornDisplay::settle`] every stretch
    /// of their motion is kept.
    ///
    /// # Errors
    /// A parameter of the person that cannot be, by name.
    pub fn worn_by(&mut self, person: Person) -> Result<(), ParameterError> {
        self.worn.by(person, &self.places_mm())
    }

    /// Lets only a part of a wire's motion, 0 to 1, reach the skin: points of seconds, ascending, and parts, with straight lines
    /// between, and ends that hold. Each stretch of the motion has the part of its beginning. A wire that is not there is left
    /// alone.
    pub fn seat(&mut self, wire: usize, points_s_part: &[[f64; 2]]) {
        self.worn.seat(wire, points_s_part);
    }

    /// Puts other wires beside in place of earlier ones, at rest, through which the same currents flow from here on, and has
    /// the same person feel them: what such wires would have given. Of chips, amplifiers and supply nothing changes.
    /// `aside` computes them beside the caller's work; without it they are computed here.
    ///
    /// # Errors
    /// A parameter of wire or person that cannot be, by name.
    pub fn compare(
        &mut self,
        wire: &WireParameters,
        person: Person,
        aside: Option<Aside>,
    ) -> Result<(), ParameterError> {
        let mut other = self.worn.instead(wire, &self.tissue)?;
        other.by(person, &self.places_mm())?;
        self.other = Some(Beside::new(other, aside));
        Ok(())
    }

    fn places_mm(&self) -> Vec<(f64, f64)> {
        let place = |place: &WirePlace| (f64::from(place.at.x), f64::from(place.at.y));
        self.places.iter().map(place).collect()
    }

    /// Sums up what was felt until now.
    pub fn settle(&mut self) {
        self.worn.settle(self.now);
        if let Some(other) = &mut self.other {
            other.settle(self.now);
        }
    }

    /// Takes the stimulus that a person met since the last onset, felt or not, and begins the next one. `None` where no
    /// wire moved or no person wears the display.
    pub fn onset(&mut self) -> Option<Felt> {
        self.worn.onset(self.now)
    }

    /// Ends a stimulus of the wires beside, and begins the next one.
    pub fn other_onset(&mut self) {
        if let Some(other) = &mut self.other {
            other.onset(self.now);
        }
    }

    /// Takes the wires beside away; returns the stimulus of each of their onsets, the oldest first: `None` as for
    /// [`Self::onset`]. Without such wires there is no onset.
    pub fn take_other(&mut self) -> Vec<Option<Felt>> {
        self.other.take().map_or_else(Vec::new, Beside::finish)
    }

    /// Most martensite of any wire now, in [0, 1]; `None` without wires.
    pub fn martensite(&mut self) -> Option<f64> {
        let now = self.now;
        let wires = self.worn.wires.iter_mut();
        wires.map(|wire| wire.fraction(now)).reduce(f64::max)
    }

    /// Totals of the run until now.
    pub fn totals(&mut self) -> DisplayTotals {
        let (now, peak_supply) = (self.now, self.supply.peak().0);
        let totals = DisplayTotals::new(&mut self.worn.wires, &Peaks::NONE, peak_supply, now);
        match &self.warmed {
            Some(rise) => rise.total(totals),
            None => totals,
        }
    }

    /// A copy of its wires as they stand now, for a look that leaves them alone; with their books, which are larger, for
    /// one at totals too.
    pub fn standing(&self, with_books: bool) -> Standing {
        Standing::new(self, with_books)
    }
}
