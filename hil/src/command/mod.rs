//! One function a command: arguments in, files and text out.

mod contacts;
mod rate;
mod run;

pub use contacts::contacts;
pub use run::run;
