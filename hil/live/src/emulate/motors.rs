//! A bench's emulated motors whose bus is served: which of them are driven, and for how long.

use palpate_emulators::display::i2c::I2cSegment;
use palpate_emulators::haptic::Drive;
use palpate_emulators::motors::WornMotors;
use palpate_emulators::time::Nanos;
use palpate_files::{BenchHaptics, Setup};
use palpate_run::Failure;
use palpate_run::plan::motors;

use super::record::{MotorRecord, Shaken};

/// Drivers behind their switches with motors on a finger, on a time line that others set.
pub(super) struct ServedMotors {
    pub(super) worn: WornMotors,
    motors: Vec<MotorRecord>,
    /// Time of the last change of an output.
    last_change: Nanos,
    /// Transfers at the last look.
    seen: u64,
}

impl ServedMotors {
    /// Motors at rest.
    ///
    /// # Errors
    /// [`Failure::Input`] for coils on a sound card, which no bus reaches, and a line to outputs that motors lack.
    pub(super) fn new(setup: &Setup, haptics: &BenchHaptics, oe: bool) -> Result<Self, Failure> {
        let name = &setup.bench.value.name;
        let bad = |e: &str| Failure::Input(format!("bench `{name}`: {e}"));
        if haptics.audio.is_some() {
            return Err(bad(
                "expected motors behind drivers on a bus, found voice coils on a sound card",
            ));
        }
        if oe {
            return Err(bad(
                "expected no --oe: drivers of motors have no line that cuts them in common",
            ));
        }
        let places = motors::places(setup, haptics);
        let (worn, _) = motors::worn(haptics, &places).map_err(|e| bad(&e.to_string()))?;
        let behind = motors::behind(haptics);
        Ok(Self {
            worn,
            motors: behind.into_iter().map(MotorRecord::new).collect(),
            last_change: Nanos::ZERO,
            seen: 0,
        })
    }

    /// Lets time pass until `now`, and looks at every output.
    ///
    /// # Errors
    /// [`Failure::Device`] if the emulator contradicts itself.
    pub(super) fn advance(&mut self, now: Nanos) -> Result<(), Failure> {
        // A transfer since the last look has changed what it changed at its end.
        self.look(now)?;
        let advanced = self.worn.advance(now);
        advanced.map_err(|e| Failure::Device(format!("emulated motors: {e}")))?;
        self.look(now)
    }

    fn look(&mut self, now: Nanos) -> Result<(), Failure> {
        let busy = |e| Failure::Device(format!("emulated motors: {e}"));
        let transfers = |s: &mut I2cSegment| (s.now(), s.transactions());
        let (end, count) = self.worn.bus().with(transfers).map_err(busy)?;
        let at = match count == self.seen {
            true => now,
            false => end,
        };
        self.seen = count;
        for (number, motor) in self.motors.iter_mut().enumerate() {
            let mut driven = false;
            let look = self.worn.on_chip(number, |chip| {
                driven = !matches!(chip.output(), Drive::Open | Drive::Steady(0.0));
            });
            look.map_err(busy)?;
            if motor.change(at, driven) {
                self.last_change = at;
            }
        }
        Ok(())
    }

    /// Time of the last change of an output.
    pub(super) const fn last_change(&self) -> Nanos {
        self.last_change
    }

    /// Each switch, or driver alone, and whether a motor behind it is driven.
    pub(super) fn driving(&self) -> Vec<(u8, bool)> {
        let mut chips: Vec<(u8, bool)> = Vec::new();
        for motor in &self.motors {
            match chips.iter_mut().find(|(chip, _)| *chip == motor.chip) {
                Some((_, driven)) => *driven |= motor.is_driven(),
                None => chips.push((motor.chip, motor.is_driven())),
            }
        }
        chips
    }

    /// Bursts and motion so far.
    pub(super) fn shaken(&self) -> Shaken {
        let totals = self.worn.totals();
        Shaken {
            motors: self.motors.clone(),
            face_um: totals.contactor_um,
            coil_rise_k: totals.coil_rise_k,
            drive_v: totals.drive_v,
        }
    }
}
