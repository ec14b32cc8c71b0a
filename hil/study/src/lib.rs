//! Studies with people: which level comes next, what answers say, and people who are simulated.
//!
//! Nothing here knows a bench, a clock or a page: levels go out, answers come in. The methods are published ones and are
//! held against published implementations of them, trial by trial.
#![forbid(unsafe_code)]

mod compare;
mod psychometric;
mod quest;
mod simulate;
mod staircase;
mod threshold;

pub use psychometric::Psychometric;
pub use quest::{Estimate, Quest, QuestDomain};
pub use simulate::{Outcome, Ratings, Simulation, StudyError, Thresholds, simulate};
pub use staircase::{Staircase, StaircaseSettings};
pub use threshold::Thresholding;
