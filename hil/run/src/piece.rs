//! Pieces of a run while it goes on, in the order of time, for files that grow.

use palpate_core::bus::Received;
use palpate_core::units::{Duration, Instant};
use palpate_records::i2c::Transfer;
use palpate_records::readings::{Readings, TaxelFrame};
use palpate_records::trace::{Event, sort_by_time};

use crate::display_end::DisplayEnd;
use crate::session::Session;
use crate::skin_end::SkinEnd;

/// Events, frames and readings since the last piece. Later pieces hold nothing older.
#[derive(Debug, Default)]
pub struct Piece {
    /// Events in the order of time, all of an instant together.
    pub events: Vec<Event>,
    /// Frames on the sensor buses as the host saw them, if they were to be kept.
    pub can: Vec<Received>,
    /// Messages on the actuator buses, if they were to be kept.
    pub i2c: Vec<Transfer>,
    /// Readings of taxels, if they were to be kept.
    pub taxels: Vec<TaxelFrame>,
}

/// Puts pieces together.
#[derive(Debug)]
pub(crate) struct Pieces {
    /// Longest delay of an event: the sensation of an onset is known at the next one.
    late: Duration,
    waiting: Piece,
}

/// The longest turn, and recoveries of the bus.
const TURNS: Duration = Duration::from_millis(1000);

impl Pieces {
    /// An empty collection for a run with `soa_us` from onset to onset.
    pub(crate) fn new(soa_us: u64) -> Self {
        Self {
            late: TURNS + Duration::from_micros(2 * soa_us),
            waiting: Piece::default(),
        }
    }

    /// Takes everything since the last piece that nothing earlier can precede any more; all of it at the `end`.
    pub(crate) fn take<S: SkinEnd, D: DisplayEnd>(
        &mut self,
        session: &mut Session<S, D>,
        end: bool,
    ) -> Option<Piece> {
        if end {
            session.recorder().pass_on();
        }
        let now = session.now();
        let events = session.recorder().handed.as_mut().map(std::mem::take)?;
        if events.is_empty() && !end {
            return None;
        }
        let waiting = &mut self.waiting;
        waiting.events.extend(events);
        sort_by_time(&mut waiting.events);
        waiting.can.extend(session.skin().take_frames());
        let taxels = session.recorder().taxels.as_mut();
        waiting
            .taxels
            .extend(taxels.map(Readings::take_frames).unwrap_or_default());
        let transfers = session.display().take_transfers();
        waiting.i2c.extend(transfers);
        let until_us = match end {
            true => u64::MAX,
            false => now.since(Instant::ZERO + self.late).as_micros(),
        };
        let until_ns = until_us.saturating_mul(1000);
        Some(Piece {
            events: before(&mut waiting.events, |e| e.t_ns() < until_ns),
            can: before(&mut waiting.can, |r| r.at.as_micros() < until_us),
            i2c: before(&mut waiting.i2c, |t| t.start_ns < until_ns),
            taxels: before(&mut waiting.taxels, |f| f.t_us < until_us),
        })
    }
}

/// Takes the first items that are due.
fn before<T>(waiting: &mut Vec<T>, is_due: impl Fn(&T) -> bool) -> Vec<T> {
    let due = waiting.partition_point(is_due);
    let later = waiting.split_off(due);
    std::mem::replace(waiting, later)
}
