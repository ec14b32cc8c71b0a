//! Why a driver unit cannot be driven: an error of every driver, also without the feature `unit`.

use crate::guard::Cause;
use crate::schedule::MOST_PLANNED;
use crate::units::{Board, Channel};

/// What keeps a unit from being driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnitFault {
    /// No answer yet, or none for 150 ms.
    #[error("unit: no answer; check its power, the network, its address and the key")]
    Silent,
    /// Another host has it.
    #[error("unit: another host drives it; end that one, or wait half a second after its end")]
    Busy,
    /// Its guard stopped it, and this host may not go on by itself.
    #[error("unit: stopped by its own guard, {}; look at the wearer, then start again", .0.word())]
    Stopped(Cause),
    /// A board that it does not have, or a channel without a wire.
    #[error("unit: expected a channel that carries a wire there, found channel {} of board {}; make bench and unit agree", .1.0, .0.0)]
    NoSuchOutput(Board, Channel),
    /// More stimuli at once than a command carries.
    #[error("unit: expected at most {MOST_PLANNED} stimuli at a time")]
    Full,
    /// Its clock is not known yet.
    #[error("unit: its clock is not known yet")]
    NoTime,
}
