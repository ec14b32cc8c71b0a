//! Constants burnt into an image: its key from text, and the usual layout of its wires.

use palpate_core::illusion::DisplayWire;
use palpate_core::units::{Board, Channel, Point};

/// The key that the environment of the build names, in the image that says this.
#[macro_export]
macro_rules! burnt_key {
    () => {
        $crate::key(env!(
            "PALPATE_UNIT_KEY",
            "PALPATE_UNIT_KEY: expected the unit's key, 64 hexadecimal digits"
        ))
    };
}

/// The 32 bytes that 64 hexadecimal digits stand for, when the image is compiled.
///
/// # Panics
/// On any other text, and on zeros. As a constant that stops the compiler, not a unit.
pub const fn key(text: &str) -> [u8; 32] {
    let text = text.as_bytes();
    assert!(
        text.len() == 64,
        "PALPATE_UNIT_KEY: expected 64 hexadecimal digits and nothing else"
    );
    let mut bytes = [0; 32];
    let (mut at, mut bits) = (0, 0);
    while at < 32 {
        bytes[at] = digit(text[2 * at]) << 4 | digit(text[2 * at + 1]);
        bits |= bytes[at];
        at += 1;
    }
    assert!(bits != 0, "PALPATE_UNIT_KEY: expected a key, found zeros");
    bytes
}

#[allow(clippy::panic)] // a key is read while the image is compiled, and this is how that ends
const fn digit(text: u8) -> u8 {
    match text {
        b'0'..=b'9' => text - b'0',
        b'a'..=b'f' => text - b'a' + 10,
        b'A'..=b'F' => text - b'A' + 10,
        _ => panic!("PALPATE_UNIT_KEY: expected 64 hexadecimal digits"),
    }
}

/// The wires of fingertips that have a board each, on its first channels: `WIRES` in all, `each` per board.
///
/// A unit looks at boards and channels only, so that the places are all the same.
pub const fn fingertips<const WIRES: usize>(each: u8) -> [DisplayWire; WIRES] {
    let mut wires = [DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    }; WIRES];
    let mut at = 0;
    while at < WIRES {
        wires[at].board = Board((at / each as usize) as u8);
        wires[at].channel = Channel((at % each as usize) as u8);
        at += 1;
    }
    wires
}

#[cfg(test)]
#[path = "key_tests.rs"]
mod tests;
