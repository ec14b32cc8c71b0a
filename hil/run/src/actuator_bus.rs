//! An I2C bus of emulated boards that several displays share: its chips, its fault layer, and the scene's faults of both.

use palpate_core::physics::ParameterError;
use palpate_core::skin::Layout;
use palpate_core::units::Instant;
use palpate_emulators::display::i2c::fault::{I2cFault, I2cFaults, Shared};
use palpate_emulators::display::i2c::{BusClock, I2cHandle};
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{DisplayConfig, Rack, WornDisplay};
use palpate_files::{Drive, Fault, Setup};
use palpate_records::i2c::Transfer;
use palpate_records::trace::Event;

use crate::boards;
use crate::effects::{Faultable, FaultyDisplay};
use crate::place::Place;
use crate::plan;
use crate::script::{FaultReport, Script};

/// The chips of one bus, and the faults of the bus.
pub(crate) struct ActuatorBus {
    rack: Rack,
    i2c: Shared<I2cHandle>,
    /// Faults of the bus and its boards; the displays have those of wires.
    script: Script,
    drive: Drive,
    /// Number of the bus on the bench, and the numbers of its boards.
    place: Place,
}

impl ActuatorBus {
    /// Every bus of a bench that carries boards, nothing started yet. The fault layer's dice are thrown by bus.
    pub(crate) fn all(setup: &Setup, layout: &Layout, seed: u64) -> Vec<Self> {
        let bench = &setup.bench.value;
        let mut first = 0;
        let mut buses = Vec::new();
        for (number, addresses) in (0..).zip(plan::buses(bench)) {
            let count = addresses.len() as u8; // at most 16
            let place = Place::of_bus(number, first..first + count);
            let all = bench.dac.as_ref().map_or(&[][..], |dac| &dac.addresses);
            let converters = place.boards.iter().filter_map(|b| all.get(usize::from(*b)));
            let converters: Vec<u8> = converters.copied().collect();
            first += count;
            if count == 0 {
                continue;
            }
            let chips = addresses.iter().map(|a| (*a, bench.drive.oscillator));
            let rack = Rack::new(&chips.collect::<Vec<_>>(), &converters, BusClock::Fast);
            // Refused only from inside another look at the segment, and there is none here.
            let _ = rack.bus().with(|segment| {
                let hz = bench.drive.external_hz();
                let chips = segment.chips_mut().iter_mut();
                chips.for_each(|chip| chip.set_external_clock(Nanos::ZERO, hz));
            });
            let dice = format!("actuator bus {number}");
            let layer = I2cFault::new(rack.bus(), I2cFaults::default(), seed, &dice);
            let meets = |fault: &&Fault| place.is_of_boards(fault);
            buses.push(Self {
                script: Script::new(setup.scene.value.faults.iter().filter(meets), layout),
                i2c: Shared::new(layer),
                drive: bench.drive,
                rack,
                place,
            });
        }
        buses
    }

    /// Tells whether the display at `place` has its boards on this bus.
    pub(crate) fn carries(&self, place: &Place) -> bool {
        self.place.bus == place.bus
    }

    /// Connects a display, and returns it with the bus behind its fault layer.
    ///
    /// # Errors
    /// As [`WornDisplay::on`].
    pub(crate) fn connect(
        &self,
        place: &Place,
        config: &DisplayConfig,
    ) -> Result<(WornDisplay, Shared<I2cHandle>), ParameterError> {
        let on_bus = |board: &u8| self.place.own_board(usize::from(*board));
        let chips = place.boards.iter().filter_map(on_bus);
        let chips: Vec<_> = chips.zip(place.channels.iter().copied()).collect();
        Ok((
            WornDisplay::on(&self.rack, &chips, config)?,
            self.i2c.clone(),
        ))
    }

    /// Lets faults begin and end that are due at `now`; with `last` those that are on end.
    pub(crate) fn fail(&mut self, now: Instant, last: bool, events: &mut Vec<Event>) {
        let mut bench = Faultable {
            skin: None,
            display: Some(FaultyDisplay {
                i2c: &self.i2c,
                chips: self.rack.bus(),
                worn: None,
                drive: self.drive,
                place: &self.place,
                unit: None,
                heat: None,
                motors: None,
            }),
        };
        self.script.step(now, last, &mut bench, events);
    }

    /// Time at which the next fault begins or ends.
    pub(crate) fn next_fault(&self) -> Instant {
        self.script.next()
    }

    /// Reports of the bus's faults so far.
    pub(crate) fn faults(&self) -> Vec<FaultReport> {
        self.script.report()
    }

    /// Transfers that crossed the bus; empty where no log is kept.
    pub(crate) fn transfers(&self) -> Vec<Transfer> {
        boards::transfers(&self.rack.bus(), self.place.bus)
    }
}
