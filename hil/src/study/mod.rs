//! Studies with people: what a bench plays, what is kept on disk, and the session between them and a page.

mod clock;
mod conduct;
mod dose;
mod folder;
mod player;
mod rehearsal;
mod report;
mod screens;
mod stimuli;
mod tables;

pub use clock::{SessionClock, uptime};
pub use conduct::{Answers, Conducting, Ended, conduct};
pub use dose::{Dose, planned};
pub use folder::{Folder, Writing};
pub use player::Player;
pub use rehearsal::growth;
pub use report::page;
pub use stimuli::Stimuli;
pub use tables::{data, description, sidecar, wearer};
