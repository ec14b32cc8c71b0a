//! Configuration of a bench's emulated display.

use palpate_core::illusion::DisplayWire;
use palpate_core::physics::ParameterError;
use palpate_emulators::display::amplifier::supply::SupplySource;
use palpate_emulators::display::amplifier::{AmplifierConfig, SetError};
use palpate_emulators::display::i2c::BusClock;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{DisplayConfig, WirePlace, WornDisplay};
use palpate_files::{Bench, Setup};

use crate::failure::Failure;
use crate::plan;

/// The emulated display of a bench: its chips and amplifiers, `wires` on a finger.
///
/// # Errors
/// [`Failure::Input`] for a bench that cannot be.
pub fn emulated(setup: &Setup, wires: &[DisplayWire]) -> Result<WornDisplay, Failure> {
    let bench = &setup.bench.value;
    plan::wires_only(&setup.bench, plan::NO_WIRES)?;
    let display = WornDisplay::new(&config(setup, wires)).map_err(no_bench(bench))?;
    // Refused only from inside another look at the segment, and there is none here.
    let _ = display.bus().with(|segment| {
        let chips = segment.chips_mut().iter_mut();
        chips.for_each(|chip| chip.set_external_clock(Nanos::ZERO, bench.drive.external_hz()));
    });
    Ok(display)
}

pub(super) fn no_bench(bench: &Bench) -> impl Fn(ParameterError) -> Failure {
    move |e| Failure::Input(format!("bench `{}`: {e}", bench.name))
}

/// Configuration of a bench's display with `wires` on a finger.
pub(super) fn config(setup: &Setup, wires: &[DisplayWire]) -> DisplayConfig {
    let bench = &setup.bench.value;
    let (wire, tissue) = plan::worn(setup);
    let place = |w: &DisplayWire| WirePlace {
        at: w.place,
        board: w.board.0,
        channel: w.channel.0,
    };
    DisplayConfig {
        boards: plan::boards(bench)
            .into_iter()
            .map(|a| (a, bench.drive.oscillator))
            .collect(),
        converters: (bench.dac.iter())
            .flat_map(|dac| dac.addresses.clone())
            .collect(),
        wires: wires.iter().map(place).collect(),
        amplifier: AmplifierConfig {
            current: plan::milliamps(bench.drive.current_ma),
            rise: Nanos((bench.amplifier.rise_us * 1e3).round() as u64),
            on_ohm: bench.amplifier.on_ohm,
            set: bench.dac.as_ref().map(|dac| SetError {
                gain: dac.gain,
                offset_ma: dac.offset_ma,
            }),
        },
        source: SupplySource {
            volts: bench.amplifier.supply_v.unwrap_or(f64::INFINITY),
            ohm: bench.amplifier.supply_ohm,
        },
        wire,
        tissue,
        clock: BusClock::Fast,
    }
}
