//! Settings burnt into a unit, and those that are refused.

use palpate_core::codec::dac7578::CHANNELS;
use palpate_core::guard::{CurrentControl, Limits, Plant, PlantError, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::units::{Board, Channel};

/// Amplifiers whose current is set by a DAC7578 beside each board.
#[derive(Clone, Copy, Debug)]
pub struct Converters<'a> {
    /// 7-bit addresses of the converters, by board.
    pub addresses: &'a [u8],
    /// Full scale of the amplifiers' current, and its largest errors.
    pub control: CurrentControl,
}

/// Settings burnt into a unit.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// Key that the unit shares with its host.
    pub key: &'a [u8; 32],
    /// A number that no start of this unit under this key has had: 64 random bits, or a count kept in flash.
    pub boot: u64,
    /// The wires on its boards.
    pub wires: &'a [DisplayWire],
    /// 7-bit addresses of the boards, by number.
    pub addresses: &'a [u8],
    /// Limits of the unit, at most as loose as the hard ones.
    pub limits: Limits,
    /// Boards and wires as the unit's guard knows them.
    pub plant: Plant,
    /// The wire and finger of the guard's thermal rows; `None` where its processor bears none.
    pub worn: Option<WornWire>,
    /// Converters that set the currents; `None` where amplifiers have a current of their own.
    pub converters: Option<Converters<'a>>,
}

/// Reasons for which a unit cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// Limits, boards or wires that the guard refuses.
    #[error(transparent)]
    Plant(PlantError),
    /// No board, or more than sixteen.
    #[error("boards: expected 1 to 16 addresses, found {0}")]
    Boards(usize),
    /// Two boards at one address.
    #[error(
        "boards: expected an address of its own for each chip, found {0:#04x} twice: set the straps of one board otherwise"
    )]
    SameAddress(u8),
    /// Another number of converters than of boards.
    #[error("converters: expected one address per board, found {0}")]
    Converters(usize),
    /// A wire on a board or channel that is not there.
    #[error("wires: expected a channel 0 to 15 of a board of this unit, 0 to 7 beside a converter, found channel {} of board {}", .1.0, .0.0)]
    NoSuchOutput(Board, Channel),
}

impl Settings<'_> {
    pub(crate) fn check(&self) -> Result<(), SettingsError> {
        let count = self.addresses.len();
        if !(1..=16).contains(&count) {
            return Err(SettingsError::Boards(count));
        }
        let converters = self.converters.map_or(&[][..], |c| c.addresses);
        if self.converters.is_some() && converters.len() != count {
            return Err(SettingsError::Converters(converters.len()));
        }
        let chips = || self.addresses.iter().chain(converters);
        let twice = |&(n, address): &(usize, &u8)| chips().take(n).any(|a| a == address);
        if let Some((_, address)) = chips().enumerate().find(twice) {
            return Err(SettingsError::SameAddress(*address));
        }
        let channels = if converters.is_empty() { 16 } else { CHANNELS };
        let absent = |w: &&DisplayWire| usize::from(w.board.0) >= count || w.channel.0 >= channels;
        match self.wires.iter().find(absent) {
            Some(wire) => Err(SettingsError::NoSuchOutput(wire.board, wire.channel)),
            None => Ok(()),
        }
    }
}
