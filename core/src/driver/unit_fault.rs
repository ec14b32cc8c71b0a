//! Reasons for which a driver unit cannot be driven: an error of every driver, also without the feature `unit`.

use crate::guard::Cause;
use crate::schedule::MOST_PLANNED;
use crate::units::{Board, Channel};

/// A fault that keeps a driver unit from being driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnitFault {
    /// The unit has not answered yet, or not for 150 ms.
    #[error("unit: no answer; check its power, the network, its address and the key")]
    Silent,
    /// Another host drives the unit.
    #[error("unit: another host drives it; end that one, or wait half a second after its end")]
    Busy,
    /// The cause for which the unit's guard has stopped it. A person has to look before this host goes on.
    #[error("unit: stopped by its own guard, {}; look at the wearer, then start again", .0.word())]
    Stopped(Cause),
    /// A board that the unit lacks, or a channel without a wire.
    #[error("unit: expected a channel that carries a wire there, found channel {} of board {}; make bench and unit agree", .1.0, .0.0)]
    NoSuchOutput(Board, Channel),
    /// More stimuli at once than a command carries.
    #[error("unit: expected at most {MOST_PLANNED} stimuli at a time")]
    Full,
    /// The host does not know the unit's clock yet.
    #[error("unit: its clock is not known yet")]
    NoTime,
}
