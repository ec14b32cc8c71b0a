//! Studies with people: order and levels of trials, records, analysis of the answers, and people who are simulated.
//!
//! Nothing here knows a bench, a clock or a page: trials go out, answers come in. The methods are published ones and are
//! held against published implementations of them, trial by trial.
#![forbid(unsafe_code)]

mod analyse;
mod compare;
mod people;
mod psychometric;
mod quest;
mod record;
mod session;
mod simulate;
mod staircase;
mod threshold;

pub use analyse::{
    Analysis, AnalysisTable, Chosen, Comparison, Drawn, OfWire, OneDrawing, Participant, PathError,
    Rated, analyse, compare_paths, fitted, tables,
};
pub use people::{Known, Path, Person, Sensed};
pub use psychometric::Psychometric;
pub use quest::Estimate;
pub use record::{
    About, Interval, Line, Noted, Passing, Played, Playing, Record, RecordError, Resumed, Said,
    Uptime, VERSION,
};
pub use session::{Answer, AnswerError, Ask, Reply, Sample, Session, Step, Stimulus, Trial};
pub use simulate::{
    Detection, Drawings, Levels, Outcome, Places, Simulation, StudyError, Thresholds, simulate,
};
pub use threshold::Thresholding;
