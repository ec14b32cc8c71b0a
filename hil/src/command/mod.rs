//! One function a command: arguments in, files and text out.

mod contacts;
mod devices;
mod diff;
mod doctor;
mod emulate;
mod explain;
mod guardian;
mod off;
mod pins;
mod rate;
mod record;
mod review;
mod run;
mod schedules;
mod test;
mod texture;
mod texture_panel;
mod texture_train;

pub use contacts::contacts;
pub use diff::diff;
pub use doctor::doctor;
pub use emulate::emulate;
pub use guardian::guardian;
pub use off::off;
pub use record::{record, replay};
pub use review::review;
pub use run::run;
pub use test::test;
pub use texture::texture;
