//! The actuator side of a bench: I2C segment, chips, amplifiers, supply, wires on a finger, and the
//! person who wears it. The counterpart of [`crate::rig`].

use palpate_core::physics::{ParameterError, SkinParameters, WireParameters};
use palpate_core::units::{Channel, Milliamps, Point};

use crate::amplifier::supply::{Load, Source, Supply};
use crate::amplifier::{Amplifier, AmplifierConfig, AmplifierFault, Pull, takes_effect};
use crate::i2c::{BusClock, Error as I2cError, Handle, Segment};
use crate::pca9685::{Config, Edge, Oscillator, Pca9685, Pin};
use crate::perceiver::{Felt, Perceiver, PerceiverParameters, Vibration};
use crate::time::Nanos;
use crate::wire::Wire;

/// Skin temperature from which everything starts, degrees C.
const START_C: f64 = 33.0;

/// Where a wire is and what drives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// On the unrolled display, mm.
    pub at: Point,
    /// Index of its chip.
    pub board: u8,
    /// Channel of that chip.
    pub channel: u8,
}

/// How a display is built.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayConfig {
    /// 7-bit address and oscillator factor of each chip.
    pub boards: Vec<(u8, f64)>,
    /// The wires in the display's order.
    pub wires: Vec<Place>,
    /// The amplifiers.
    pub amplifier: AmplifierConfig,
    /// What feeds them all.
    pub source: Source,
    /// Every wire's parameters.
    pub wire: WireParameters,
    /// The finger's.
    pub skin: SkinParameters,
    /// The person's.
    pub perceiver: PerceiverParameters,
    /// I2C clock.
    pub clock: BusClock,
}

/// An edge of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutputEdge {
    /// When.
    pub at: Nanos,
    /// Index of the chip.
    pub board: u8,
    /// Channel of that chip.
    pub channel: u8,
    /// High or not.
    pub high: bool,
}

/// What a run came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DisplayTotals {
    /// Electrical energy into all wires and their leads, J.
    pub electrical_j: f64,
    /// Largest supply current.
    pub peak_supply: Milliamps,
    /// Hottest wire: temperature in degrees C and index.
    pub hottest_wire: (f64, usize),
    /// Hottest skin 0.1 mm deep under any wire, degrees C.
    pub hottest_skin_c: f64,
}

/// The display side of a bench.
#[derive(Debug)]
pub struct Display {
    i2c: Handle,
    amplifiers: Vec<Amplifier>,
    rise: Nanos,
    source: Source,
    supply: Supply,
    /// One a wire, in their order.
    loads: Vec<Load>,
    places: Vec<Place>,
    parameters: WireParameters,
    wires: Vec<Wire>,
    perceiver: Perceiver,
    now: Nanos,
    /// Edges of one step, in the order of time: the same memory for every step.
    pending: Vec<(usize, Edge)>,
    /// Edges that have yet to take effect behind their amplifiers, and when.
    rising: Vec<(Nanos, usize, Edge)>,
}

impl Display {
    /// Builds chips, amplifiers and wires, all at rest and off.
    ///
    /// # Errors
    /// A physical parameter that cannot be computed with, by name.
    pub fn new(config: &DisplayConfig) -> Result<Self, ParameterError> {
        let chip = |&(address, factor): &(u8, f64)| {
            let oscillator = Oscillator::from_factor(factor);
            Pca9685::new(Config {
                oscillator,
                ..Config::new(address)
            })
        };
        let segment = Segment::new(config.clock, config.boards.iter().map(chip).collect());
        let wire = |_: &Place| Wire::new(&config.wire, &config.skin, START_C);
        Ok(Self {
            i2c: Handle::new(segment),
            amplifiers: vec![
                Amplifier::new(config.amplifier.current, Pull::Down);
                config.boards.len()
            ],
            rise: config.amplifier.rise,
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
            wires: config.wires.iter().map(wire).collect::<Result<_, _>>()?,
            places: config.wires.clone(),
            parameters: config.wire,
            perceiver: Perceiver::new(config.perceiver),
            now: Nanos::ZERO,
            pending: Vec::new(),
            rising: Vec::new(),
        })
    }

