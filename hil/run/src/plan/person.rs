//! The emulated person as the emulators take it.

use palpate_emulators::person::channels::Person;

use palpate_files::PersonFile;

/// Thresholds and growths of a person's file.
pub const fn person(file: &PersonFile) -> Person {
    Person {
        vibration_um: file.vibration.threshold_um.value,
        flutter_um: file.flutter.threshold_um.value,
        growth: [file.vibration.growth.value, file.flutter.growth.value],
    }
}
