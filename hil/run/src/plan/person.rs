//! The emulated person as the emulators take it.

use palpate_emulators::person::perceiver::PerceiverParameters;

use palpate_files::PerceiverFile;

/// Gain and threshold of a perceiver file.
pub fn perceiver(file: &PerceiverFile) -> PerceiverParameters {
    PerceiverParameters {
        fitted_gain: file.fitted_gain,
        threshold_um: file.threshold_um,
        expansion: file.expansion_ppm * 1e-6,
        full_pulses: file.full_pulses,
    }
}
