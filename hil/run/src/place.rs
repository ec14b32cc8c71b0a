//! Where a display stands among those of its bench, and the setup that each of several fingers would have alone.

use std::borrow::Cow;
use std::collections::BTreeSet;

use palpate_core::contact::Scope;
use palpate_files::{Bench, Fault, Finger, Setup};

/// A display's boards, wires and modules, by the numbers that bench and scene have for them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Its name; none for the only display of a bench.
    pub name: Option<String>,
    /// The I2C bus of its boards.
    pub bus: u8,
    /// Its boards, in its own order.
    pub boards: Vec<u8>,
    /// Its first wire.
    pub first_wire: usize,
    /// How many wires it has.
    pub wires: usize,
    /// Its modules, in its own order; none for the only display of a bench, whose modules are the skin's.
    pub modules: Vec<usize>,
}

impl Place {
    /// Of the only display of a bench.
    #[must_use]
    pub fn whole(bench: &Bench) -> Self {
        Self {
            name: None,
            bus: 0,
            boards: (0..bench.boards() as u8).collect(), // at most 16
            first_wire: 0,
            wires: bench.outputs.len(),
            modules: Vec::new(),
        }
    }

    fn of(finger: &Finger, bench: &Bench) -> Self {
        let all: BTreeSet<(u8, u8)> = bench.outputs.iter().map(|o| (o.bus, o.board)).collect();
        let outputs = &bench.outputs[finger.wires.clone()];
        let own: BTreeSet<(u8, u8)> = outputs.iter().map(|o| (o.bus, o.board)).collect();
        let numbered = all.iter().zip(0..).filter(|(board, _)| own.contains(board));
        Self {
            name: Some(finger.name.clone()),
            bus: outputs.first().map_or(0, |o| o.bus),
            boards: numbered.map(|(_, number)| number).collect(),
            first_wire: finger.wires.start,
            wires: finger.wires.len(),
            modules: finger.modules.clone(),
        }
    }

    /// Its own number of a board of the bench, if it is on that board.
    #[must_use]
    pub fn own_board(&self, board: usize) -> Option<usize> {
        self.boards.iter().position(|b| usize::from(*b) == board)
    }

    /// Its own number of a wire of the bench, if it has that wire.
    #[must_use]
    pub fn own_wire(&self, wire: usize) -> Option<usize> {
        let own = wire.checked_sub(self.first_wire);
        own.filter(|own| *own < self.wires)
    }

    /// Whether a fault is done to it.
    fn meets(&self, fault: &Fault) -> bool {
        fault.kind.is_of_display()
            && fault.bus.is_none_or(|bus| bus == self.bus)
            && fault.board.is_none_or(|b| self.own_board(b).is_some())
            && fault.wire.is_none_or(|w| self.own_wire(w).is_some())
    }

    /// The identity of the dice that its bus throws: no display's luck depends on another's.
    pub(crate) fn dice(&self) -> String {
        let bus = "actuator bus";
        let named = self.name.as_ref().map(|name| format!("{bus} of {name}"));
        named.unwrap_or_else(|| bus.to_owned())
    }
}

/// Every finger of a setup with the setup that it would have alone: its modules, its wires, and its static share of the
/// supply. That share is a wire's current per board, so that no two wires of a board are on at one instant, and the
/// voltage that is left while a wire of every other board is on.
pub(crate) fn fingers(setup: &Setup) -> Vec<(Place, Setup)> {
    let bench = &setup.bench.value;
    let alone = |finger: &Finger| {
        let place = Place::of(finger, bench);
        let mut alone = setup.clone();
        alone.fingers.clear();
        alone.display = finger.display.clone();
        alone.person = finger.person.clone();
        alone.wearer.clone_from(&finger.wearer);
        let modules = &setup.sensor.value.modules;
        let own = finger.modules.iter().map(|m| modules[*m].clone());
        alone.sensor.value.modules = own.collect();
        let scene = &mut alone.scene.value;
        scene.drives = 0;
        scene.fingers.clear();
        scene.faults.retain(|fault| place.meets(fault));
        // A finger's rule says what is one skin, whatever the scene says of a bench with one display.
        scene.compression.scope = match finger.merged {
            true => Scope::Skin,
            false => Scope::Module,
        };
        let own = &mut alone.bench.value;
        own.name = format!("{}: {}", bench.name, finger.name);
        own.displays.clear();
        own.outputs = bench.outputs[finger.wires.clone()].to_vec();
        own.drive.supply_limit_ma = place.boards.len() as f64 * bench.drive.current_ma;
        let others = bench.boards() - place.boards.len();
        let sag = others as f64 * bench.drive.current_ma * 1e-3 * bench.amplifier.supply_ohm;
        own.amplifier.supply_v = bench.amplifier.supply_v.map(|volts| volts - sag);
        (place, alone)
    };
    setup.fingers.iter().map(alone).collect()
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
