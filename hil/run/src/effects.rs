//! Scripted faults in the terms of the emulated hardware and its fault layers.

use palpate_core::codec::uskin;
use palpate_core::peltier::SensorFault;
use palpate_core::skin::Layout;
use palpate_core::units::Instant;
use palpate_emulators::display::i2c::I2cHandle;
use palpate_emulators::display::i2c::fault::{I2cFaultKind, Shared};
use palpate_emulators::display::pca9685::Pca9685;
use palpate_emulators::display::peltier::PeltierHandle;
use palpate_emulators::haptic::MotorFault;
use palpate_emulators::motors::WornMotors;
use palpate_emulators::sensor::can::faults::{Counts, Effect, Faulty, Rule};
use palpate_emulators::sensor::rig::Handle;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::WornDisplay;

use palpate_files::{Drive, Fault, FaultKind};

use crate::place::Place;
use crate::unit::RemoteUnit;

/// Highest bit of a converter's code of 12 bits.
const HIGHEST_BIT: u8 = 11;

/// The hardware that faults are done to.
pub struct Faultable<'a> {
    /// The skin behind its fault layer; `None` for a recording.
    pub skin: Option<&'a mut Faulty<Handle>>,
    /// The display; `None` where its faults are done elsewhere.
    pub display: Option<FaultyDisplay<'a>>,
}

/// A display that faults are done to.
pub struct FaultyDisplay<'a> {
    /// The actuators' fault layer.
    pub i2c: &'a Shared<I2cHandle>,
    /// The I2C bus with the display's chips.
    pub chips: I2cHandle,
    /// Amplifiers and wires; `None` where their faults are done elsewhere.
    pub worn: Option<&'a mut WornDisplay>,
    /// The chips' clock while nothing is wrong.
    pub drive: Drive,
    /// Boards and wires of the display among those of the bench, by which faults name them.
    pub place: &'a Place,
    /// The driver unit and its network, where the bench has one.
    pub unit: Option<&'a mut RemoteUnit>,
    /// The Peltier module, where the bench has one.
    pub heat: Option<PeltierHandle>,
    /// The motors, where the bench has them.
    pub motors: Option<&'a mut WornMotors>,
}

/// Rules of the CAN fault layer for a fault, by identifier.
pub(super) fn rules(layout: &Layout, fault: &Fault) -> Vec<Rule> {
    let module = fault.module.and_then(|m| layout.modules().get(m));
    let Some((module, wires)) = module.and_then(|m| Some((m, m.wiring()?))) else {
        return Vec::new();
    };
    let Some(address) = module.address() else {
        return Vec::new();
    };
    let rule = |id: u16, mask: u16, effect: Effect| Rule {
        bus: Some(address.bus),
        id,
        mask,
        effect,
    };
    let line = |s: u8| u16::from(s) << 8 | u16::from(address.board);
    let taxel = |effect: Effect| {
        let place = fault.taxel.and_then(|t| wires.place(0, t));
        let id = place.and_then(|p| uskin::id(address.board, p));
        id.map(|id| rule(id, 0x7FF, effect)).into_iter().collect()
    };
    match fault.kind {
        FaultKind::TaxelFrozen => taxel(Effect::Frozen),
        FaultKind::ZeroTriplets => taxel(Effect::Zero),
        FaultKind::SdaDead => {
            vec![rule(line(fault.line.unwrap_or(0)), 0x70F, Effect::Silent)]
        }
        FaultKind::WrongModel => (wires.rows() / 2..wires.rows())
            .map(|s| rule(line(s), 0x70F, Effect::Zero))
            .collect(),
        _ => Vec::new(),
    }
}

/// A fault of the actuator bus in its layer's terms.
pub(super) const fn i2c_kind(kind: FaultKind) -> Option<I2cFaultKind> {
    match kind {
        FaultKind::I2cAddressNack => Some(I2cFaultKind::AddressNack),
        FaultKind::I2cDataNack => Some(I2cFaultKind::DataNack),
        FaultKind::I2cArbitrationLoss => Some(I2cFaultKind::ArbitrationLoss),
        FaultKind::I2cEio => Some(I2cFaultKind::Eio),
        FaultKind::I2cStretch => Some(I2cFaultKind::LongStretch),
        FaultKind::I2cStuck => Some(I2cFaultKind::StuckBus),
        _ => None,
    }
}

/// Does a fault to the display's Peltier module, or mends it. Returns `true` where the fault is done now.
pub(super) fn on_module(bench: &mut Faultable<'_>, kind: FaultKind, begins: bool) -> bool {
    let module = bench.display.as_mut().and_then(|d| d.heat.as_ref());
    let Some(module) = module else {
        return false;
    };
    let defect = match kind {
        FaultKind::FaceSensorOpen => SensorFault::Open,
        FaultKind::FaceSensorShort => SensorFault::Short,
        FaultKind::FaceSensorStale => SensorFault::Stale,
        _ => {
            module.with(|module| module.set_shorted(begins));
            return begins;
        }
    };
    module.with(|module| module.set_sensor(begins.then_some(defect)));
    begins
}

