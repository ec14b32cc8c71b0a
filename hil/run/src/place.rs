//! Place of a display among those of its bench, and the setup that each of several fingers would have alone.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::Range;

use palpate_core::contact::Scope;
use palpate_core::units::Duration;
use palpate_emulators::display::i2c::BusClock;
use palpate_files::{Bench, Fault, Felt, Finger, Setup};

use crate::plan;

/// A display's boards, wires and modules, by the numbers that bench and scene have for them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Name of the display; `None` for the only one of a bench.
    pub name: Option<String>,
    /// The I2C bus of its boards.
    pub bus: u8,
    /// Bench numbers of the display's boards, in its own order.
    pub boards: Vec<u8>,
    /// Channels of each board that belong to the display, a bit each: all of them where no other display is on it.
    pub channels: Vec<u16>,
    /// `true` where no other display is on the bus.
    pub alone: bool,
    /// Bench number of the display's first wire.
    pub first_wire: usize,
    /// Number of the display's wires.
    pub wires: usize,
    /// Skin numbers of the display's modules, in its own order; empty for the only display of a bench, whose modules
    /// are the skin's.
    pub modules: Vec<usize>,
}

impl Place {
    /// Place of the only display of a bench.
    #[must_use]
    pub fn whole(bench: &Bench) -> Self {
        Self {
            wires: bench.outputs.len(),
            ..Self::of_bus(0, 0..bench.boards() as u8) // at most 16
        }
    }

    fn new(finger: &Finger, bench: &Bench) -> Self {
        let all: BTreeSet<(u8, u8)> = bench.outputs.iter().map(|o| (o.bus, o.board)).collect();
        let outputs = &bench.outputs[finger.wires.clone()];
        let own: BTreeSet<(u8, u8)> = outputs.iter().map(|o| (o.bus, o.board)).collect();
        let numbered = all.iter().zip(0..).filter(|(board, _)| own.contains(board));
        let channels = |board: &(u8, u8)| {
            let here = outputs.iter().filter(|o| (o.bus, o.board) == *board);
            here.fold(0, |all, output| all | 1 << output.channel)
        };
        Self {
            name: Some(finger.name.clone()),
            bus: outputs.first().map_or(0, |o| o.bus),
            boards: numbered.map(|(_, number)| number).collect(),
            channels: own.iter().map(channels).collect(),
            alone: true,
            first_wire: finger.wires.start,
            wires: finger.wires.len(),
            modules: finger.modules.clone(),
        }
    }

    /// Place of a whole bus, with its boards but without displays.
    pub(crate) fn of_bus(bus: u8, boards: Range<u8>) -> Self {
        Self {
            name: None,
            bus,
            channels: vec![u16::MAX; boards.len()],
            boards: boards.collect(),
            alone: true,
            first_wire: 0,
            wires: 0,
            modules: Vec::new(),
        }
    }

    /// Tells the display which bus and boards it has to itself among `all` displays.
    fn beside(&mut self, all: &[Self]) {
        let others = || all.iter().filter(|other| other.name != self.name);
        self.alone = others().all(|other| other.bus != self.bus);
        for (board, channels) in self.boards.iter().zip(&mut self.channels) {
            if !all
                .iter()
                .any(|o| o.name != self.name && o.boards.contains(board))
            {
                *channels = u16::MAX;
            }
        }
    }

    /// The longest that the transfers of one of these may hold up its own: another display of its bus switches its channels
    /// off one by one and starts its boards anew, ten transfers each.
    fn wait_for(&self, all: &[Self], bench: &Bench) -> Duration {
        let off = BusClock::Fast.write_time(2).as_micros();
        let other = BusClock::Fast.write_time(3).as_micros();
        let others = all
            .iter()
            .filter(|o| o.name != self.name && o.bus == self.bus);
        let restart = |o: &Self| o.wires as u64 * off + 10 * o.boards.len() as u64 * other;
        // Where currents are set: two commands per converter, and each output to zero and read back.
        let currents = |o: &Self| match &bench.dac {
            Some(_) => plan::current_wait(o.wires) + 2 * o.boards.len() as u64 * other,
            None => 0,
        };
        let all = others.map(|o| restart(o) + currents(o));
        Duration::from_micros(all.max().unwrap_or(0))
    }

    /// The display's own number of a board of the bench; `None` where it is not on that board.
    #[must_use]
    pub fn own_board(&self, board: usize) -> Option<usize> {
        self.boards.iter().position(|b| usize::from(*b) == board)
    }

    /// The display's own number of a module of the skin; `None` where it lacks that module.
    #[must_use]
    pub fn own_module(&self, module: usize) -> Option<usize> {
        self.modules.iter().position(|own| *own == module)
    }

    /// The display's own number of a wire of the bench; `None` where it lacks that wire.
    #[must_use]
    pub fn own_wire(&self, wire: usize) -> Option<usize> {
        let own = wire.checked_sub(self.first_wire);
        own.filter(|own| *own < self.wires)
    }

