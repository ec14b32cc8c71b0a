//! Recording: files that grow behind a queue, and buses without a run.

mod journal;
mod live;
mod play;
mod sink;

pub use journal::Journal;
pub use live::{Recorded, record};
pub use play::{Played, play};
pub use sink::{About, Sink, path_of};