/// Does a fault to a motor, its driver or what is before it, or mends it.
pub(super) fn on_motor(bench: &mut Faultable<'_>, fault: &Fault, now: Instant, begins: bool) {
    let display = bench.display.as_mut();
    let Some(motors) = display.and_then(|d| d.motors.as_deref_mut()) else {
        return;
    };
    let (at, motor) = (Nanos::from(now), fault.motor.unwrap_or(0));
    let broken = match fault.kind {
        FaultKind::MotorStuck => Some(MotorFault::Stuck),
        FaultKind::MotorOpen => Some(MotorFault::Open),
        _ => None,
    };
    if let Some(coils) = motors.coils_mut() {
        match (fault.kind, begins) {
            (FaultKind::AudioUnderrun, true) => coils.card().card().starve(),
            (FaultKind::AudioStalled, _) => coils.card().card().set_stalled(begins),
            _ => {}
        }
        if let Some(coil) = coils.coil_mut(motor) {
            match fault.kind {
                FaultKind::CoilHot => coil.coil.set_covered(begins),
                _ if broken.is_some() => coil.fault = broken.filter(|_| begins),
                _ => {}
            }
        }
        return;
    }
    let done = match fault.kind {
        FaultKind::SwitchStuck => motors.on_switch(motor, |switch| switch.set_stuck(begins)),
        FaultKind::DriverHot => motors.on_chip(motor, |chip| chip.set_hot(at, begins)),
        FaultKind::CoilHot => motors.on_chip(motor, |chip| {
            chip.motor_mut().coil_mut().set_covered(begins);
        }),
        _ => motors.on_chip(motor, |chip| {
            chip.motor_mut().set_fault(broken.filter(|_| begins));
        }),
    };
    // Refused only from inside another look at the segment, and there is none here.
    let _ = done;
}

/// Does a fault to a converter of the display, or mends it.
pub(super) fn on_converter(bench: &Faultable<'_>, fault: &Fault, now: Instant, begins: bool) {
    let Some(display) = &bench.display else {
        return;
    };
    let at = Nanos::from(now);
    let own = fault.board.and_then(|board| display.place.own_board(board));
    // Refused only from inside another look at the segment, and there is none here.
    let _ = display.chips.with(|segment| {
        let converter = own.and_then(|c| segment.converters_mut().get_mut(c));
        match (converter, fault.kind, begins) {
            (Some(converter), FaultKind::ConverterDead, true) => converter.power_off(at),
            (Some(converter), FaultKind::ConverterDead, false) => converter.power_on(at),
            (Some(converter), FaultKind::ConverterBrownOut, true) => {
                converter.power_off(at);
                converter.power_on(at);
            }
            _ => {}
        }
    });
    let wire = fault.wire.and_then(|wire| display.place.own_wire(wire));
    let Some((wire, worn)) = wire.zip(display.worn.as_deref()) else {
        return;
    };
    worn.on_converter(wire, |converter, output| match (fault.kind, begins) {
        (FaultKind::ConverterStuck, stuck) => converter.set_stuck(output, stuck),
        (_, true) => converter.flip(at, output, HIGHEST_BIT),
        (_, false) => {}
    });
}

/// Frames, transfers or chips that a fault of this kind has hit so far; 0 where no layer counts them.
pub(super) fn counter(fault: &Fault, bench: &Faultable<'_>) -> u64 {
    if let Some(kind) = i2c_kind(fault.kind) {
        let display = bench.display.as_ref();
        return display.map_or(0, |d| d.i2c.with(|layer| layer.counts()[kind as usize]));
    }
    let counts = bench
        .skin
        .as_ref()
        .map_or(Counts::default(), |s| s.counts());
    match fault.kind {
        FaultKind::FramesLost => counts.lost,
        FaultKind::FramesDuplicated => counts.duplicated,
        FaultKind::FramesLate => counts.late,
        FaultKind::FramesCorrupted => counts.corrupted,
        FaultKind::FramesShort => counts.short,
        FaultKind::SdaDead => counts.silent,
        FaultKind::TaxelFrozen => counts.frozen,
        FaultKind::ZeroTriplets | FaultKind::WrongModel => counts.zero,
        _ => 0,
    }
}

/// Works on a chip of the display.
pub(super) fn on_chip(
    bench: &Faultable<'_>,
    chip: Option<usize>,
    now: Instant,
    work: &mut dyn FnMut(&mut Pca9685, Nanos),
) {
    let Some(display) = &bench.display else {
        return;
    };
    let own = chip.and_then(|board| display.place.own_board(board));
    // Refused only from inside another look at the segment, and there is none here.
    let _ = display.chips.with(|segment| {
        if let Some(chip) = own.and_then(|c| segment.chips_mut().get_mut(c)) {
            let at = chip.now().max(Nanos::from(now));
            work(chip, at);
        }
    });
}
