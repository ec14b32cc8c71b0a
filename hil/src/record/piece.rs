//! What a file that grows is handed at a time.

use palpate_core::bus::Received;
use palpate_records::i2c::Transfer;
use palpate_records::readings::TaxelFrame;
use palpate_records::trace::Event;
use palpate_run::Passed;

/// What happened since the last piece.
#[derive(Debug, Default)]
pub struct Piece {
    /// In the order of time, all of an instant together.
    pub events: Vec<Event>,
    /// Frames on the sensor buses.
    pub frames: Vec<Received>,
    /// Messages on the actuator buses, of an emulated run.
    pub i2c: Vec<Transfer>,
    /// What taxels read, where a file takes it.
    pub taxels: Vec<TaxelFrame>,
}

impl From<Passed> for Piece {
    fn from(passed: Passed) -> Self {
        Self {
            events: passed.events,
            frames: passed.can,
            i2c: passed.i2c,
            taxels: passed.taxels,
        }
    }
}
