//! The display whose bus is served: wires or motors.

use palpate_emulators::display::i2c::{I2cHandle, I2cSegment};
use palpate_emulators::motors::WornMotors;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::WornDisplay;
use palpate_files::Setup;
use palpate_run::Failure;

use super::display::ServedDisplay;
use super::motors::ServedMotors;
use super::record::{PinEdge, Worked};

/// A display on a time line that others set.
pub(super) enum Served {
    /// Boards with wires.
    Wires(Box<ServedDisplay>),
    /// Drivers with motors.
    Motors(Box<ServedMotors>),
}

impl Served {
    /// Chips at rest; `oe`: a line is on the pins that cut them.
    ///
    /// # Errors
    /// [`Failure::Input`] for a display that cannot be, or that no bus reaches.
    pub(super) fn new(setup: &Setup, oe: bool) -> Result<Self, Failure> {
        Ok(match &setup.bench.value.haptics {
            None => Self::Wires(Box::new(ServedDisplay::new(setup)?)),
            Some(haptics) => Self::Motors(Box::new(ServedMotors::new(setup, haptics, oe)?)),
        })
    }

    /// The bus that is served.
    pub(super) fn bus(&self) -> I2cHandle {
        match self {
            Self::Wires(display) => display.worn.bus(),
            Self::Motors(motors) => motors.worn.bus(),
        }
    }

    /// Name of the chips that [`Self::driving`] has.
    pub(super) const fn kind(&self) -> &'static str {
        match self {
            Self::Wires(_) => "PCA9685",
            Self::Motors(_) => "DRV2605L, behind a TCA9548A",
        }
    }

    /// Wires and motors that scripted faults are done to.
    pub(super) const fn faulty(&mut self) -> (Option<&mut WornDisplay>, Option<&mut WornMotors>) {
        match self {
            Self::Wires(display) => (Some(&mut display.worn), None),
            Self::Motors(motors) => (None, Some(&mut motors.worn)),
        }
    }

    /// Lets time pass until `now`. Every edge of a wire's output goes to `tell`.
    ///
    /// # Errors
    /// Errors of [`ServedDisplay::advance`].
    pub(super) fn advance(
        &mut self,
        now: Nanos,
        epoch_ns: u64,
        tell: impl FnMut(PinEdge) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        match self {
            Self::Wires(display) => display.advance(now, epoch_ns, tell),
            Self::Motors(motors) => motors.advance(now),
        }
    }

    /// Level of the line on the chips' OE pins from `now` on; high cuts. Motors have none.
    pub(super) fn set_output_enable(&mut self, now: Nanos, cut: bool) {
        if let Self::Wires(display) = self {
            display.set_output_enable(now, cut);
        }
    }

    /// Time at which the last transfer has ended on the emulated wire, and the number of transfers.
    pub(super) fn transfers(&self) -> (Nanos, u64) {
        let look = |s: &mut I2cSegment| (s.now(), s.transactions());
        self.bus().with(look).unwrap_or_default()
    }

    /// Time of the last change of an output or of the last end of a transfer, whichever is later.
    pub(super) fn changed(&self) -> Nanos {
        let last = match self {
            Self::Wires(display) => display.last_edge(),
            Self::Motors(motors) => motors.last_change(),
        };
        last.max(self.transfers().0)
    }

    /// Address of each chip, or of the switch before it, and whether it drives or is going to drive an output.
    pub(super) fn driving(&self) -> Vec<(u8, bool)> {
        match self {
            Self::Wires(display) => display.driving(),
            Self::Motors(motors) => motors.driving(),
        }
    }

    /// Work of the outputs so far.
    pub(super) fn worked(&mut self) -> Worked {
        match self {
            Self::Wires(display) => Worked::Wires(display.flowed()),
            Self::Motors(motors) => Worked::Motors(motors.shaken()),
        }
    }
}