    /// The bus that a driver holds.
    pub fn bus(&self) -> Handle {
        self.i2c.clone()
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
        let pending = &mut self.pending;
        self.i2c.with(|segment| {
            segment.set_now(to);
            for (board, chip) in segment.chips_mut().iter_mut().enumerate() {
                // A transaction may have carried a chip beyond `to`.
                let until = to.max(chip.now());
                chip.advance(until, &mut |edge| pending.push((board, edge)));
            }
        })?;
        // Stable: of edges at one instant the lower board comes first.
        self.pending.sort_by_key(|(_, edge)| edge.at);
        let mut until = to;
        for &(board, edge) in &self.pending {
            until = until.max(edge.at);
            let at = takes_effect(&edge, self.rise);
            self.rising.push((at, board, edge));
            sink(OutputEdge {
                at: edge.at,
                board: board as u8, // at most 16 chips on a bus
                channel: edge.channel.0,
                high: edge.pin == Pin::High,
            });
        }
        self.pending.clear();
        self.rising.sort_by_key(|(at, ..)| *at);
        let due = self.rising.partition_point(|(at, ..)| *at <= until);
        for index in 0..due {
            let (at, board, edge) = self.rising[index];
            let change = self.amplifiers.get_mut(board).and_then(|a| a.edge(edge));
            if change.is_some() {
                self.flow(at);
            }
        }
        self.rising.drain(..due);
        self.now = self.now.max(to);
        Ok(())
    }

    /// Lets the currents that the amplifiers ask for flow from `at` on, as far as the supply has them.
    fn flow(&mut self, at: Nanos) {
        for (load, place) in self.loads.iter_mut().zip(&self.places) {
            let amplifier = self.amplifiers.get(usize::from(place.board));
            let current = amplifier.map(|a| a.current(Channel(place.channel)));
            load.asked = current.unwrap_or_default().amps();
        }
        self.source.share(&mut self.loads);
        let mut sum = 0.0;
        for (load, wire) in self.loads.iter().zip(&mut self.wires) {
            sum += load.amps;
            wire.set_current(at, load.amps);
        }
        self.supply.set(at, Milliamps((sum * 1e3).round() as u32));
    }

    /// Breaks or repairs the amplifier of a wire, now; a wire that is not there is left alone.
    pub fn set_fault(&mut self, wire: usize, fault: Option<AmplifierFault>) {
        let Some(place) = self.places.get(wire) else {
            return;
        };
        let (now, channel) = (self.now, Channel(place.channel));
        let amplifier = self.amplifiers.get_mut(usize::from(place.board));
        if amplifier
            .and_then(|a| a.set_fault(now, channel, fault))
            .is_some()
        {
            self.flow(now);
        }
    }

    /// Temperature of a wire now, degrees C; `None` if there is no such wire.
    pub fn wire_c(&mut self, wire: usize) -> Option<f64> {
        let now = self.now;
        self.wires.get_mut(wire).map(|w| w.temperature(now))
    }

    /// What a person meets of the bursts that began at or after `since`: every wire that had one.
    pub fn vibrations(&self, since: Nanos) -> Vec<Vibration> {
        let met = |(wire, place): (&Wire, &Place)| {
            let burst = wire.burst().filter(|b| b.start >= since)?;
            Some(Vibration {
                position_mm: (f64::from(place.at.x), f64::from(place.at.y)),
                amplitude_um: self.perceiver.amplitude_of_burst(&self.parameters, &burst),
            })
        };
        let wires = self.wires.iter().zip(&self.places);
        wires.filter_map(met).collect()
    }

    /// Where a person feels them; `None` is a break: no wire above threshold.
    pub fn feel(&self, since: Nanos) -> Option<Felt> {
        self.perceiver.feel(&self.vibrations(since))
    }

    /// What the run came to until now.
    pub fn totals(&mut self) -> DisplayTotals {
        let mut totals = DisplayTotals {
            peak_supply: self.supply.peak().0,
            hottest_wire: (f64::NEG_INFINITY, 0),
            hottest_skin_c: f64::NEG_INFINITY,
            ..DisplayTotals::default()
        };
        for (index, wire) in self.wires.iter_mut().enumerate() {
            let peaks = wire.peaks(self.now);
            totals.electrical_j += wire.energy(self.now).electrical_j;
            if peaks.wire_c > totals.hottest_wire.0 {
                totals.hottest_wire = (peaks.wire_c, index);
            }
            totals.hottest_skin_c = totals.hottest_skin_c.max(peaks.shallow_c);
        }
        totals
    }
}
