//! One function a command: arguments in, files and text out.

mod bench;
mod contacts;
mod rate;
mod run;

pub use bench::bench;
pub use contacts::contacts;
pub use run::run;
