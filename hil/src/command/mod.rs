//! One function a command: arguments in, files and text out.

mod bench;
mod contacts;
mod devices;
mod doctor;
mod emulate;
mod explain;
mod guardian;
mod off;
mod rate;
mod record;
mod run;

pub use bench::bench;
pub use contacts::contacts;
pub use doctor::doctor;
pub use emulate::emulate;
pub use guardian::guardian;
pub use off::off;
pub use record::{record, replay};
pub use run::run;
