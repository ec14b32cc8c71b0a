//! The programs of an image over the rig. They are the same on every machine; a machine adds its processor and its network.

use embedded_hal::digital::OutputPin;
use palpate_core::guard::{Guard, HARD, Limits, Plant};
use palpate_core::illusion::DisplayWire;
use palpate_core::peltier::Regulator;
use palpate_core::physics::{PeltierParameters, Thermistor};
use palpate_core::units::Milliamps;
use palpate_unit::{Settings, Unit};

use super::{Bridge, Bus, Network, Oe, Rig, Wires};
use crate::serve::Link;
use crate::{ANSWER, Arena, Processor, QUESTION, answer, fingertips, serve};

/// The wires of a unit over the rig: two fingertips of eight.
pub static WIRES: [DisplayWire; 16] = fingertips(8);
/// 7-bit addresses of the unit's boards.
pub const ADDRESSES: [u8; 2] = [0x40, 0x41];
/// Limits of the unit: a supply of 3 A, else the hard ones.
pub const LIMITS: Limits = Limits {
    supply: Milliamps(3000),
    ..HARD
};

/// Serves a unit under this key over the rig's boards, and its Peltier module if it has one, for ever. `network` is its link; the rig's own for runs that repeat.
///
/// # Panics
/// On settings that no unit can have, and for what allocates once the unit is built. A panic of an image is a reset.
#[allow(
    clippy::panic,
    reason = "a panic of an image is a reset, with everything off"
)]
pub fn unit<'r, W: Wires, C: Fn() -> u64, L: Link, const HEAP: usize>(
    rig: &'r Rig<W, C>,
    heap: &Arena<HEAP>,
    processor: &mut impl Processor,
    key: &[u8; 32],
    network: impl FnOnce(&'r Rig<W, C>) -> L,
) -> ! {
    let mut oe = Oe(rig);
    // Outputs off before anything else; the unit then says so to the chips.
    let _ = oe.set_high();
    let settings = Settings {
        key,
        boot: rig.boot(),
        wires: &WIRES,
        addresses: &ADDRESSES,
        limits: LIMITS,
        plant: Plant::default(),
        // Software doubles would take 28 ms per stimulus on a Cortex-M0+: longer than the watchdog waits.
        worn: None,
        converters: None,
    };
    let mut link = network(rig);
    let regulator = || Regulator::new(PeltierParameters::default(), Thermistor::default());
    let module = Bridge::new(rig).map(|bridge| (bridge, regulator()));
    let Ok(unit) = Unit::warming(&settings, (Bus(rig), oe), module) else {
        panic!("settings that no unit can have");
    };
    heap.close();
    serve(unit, processor, &mut link)
}

/// Serves a unit, as [`unit`] does, over the rig's network: all
/// of its time is virtual, and every run of it is the same.
pub fn lockstep<W: Wires, C: Fn() -> u64, const HEAP: usize>(
    rig: &Rig<W, C>,
    heap: &Arena<HEAP>,
    processor: &mut impl Processor,
    key: &[u8; 32],
) -> ! {
    unit(rig, heap, processor, key, Network::new)
}

/// The unit's guard alone, questioned by the rig for ever: its decisions, and what they cost by `ticks`.
///
/// # Panics
/// The panics of [`unit`].
#[allow(
    clippy::panic,
    reason = "a panic of an image is a reset, with everything off"
)]
pub fn guard<W: Wires, C: Fn() -> u64, const HEAP: usize>(
    rig: &Rig<W, C>,
    heap: &Arena<HEAP>,
    processor: &mut impl Processor,
    ticks: fn() -> u32,
) -> ! {
    let Ok(mut guard) = Guard::last_word(LIMITS, Plant::default(), &WIRES, None) else {
        panic!("a plant that no wire can have");
    };
    heap.close();
    let mut question = [0; QUESTION];
    let mut told = [0; ANSWER];
    loop {
        if let Some(length) = rig.question(&mut question) {
            let (length, took) = answer(&mut guard, &question[..length], ticks, &mut told);
            rig.tell(took, &told[..length]);
        }
        processor.feed();
    }
}
