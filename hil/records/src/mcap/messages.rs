//! Messages that are read again: frames on a sensor bus, angles of joints, and lines of the schedule, whose pulses follow from the rest.

use palpate_core::bus::Received;
use palpate_core::codec::can::CanFrame;
use palpate_core::schedule::{Entry, Reason};
use palpate_core::units::{Board, Channel, Instant, Ticks};

use super::proto::{Fields, Value};

/// A frame's message.
pub(super) fn frame(t_ns: u64, message: &[u8]) -> Option<Received> {
    let (mut bus, mut id, mut data) = (0, 0, &[][..]);
    for field in Fields::new(message) {
        match field? {
            (1, Value::Number(n)) => bus = u8::try_from(n).ok()?,
            (2, Value::Number(n)) => id = u16::try_from(n).ok()?,
            (3, Value::Data(bytes)) => data = bytes,
            _ => {}
        }
    }
    Some(Received {
        at: Instant::from_micros(t_ns / 1000),
        bus,
        frame: CanFrame::new(id, data)?,
    })
}

/// A joint's angle, degrees; `None` for what is no such message.
pub(super) fn angle(message: &[u8]) -> Option<f64> {
    let mut deg = 0.0; // a field that is left out
    for field in Fields::new(message) {
        if let (1, value) = field? {
            let Value::Fixed64(bits) = value else {
                return None;
            };
            deg = f64::from_bits(bits);
        }
    }
    deg.is_finite().then_some(deg)
}

/// Of a line of the schedule: whether pulses and period are those that the times make; also true where an older file has
/// neither. `None` for what is no such message.
pub(super) fn agrees(t_ns: u64, message: &[u8]) -> Option<bool> {
    let (entry, pulses, period_ns) = entry(t_ns, message)?;
    Some(match period_ns {
        0 => pulses == 0,
        period_ns => pulses == entry.pulses(period_ns),
    })
}

/// A line of the schedule without board and channel, and the pulses and the period (ns) that it states. Where no end was
/// cut, `requested_until` is the onset. `None` for what is no such message.
pub(super) fn entry(t_ns: u64, message: &[u8]) -> Option<(Entry, u64, u64)> {
    let at = Instant::from_micros(t_ns / 1000);
    let mut entry = Entry {
        at,
        board: Board(0),
        channel: Channel(0),
        on: 0,
        off: 0,
        until: at,
        requested: Ticks::ZERO,
        requested_until: at,
        current: None,
        reason: None,
    };
    let ticks = |n: u64| u16::try_from(n).ok().filter(|t| *t <= Ticks::PER_PERIOD);
    let (mut pulses, mut period_ns) = (0, 0);
    for field in Fields::new(message) {
        match field? {
            (3, Value::Number(n)) => entry.requested = Ticks::new(ticks(n)?),
            (5, Value::Number(n)) => entry.on = ticks(n)?,
            (6, Value::Number(n)) => entry.off = ticks(n)?,
            (7, Value::Number(us)) => entry.until = Instant::from_micros(us),
            (8, Value::Data(word)) => {
                let known = |r: &Reason| r.word().as_bytes() == word;
                entry.reason = Some(Reason::ALL.into_iter().find(known)?);
            }
            (9, Value::Number(n)) => pulses = n,
            (10, Value::Number(ns)) => period_ns = ns,
            (11, Value::Number(us)) => entry.requested_until = Instant::from_micros(us),
            _ => {}
        }
    }
    if entry.requested_until != at && entry.requested_until < entry.until {
        return None;
    }
    Some((entry, pulses, period_ns))
}

#[cfg(test)]
#[path = "messages_tests.rs"]
mod tests;
