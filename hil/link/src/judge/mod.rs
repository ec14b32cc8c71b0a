//! Judgement of a receiver on frames: pure logic, with every time handed in. No clock, socket, thread or file.
//!
//! A frame counts for as long as its reading is fresh, however and whenever it arrives. Nothing that a network does
//! makes a reading look younger than it is: [`Clock`] keeps certain bounds of the sender's clock, and [`Gate`] judges
//! by it.

mod clock;
mod gate;
mod rate;

pub use clock::{Clock, Jumped};
pub use gate::{Gate, Head, Patience, Refusal, Tally};
pub use rate::Bucket;
