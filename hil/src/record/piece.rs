//! What a journal hands to its files at a time.

use palpate_core::bus::Received;
use palpate_records::trace::Event;

/// What happened since the last piece.
#[derive(Debug, Default)]
pub struct Piece {
    /// In the order of time, all of an instant together.
    pub events: Vec<Event>,
    /// Frames on the sensor buses.
    pub frames: Vec<Received>,
}
