//! The emulated person for the emulators, and the person whom the loop believes in.

use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_emulators::person::channels::{AreaThreshold, Person};

use palpate_files::{FileError, PersonFile, Setup, load_person};

/// Exponent of area where a file states none: energies of parts add up, 3 dB per doubling.
const SUMMATION: f64 = 0.5;
/// Square centimetres of a square metre.
const CM2: f64 = 1e4;

/// Thresholds of a person's file for one of these wires on this finger, and growths.
pub fn person(file: &PersonFile, wire: &WireParameters, tissue: &TissueParameters) -> Person {
    with_area(file, tissue.contact_width_m * wire.length_m * CM2)
}

/// Thresholds of a person's file for contacts of this area each, cm2, and growths.
pub(super) fn with_area(file: &PersonFile, own_cm2: f64) -> Person {
    let um = file.vibration.threshold_um.value;
    let vibration_um = file.vibration.area_cm2.map_or(um, |area_cm2| {
        let summation = file.vibration.summation.unwrap_or(SUMMATION);
        let threshold = AreaThreshold {
            um,
            area_cm2,
            summation,
        };
        threshold.at(own_cm2)
    });
    Person {
        vibration_um,
        flutter_um: file.flutter.threshold_um.value,
        np2_um: file.np2.map(|np2| np2.threshold_um.value),
        growth: [file.vibration.growth.value, file.flutter.growth.value],
    }
}

/// Emulated person of a setup.
pub fn emulated_person(setup: &Setup) -> Person {
    on_bench(&setup.person.value, setup)
}

/// Person of a file with a bench's wires on the finger.
fn on_bench(file: &PersonFile, setup: &Setup) -> Person {
    let tissue = setup.bench.value.tissue.parameters();
    person(file, &super::wire(setup), &tissue)
}

/// Person whom the loop takes its wearer for: never the emulated one.
pub(super) fn believed(setup: &Setup) -> Result<Person, FileError> {
    let typical = on_bench(&load_person("typical")?.value, setup);
    let wearer = setup.wearer.as_ref().map(|wearer| &wearer.value);
    let stated = |of: fn(&palpate_files::Wearer) -> Option<f64>| wearer.and_then(of);
    Ok(Person {
        vibration_um: stated(|w| w.vibration_um).unwrap_or(typical.vibration_um),
        flutter_um: stated(|w| w.flutter_um).unwrap_or(typical.flutter_um),
        ..typical
    })
}
