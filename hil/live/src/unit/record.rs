//! Events of a unit's process: its host, its stops, and at the end the counts of stimuli.

use std::io::{self, Write};
use std::net::SocketAddr;

use palpate_unit::Counts;
use serde::Serialize;

use crate::emulate::{Flowed, PinEdge};
use crate::telling::Say;

/// An event of a unit's process. Times are nanoseconds of CLOCK_MONOTONIC.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
#[allow(missing_docs)] // `t_ns` is when
pub enum Told<'a> {
    /// The unit listens, and everything is off.
    Serving {
        t_ns: u64,
        address: SocketAddr,
        /// Kind of boards: `emulated` or `real`.
        source: &'static str,
        /// The I2C adapter of real boards.
        i2c: Option<&'a str>,
        bench: &'a str,
        /// 7-bit addresses of the boards.
        boards: &'a [u8],
        wires: usize,
    },
    /// A session began.
    Host {
        t_ns: u64,
        address: SocketAddr,
        session: u32,
    },
    /// The host was silent for half a second, or is done.
    HostGone { t_ns: u64, address: SocketAddr },
    /// Datagrams were refused since the last such event, at least a second ago: of another key, session or version, or
    /// none.
    Refused {
        t_ns: u64,
        count: u32,
        /// Sender of the newest datagram.
        address: SocketAddr,
    },
    /// The guard stopped the unit.
    Stopped { t_ns: u64, cause: &'static str },
    /// A stop was acknowledged.
    DrivesAgain { t_ns: u64 },
    /// An output of an emulated board changed.
    Edge(PinEdge),
    /// The summary at the end.
    Record(&'a Record),
}

/// Record of the whole time served.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Record {
    /// `emulated` or `real`.
    pub source: &'static str,
    /// Time served, seconds.
    pub served_s: f64,
    /// Sessions begun.
    pub sessions: u32,
    /// Stimuli begun.
    pub begun: u32,
    /// Stimuli that the guard changed or refused.
    pub limited: u32,
    /// Stimuli left out.
    pub dropped: u32,
    /// Largest lateness of a beginning in the last session, microseconds.
    pub late_us: u32,
    /// Stops.
    pub stops: u32,
    /// Datagrams refused.
    pub refused: u32,
    /// Largest lateness of a turn, microseconds.
    pub latest_turn_us: u64,
    /// `true` where every output was known to be off at the end.
    pub off: bool,
    /// Currents of the wires, for emulated boards.
    pub emulated: Option<Flowed>,
}

impl Record {
    /// Takes over the unit's counts.
    pub const fn counts(&mut self, counts: &Counts) {
        self.sessions = counts.sessions;
        self.begun = counts.applied;
        self.limited = counts.limited;
        self.dropped = counts.dropped;
        self.late_us = counts.late_us;
        self.stops = counts.stops;
        self.refused = counts.refused;
    }

    fn words(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "served {:.1} s ({})", self.served_s, self.source)?;
        writeln!(
            out,
            "  played         {} stimuli in {} sessions, at most {} us late; {} changed by the guard, {} left out",
            self.begun, self.sessions, self.late_us, self.limited, self.dropped
        )?;
        writeln!(
            out,
            "  stops          {}; {} datagrams refused",
            self.stops, self.refused
        )?;
        if let Some(flowed) = &self.emulated {
            flowed.words(out)?;
        }
        let off = if self.off {
            "off"
        } else {
            "NOT KNOWN TO BE OFF"
        };
        writeln!(out, "  outputs        {off}")
    }
}

impl Say for Told<'_> {
    fn words(&self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Told::Serving {
                address,
                source,
                i2c,
                bench,
                boards,
                wires,
                ..
            } => {
                write!(
                    out,
                    "unit at {address} ({source}): {wires} wires of bench {bench} on PCA9685 at"
                )?;
                for board in *boards {
                    write!(out, " {board:#04x}")?;
                }
                match i2c {
                    Some(i2c) => writeln!(out, " of {i2c}; Ctrl-C stops"),
                    None => writeln!(out, "; Ctrl-C stops"),
                }
            }
            Told::Host {
                address, session, ..
            } => writeln!(out, "  host {address} drives, session {session}"),
            Told::HostGone { address, .. } => writeln!(out, "  host {address} is gone"),
            Told::Refused { count, address, .. } => writeln!(
                out,
                "  refused {count} datagrams, the last from {address}: another key, session or version, or the unit has another host"
            ),
            Told::Stopped { cause, .. } => writeln!(out, "  stopped: {cause}"),
            Told::DrivesAgain { .. } => writeln!(out, "  drives again"),
            Told::Edge(_) => Ok(()),
            Told::Record(record) => record.words(out),
        }
    }
}
