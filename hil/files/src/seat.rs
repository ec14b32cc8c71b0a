//! Contact between the emulated finger and single wires of its display, over time.

use serde::Deserialize;

use super::error::FileError;
use super::joint::check_points;
use super::source::Source;

/// Contact of one wire with the emulated finger. A finger that moves inside a rigid thimble has other parts over time.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Seat {
    /// A wire, counted from zero over all displays, the first display's wires first.
    pub wire: usize,
    /// Times in seconds, ascending, and the part of the wire's motion that reaches the skin, 0 to 1; straight lines between, and
    /// the ends hold.
    pub points_s_part: Vec<[f64; 2]>,
}

/// Checks all seats of a scene.
pub(super) fn check(seats: &[Seat], source: &Source) -> Result<(), FileError> {
    for (index, seat) in seats.iter().enumerate() {
        let key = format!("seats[{index}]");
        if seats[..index].iter().any(|other| other.wire == seat.wire) {
            let expected = "a wire that no other seat has";
            return Err(source.bad(&format!("{key}.wire"), expected));
        }
        let key = format!("{key}.points_s_part");
        check_points(
            &seat.points_s_part,
            source,
            &key,
            (0.0..=1.0, "of the motion"),
        )?;
    }
    Ok(())
}

/// Holds the seats of a scene against a bench of so many wires.
pub(super) fn fit(seats: &[Seat], source: &Source, wires: usize) -> Result<(), FileError> {
    match seats.iter().position(|seat| seat.wire >= wires) {
        Some(index) => Err(source.bad(
            &format!("seats[{index}].wire"),
            format!("less than {wires}"),
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
#[path = "seat_tests.rs"]
mod tests;
