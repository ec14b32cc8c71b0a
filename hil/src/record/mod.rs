//! Recording while something happens: files that grow behind a queue, and buses without a run.

mod journal;
mod live;
mod piece;
mod play;
mod sink;

pub use journal::Journal;
pub use live::{Recorded, record};
pub use piece::Piece;
pub use play::{Played, play};
pub use sink::{About, Kind, Sink, kind_of, path_of};
