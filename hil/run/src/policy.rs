//! Differences between an emulated, a replayed and a real bench, as values. Every line that acts on them is shared.

use palpate_core::units::Duration;
use palpate_files::{Bench, BenchKind, Setup};

use crate::failure::Failure;

/// Longest time between two calls of the loop, as a real host would call it.
pub(crate) const TICK: Duration = Duration::from_millis(1);

/// Stops of the guard that end by themselves once their cause is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LatchPolicy {
    /// All of them: an emulated wearer cannot look at the bench.
    Reopens,
    /// Only the stop by a failed transfer, after the boards were started anew and read back. Any other stays until a
    /// person has looked.
    Stays,
}

/// Values in which benches differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Policy {
    /// Time for which an actuator bus may be dead before the run ends.
    pub give_up: Duration,
    /// Time between two tries of a dead actuator bus.
    pub retry: Duration,
    /// `true` to wait for an actuator bus that is dead from the start as well.
    pub waits_at_start: bool,
    /// Stops that end by themselves.
    pub latch: LatchPolicy,
}

impl Policy {
    /// Policy of emulated hardware and recordings.
    pub const EMULATED: Self = Self {
        give_up: Duration::from_millis(100),
        retry: Duration::from_millis(1),
        waits_at_start: true,
        latch: LatchPolicy::Reopens,
    };
    /// Policy of an emulated driver unit: a network that is gone comes back.
    pub const UNIT: Self = Self {
        give_up: Duration::from_millis(3000),
        ..Self::EMULATED
    };
    /// Policy of an emulated bench, with a driver unit or without.
    #[must_use]
    pub const fn emulated(unit: bool) -> Self {
        if unit { Self::UNIT } else { Self::EMULATED }
    }

    /// Policy of hardware: a USB plug that was pulled may come back, a person has to look after a stop.
    pub const REAL: Self = Self {
        give_up: Duration::from_millis(3000),
        retry: Duration::from_millis(20),
        waits_at_start: false,
        latch: LatchPolicy::Stays,
    };
}

/// Refuses to look on where the guard is not the last word.
pub(crate) fn refuse_observed(setup: &Setup) -> Result<(), Failure> {
    let bench = &setup.bench.value;
    match &bench.unit {
        Some(_) if setup.is_observed() => Err(Failure::Input(format!(
            "bench `{}`: expected a bench without [unit] for --observe: a unit has a guard of its own",
            bench.name
        ))),
        _ => Ok(()),
    }
}

/// Refuses hardware: emulated data must never be recorded as real.
pub(crate) fn refuse_hardware(bench: &Bench) -> Result<(), Failure> {
    if bench.unit_address().is_some() {
        return Err(Failure::Input(format!(
            "bench `{}`: expected a bench without [unit] address: only `hil run` drives a unit over a network",
            bench.name
        )));
    }
    match bench.kind {
        BenchKind::Emulated => Ok(()),
        BenchKind::Real => Err(Failure::Input(format!(
            "bench `{}`: expected kind = \"emulated\", found \"real\": only the program `hil` opens hardware",
            bench.name
        ))),
    }
}
