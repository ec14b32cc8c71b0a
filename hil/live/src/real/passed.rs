//! State of the wires of hardware, which outlives a run: the next one passes no wire that is passed.

use palpate_buses::ledger::{Output, folder, keep_passed, passed};
use palpate_files::Setup;
use palpate_run::{Failure, pass};

use super::heat::{of_adapters, of_unit};
use crate::link::UnitPlace;

/// Words for a run whose wires an earlier one has passed.
const EARLIER: &str = "none: an earlier run has passed these wires since this machine's start, and they are assumed so";

/// Outputs that a setup drives, by the name of their hardware.
fn outputs(setup: &Setup) -> Result<Vec<(String, Vec<Output>)>, Failure> {
    let unit = UnitPlace::find(&setup.bench)?;
    let names = match &unit {
        Some(place) => vec![of_unit(place)],
        None => of_adapters(&setup.bench)?,
    };
    let mut all: Vec<(String, Vec<Output>)> =
        names.into_iter().map(|name| (name, Vec::new())).collect();
    let bench = &setup.bench.value;
    for (number, own) in bench.outputs.iter().enumerate() {
        let mut fingers = setup.fingers.iter();
        if !setup.fingers.is_empty() && !fingers.any(|finger| finger.wires.contains(&number)) {
            continue;
        }
        // A unit has buses of its own, an adapter is one.
        let (hardware, bus) = match unit {
            Some(_) => (0, own.bus),
            None => (usize::from(own.bus), 0),
        };
        if let Some((_, outputs)) = all.get_mut(hardware) {
            outputs.push(Output {
                bus,
                board: own.board,
                channel: own.channel,
            });
        }
    }
    Ok(all)
}

/// The setup of a run on hardware, with the state in which earlier runs left its wires.
///
/// # Errors
/// [`Failure::Device`] for hardware that the system does not know.
pub fn known(setup: &Setup) -> Result<Setup, Failure> {
    let mut known = setup.clone();
    if pass::is_due(setup) {
        let folder = folder();
        let are_passed = outputs(setup)?.iter().all(|(hardware, outputs)| {
            let kept = passed(&folder, hardware);
            outputs.iter().all(|output| kept.contains(output))
        });
        if are_passed {
            pass::set_passed(&mut known);
            known.told = Some(EARLIER.to_owned());
        }
    }
    Ok(known)
}

/// Keeps whether the wires of a setup are passed.
///
/// # Errors
/// [`Failure::Device`] where the folder or the disk does not take it.
pub fn keep(setup: &Setup, are_passed: bool) -> Result<(), Failure> {
    let folder = folder();
    for (hardware, outputs) in outputs(setup)? {
        keep_passed(&folder, &hardware, &outputs, are_passed)
            .map_err(|error| Failure::Device(error.to_string()))?;
    }
    Ok(())
}
