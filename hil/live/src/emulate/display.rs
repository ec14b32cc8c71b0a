//! A bench's emulated display whose bus is served: its chips, the edges of their outputs, and the currents in its
//! wires.

use palpate_core::codec::pca9685::{FULL, LED0_ON_L};
use palpate_core::units::Instant;
use palpate_emulators::display::i2c::I2cSegment;
use palpate_emulators::display::pca9685::{Pca9685, Pin};
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{OutputEdge, WornDisplay};
use palpate_files::Setup;
use palpate_run::display_end::OutputEnable;
use palpate_run::wires;
use palpate_run::{Failure, plan};

use super::record::{Flowed, PinEdge};

/// The chips with wires on a finger, on a time line that others set.
pub(crate) struct ServedDisplay {
    pub(crate) worn: WornDisplay,
    /// 7-bit addresses of the chips, by number.
    addresses: Vec<u8>,
    flowed: Flowed,
    /// The time of the last change of an output, or of the line that cuts all of them.
    last_edge: Nanos,
    /// `true` while the line on the chips' OE pins is high.
    cut: bool,
}

impl ServedDisplay {
    /// Chips at rest.
    ///
    /// # Errors
    /// [`Failure::Input`] for a display that cannot be.
    pub(crate) fn new(setup: &Setup) -> Result<Self, Failure> {
        Ok(Self {
            worn: wires::emulated(setup, plan::display(setup)?.wires())?,
            addresses: plan::boards(&setup.bench.value),
            flowed: Flowed::new(&setup.bench.value.outputs),
            last_edge: Nanos::ZERO,
            cut: false,
        })
    }

    /// Lets time pass until `now`. Every edge goes to `tell`, dated by a clock that stood at `epoch_ns` when this time line
    /// began.
    ///
    /// # Errors
    /// [`Failure::Device`] if the emulator contradicts itself; the first failure of `tell`.
    pub(crate) fn advance(
        &mut self,
        now: Nanos,
        epoch_ns: u64,
        mut tell: impl FnMut(PinEdge) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let (addresses, flowed) = (&self.addresses, &mut self.flowed);
        let last_edge = &mut self.last_edge;
        let mut told = Ok(());
        let advanced = self.worn.advance(now, &mut |edge: OutputEdge| {
            *last_edge = edge.at;
            let edge = PinEdge {
                t_ns: epoch_ns + edge.at.0,
                chip: addresses.get(usize::from(edge.board)).map_or(0, |a| *a),
                channel: edge.channel,
                high: edge.high,
            };
            flowed.edge(&edge);
            if told.is_ok() {
                told = tell(edge);
            }
        });
        advanced.map_err(|e| Failure::Device(format!("emulated display: {e}")))?;
        told
    }

    /// The level of the line on the chips' OE pins from `now` on; high cuts.
    pub(super) fn set_output_enable(&mut self, now: Nanos, cut: bool) {
        let at = Instant::from_micros(now.as_micros());
        OutputEnable::set_enabled(&self.worn, at, !cut);
        (self.last_edge, self.cut) = (now, cut);
    }

    /// Time of the last change of an output.
    pub(super) const fn last_edge(&self) -> Nanos {
        self.last_edge
    }

    /// The address of each chip, and whether the chip drives or is going to drive an output; none while the bus cannot be
    /// looked at.
    pub(crate) fn driving(&self) -> Vec<(u8, bool)> {
        let state = |chip: &Pca9685| (chip.config().address, drives(chip, self.cut));
        let look = |s: &mut I2cSegment| s.chips().iter().map(state).collect();
        self.worn.bus().with(look).unwrap_or_default()
    }

    /// Counts of transfers, edges and hazards so far.
    pub(crate) fn flowed(&mut self) -> Flowed {
        self.flowed.totals(&self.worn.totals());
        let sum = |s: &mut I2cSegment| s.chips().iter().map(Pca9685::hazard_count).sum();
        self.flowed.hazards = self.worn.bus().with(sum).unwrap_or_default();
        self.flowed.clone()
    }
}

/// Tells whether an output is high, or a running chip that is not cut has a channel without the full-off bit and with a
/// pulse.
fn drives(chip: &Pca9685, cut: bool) -> bool {
    let high = chip.pins().contains(&Pin::High);
    high || !cut
        && chip.is_running()
        && (0..16).any(|channel| {
            let [on_l, on_h, off_l, off_h] =
                [0, 1, 2, 3].map(|byte| chip.register(LED0_ON_L + 4 * channel + byte));
            let off = off_h & FULL != 0;
            !off && (on_h & FULL != 0 || (on_l, on_h) != (off_l, off_h))
        })
}