    /// Tells whether a fault is done to the display's bus or boards.
    pub(crate) fn is_of_boards(&self, fault: &Fault) -> bool {
        fault.kind.is_of_display()
            && fault.wire.is_none()
            && fault.bus.is_none_or(|bus| bus == self.bus)
            && fault.board.is_none_or(|b| self.own_board(b).is_some())
    }

    /// Tells whether a fault is done to one of the display's wires.
    fn is_of_wires(&self, fault: &Fault) -> bool {
        fault.kind.is_of_display() && fault.wire.is_some_and(|w| self.own_wire(w).is_some())
    }
}

/// Every finger of a setup with the setup that it would have alone: its modules, its wires, and its static share of the
/// supply. That share is a wire's current per board, so that no two wires of a board are on at one instant, and the
/// voltage that is left while a wire of every other board is on. Of its hand's power it has an equal share. Faults of boards and their buses are no finger's.
pub fn fingers(setup: &Setup) -> Vec<(Place, Setup)> {
    let bench = &setup.bench.value;
    let places: Vec<Place> = setup.fingers.iter().map(|f| Place::new(f, bench)).collect();
    // A texture takes the boards' own frequency, and boards that share have one.
    let any_textured = setup.fingers.iter().any(|f| f.texture.is_some());
    let alone = |(index, (finger, place)): (usize, (&Finger, &Place))| {
        let mut place = place.clone();
        place.beside(&places);
        let mut alone = setup.clone();
        alone.fingers.clear();
        alone.bus_wait = place.wait_for(&places, bench);
        if finger.memory.is_some() {
            alone.memory.clone_from(&finger.memory);
        }
        alone.display = finger.display.clone();
        alone.person = finger.person.clone();
        alone.wearer.clone_from(&finger.wearer);
        let modules = &setup.sensor.value.modules;
        let own = finger.modules.iter().map(|m| modules[*m].clone());
        alone.sensor.value.modules = own.collect();
        let scene = &mut alone.scene.value;
        scene.drives = 0;
        scene.fingers.clear();
        scene.faults.retain(|fault| place.is_of_wires(fault));
        scene.seats.retain_mut(|seat| {
            let own = place.own_wire(seat.wire);
            seat.wire = own.unwrap_or(seat.wire);
            own.is_some()
        });
        alone.section = format!("fingers[{index}].");
        scene.strokes.clone_from(&finger.strokes);
        let texture = finger.texture.clone().map(|(felt, stroked)| {
            let module = felt.module.and_then(|m| place.own_module(m));
            scene.texture = Some(Felt { module, ..felt });
            stroked
        });
        alone.texture = texture;
        // A finger's rule says what is one skin, whatever the scene says of a bench with one display.
        scene.compression.scope = match finger.merged {
            true => Scope::Skin,
            false => Scope::Module,
        };
        let limits = &mut alone.limits.value.limits;
        *limits = limits.of_hand(hand_of(setup, finger).count() as u64);
        let own = &mut alone.bench.value;
        own.name = format!("{}: {}", bench.name, finger.name);
        own.displays.clear();
        own.outputs = bench.outputs[finger.wires.clone()].to_vec();
        if any_textured {
            own.drive.pwm_hz.get_or_insert(plan::PWM_HZ);
        }
        if let Some((own, all)) = own.dac.as_mut().zip(bench.dac.as_ref()) {
            let boards = place.boards.iter().map(|board| usize::from(*board));
            let own_ones = boards.filter_map(|board| all.addresses.get(board).copied());
            own.addresses = own_ones.collect();
        }
        let most_ma = bench.most_ma();
        own.drive.supply_limit_ma = place.boards.len() as f64 * most_ma;
        let others = bench.boards() - place.boards.len();
        let sag = others as f64 * most_ma * 1e-3 * bench.amplifier.supply_ohm;
        own.amplifier.supply_v = bench.amplifier.supply_v.map(|volts| volts - sag);
        (place, alone)
    };
    let fingers = setup.fingers.iter().zip(&places).enumerate();
    fingers.map(alone).collect()
}

/// The fingers on the hand of this one, itself among them.
pub(crate) fn hand_of<'a>(setup: &'a Setup, one: &'a Finger) -> impl Iterator<Item = &'a Finger> {
    let fingers = setup.fingers.iter();
    fingers.filter(|finger| finger.hand == one.hand)
}

/// The setup of a pass that looks at contacts alone: with any one of several displays, on the whole skin.
pub(crate) fn looking(setup: &Setup) -> Cow<'_, Setup> {
    match fingers(setup).into_iter().next() {
        None => Cow::Borrowed(setup),
        Some((_, mut first)) => {
            first.sensor.clone_from(&setup.sensor);
            Cow::Owned(first)
        }
    }
}

#[cfg(test)]
#[path = "place_tests.rs"]
mod tests;
