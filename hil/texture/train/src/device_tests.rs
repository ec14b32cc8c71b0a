//! Where there is no card, one line says what to do.

use super::*;

/// Whether there is a card to test on; said so where there is none.
#[cfg(feature = "gpu")]
pub fn has_card() -> bool {
    match Device::Gpu.name() {
        Ok(name) => println!("on {name}"),
        Err(why) => {
            println!("skipped: {why}");
            return false;
        }
    }
    true
}

#[cfg(not(feature = "gpu"))]
#[test]
fn a_card_in_a_build_without_is_told_how_to_be_built() {
    let line = "cargo build --release -p palpate-train --features gpu";
    let why = Device::Gpu.name().unwrap_err().to_string();
    assert!(why.contains(line), "{why}");
}
