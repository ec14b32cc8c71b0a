//! A bench in real time, below the commands of `hil`: runs on hardware and driver units, emulated hardware on device
//! nodes, the unit as a process, records that grow, and live views.

pub mod again;
pub mod clock;
pub mod emulate;
pub mod ending;
pub mod host;
pub mod interfaces;
pub mod link;
mod lock;
pub mod output;
pub mod progress;
pub mod real;
pub mod record;
pub mod recording;
pub mod serve;
pub mod telling;
pub mod unit;
pub mod views;
pub mod watch;
