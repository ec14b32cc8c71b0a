//! Changed goldens for a person to decide on: found as insta left them, told in words, drawn, accepted or rejected.

mod chart;
mod page;
mod pending;
mod scene;

pub use chart::{BLOCKS, stacked};
pub use page::page;
pub use pending::{Pending, folder, pending};
pub use scene::{Change, Scene, scenes};
