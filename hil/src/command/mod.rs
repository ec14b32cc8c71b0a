//! One function a command: arguments in, files and text out.

mod contacts;
mod emulate;
mod rate;
mod run;

pub use contacts::contacts;
pub use emulate::emulate;
pub use run::run;
