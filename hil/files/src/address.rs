//! Names on a bus that more than one device would answer to, and their refusal.

use std::path::{Component, Path, PathBuf};

use palpate_core::codec::pca9685::{ALLCALL_ADDRESS, SUBADR_RESET};

use super::error::FileError;
use super::source::Source;

/// The reason for which a chip strapped to this I2C address would share it; `None` for an address that is its alone.
fn why_shared(address: u8) -> Option<&'static str> {
    let sub_calls = SUBADR_RESET.iter().take(3).map(|register| register >> 1);
    match address {
        0x00..=0x07 => {
            Some("0x00 to 0x07 are reserved: 0x00 is the general call, which resets every chip")
        }
        0x08..=0x3F => Some("a PCA9685 has a fixed first bit, so its pins give 0x40 and up"),
        ALLCALL_ADDRESS => Some("0x70 is all-call, which every chip of the bus obeys"),
        0x78.. => Some("0x78 and up are reserved by the I2C bus for 10-bit addresses"),
        _ if sub_calls.into_iter().any(|call| call == address) => {
            Some("0x71, 0x72 and 0x74 are sub-calls, which other chips may obey")
        }
        _ => None,
    }
}

/// Checks that a chip has its I2C address to itself.
pub(super) fn check_chip(source: &Source, key: &str, address: u8) -> Result<(), FileError> {
    why_shared(address).map_or(Ok(()), |why| {
        let expected = format!(
            "0x40 to 0x77 without 0x70, 0x71, 0x72 and 0x74, as one chip alone answers there ({why})"
        );
        Err(source.bad(key, expected))
    })
}

/// Checks that every bus is listed once.
pub(super) fn check_once<'a>(
    source: &Source,
    key: &str,
    names: impl Iterator<Item = &'a Path>,
) -> Result<(), FileError> {
    repeated_bus(names).map_or(Ok(()), |(first, again)| {
        let expected =
            format!("a bus of its own: number {first} is the same, and so are its addresses");
        Err(source.bad(&format!("{key}[{again}]"), expected))
    })
}

/// Finds the first interface or adapter that a list names twice, after the place of its first mention. Two devices
/// with one address on such a pair would be one device, or answer together.
pub fn repeated_bus<'a>(names: impl Iterator<Item = &'a Path>) -> Option<(usize, usize)> {
    let names: Vec<PathBuf> = names.map(plain).collect();
    let before = |again: usize| names[..again].iter().position(|n| *n == names[again]);
    (0..names.len()).find_map(|again| Some((before(again)?, again)))
}

/// A path without `.`, `..` and doubled separators. Links are not followed: a file is read without its devices.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}
