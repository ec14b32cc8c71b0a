//! The emulated person for the emulators, and the person whom the loop believes in.

use palpate_emulators::person::channels::Person;

use palpate_files::{FileError, PersonFile, Setup, load_person};

/// Thresholds and growths of a person's file.
pub const fn person(file: &PersonFile) -> Person {
    Person {
        vibration_um: file.vibration.threshold_um.value,
        flutter_um: file.flutter.threshold_um.value,
        growth: [file.vibration.growth.value, file.flutter.growth.value],
    }
}

/// Person whom the loop takes its wearer for: never the emulated one.
pub(super) fn believed(setup: &Setup) -> Result<Person, FileError> {
    let typical = person(&load_person("typical")?.value);
    let wearer = setup.wearer.as_ref().map(|wearer| &wearer.value);
    let stated = |of: fn(&palpate_files::Wearer) -> Option<f64>| wearer.and_then(of);
    Ok(Person {
        vibration_um: stated(|w| w.vibration_um).unwrap_or(typical.vibration_um),
        flutter_um: stated(|w| w.flutter_um).unwrap_or(typical.flutter_um),
        ..typical
    })
}
