//! Rate and loss of every board, bus and interface, and how a real run kept its time.

use palpate_core::projector::Projector;
use palpate_core::statistics::quantile;
use palpate_emulators::display::i2c::I2cHandle;
use palpate_emulators::sensor::rig::SkinBus;
use palpate_records::i2c::Transfer;
use serde::Serialize;

/// The slowest, median and fastest of several rates, Hz.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Slowest rate.
    pub min: f64,
    /// Median rate.
    pub median: f64,
    /// Fastest rate.
    pub max: f64,
}

/// A sensor board as the loop saw it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoardReport {
    /// Module of the board in the skin, zero-based.
    pub module: usize,
    /// The module's name.
    pub name: String,
    /// Sensor bus of the module; `None` for a recording.
    pub bus: Option<u8>,
    /// Number of the board on its bus; `None` for a recording.
    pub board: Option<u8>,
    /// Readings a second over its taxels.
    pub rate_hz: Spread,
    /// Readings received.
    pub readings: u64,
    /// Readings missing from scans that arrived in part.
    pub lost: u64,
    /// Share of readings missing, 0 to 1.
    pub loss: f64,
}

/// A sensor bus as its emulator knows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BusReport {
    /// Number of the bus, zero-based.
    pub bus: usize,
    /// Share of the time in which it was not idle, 0 to 1.
    pub load: f64,
    /// Frames completed.
    pub frames: u64,
    /// Frames a second.
    pub rate_hz: f64,
    /// Error frames: bit, stuff, CRC, form, acknowledgement.
    pub errors: [u64; 5],
    /// Frames the host did not take in time.
    pub overflows: u64,
}

impl BusReport {
    /// Words of the report, in a line.
    pub fn words(&self) -> String {
        format!(
            "bus {:<4} {:>5.1} % load, {:.0} frames/s, {} errors, {} overflows",
            self.bus,
            self.load * 100.0,
            self.rate_hz,
            self.errors.iter().sum::<u64>(),
            self.overflows
        )
    }
}

/// Lateness of the loop's turns: how long after their due time they began, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Pacing {
    /// Turns.
    pub turns: u64,
    /// Lateness that half of the turns did not exceed, rounded up to a power of two.
    pub median_us: u64,
    /// Lateness that 99 of 100 turns did not exceed, rounded up to a power of two.
    pub p99_us: u64,
    /// Lateness of the latest turn.
    pub worst_us: u64,
    /// `true` where the loop had real-time priority.
    pub realtime: bool,
}

impl Pacing {
    /// Words of the lateness, in a line.
    #[must_use]
    pub fn words(&self) -> String {
        let priority = if self.realtime {
            "real-time priority"
        } else {
            "ordinary priority"
        };
        format!(
            "{} turns, late by {} us median, {} us p99, {} us at most; {priority}",
            self.turns, self.median_us, self.p99_us, self.worst_us
        )
    }
}

/// Frames and losses of a CAN interface in a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CanReport {
    /// Name of the interface when the run began.
    pub interface: String,
    /// Data frames received.
    pub frames: u64,
    /// Frames lost because this computer was too slow: in the kernel and in this program.
    pub lost: u64,
    /// Times the controller's own buffer ran over.
    pub overruns: u64,
    /// Error frames about the bus.
    pub errors: u64,
    /// Times the controller went bus-off.
    pub bus_off: u64,
    /// Frames whose time the controller itself told.
    pub hardware_stamps: u64,
}

impl CanReport {
    /// Words of the report, in a line.
    #[must_use]
    pub fn words(&self) -> String {
        format!(
            "{} frames, {} lost, {} errors, bus-off {} times, times by the {}",
            self.frames,
            self.lost,
            self.errors + self.overruns,
            self.bus_off,
            if self.hardware_stamps > 0 {
                "controller"
            } else {
                "kernel"
            }
        )
    }
}

/// Report of every board of the loop.
pub fn boards(projector: &Projector, lost_of: impl Fn(usize) -> u64) -> Vec<BoardReport> {
    let (layout, monitor) = (projector.layout(), projector.monitor());
    let report = |(module, m): (usize, &palpate_core::skin::Module)| {
        let taxels = layout.range(module).zip(m.active());
        let active: Vec<usize> = taxels.filter(|t| *t.1).map(|t| t.0).collect();
        let mut rates: Vec<f32> = active.iter().map(|&i| monitor.rates_hz(i).1).collect();
        rates.sort_unstable_by(f32::total_cmp);
        let at = |k: usize| rates.get(k).copied().map_or(0.0, f64::from);
        let received = active.iter().filter_map(|&i| monitor.received(i));
        let readings: u64 = received.map(|r| u64::from(r.0)).sum();
        let lost = lost_of(module);
        BoardReport {
            module,
            name: m.name().to_owned(),
            bus: m.address().map(|a| a.bus),
            board: m.address().map(|a| a.board),
            rate_hz: Spread {
                min: at(0),
                median: quantile(&rates, 0.5).map_or(0.0, |middle| f64::from(middle.above)),
                max: at(rates.len().saturating_sub(1)),
            },
            readings,
            lost,
            loss: lost as f64 / (lost + readings).max(1) as f64,
        }
    };
    layout.modules().iter().enumerate().map(report).collect()
}

/// Report of every bus of an emulated skin.
pub fn buses(buses: &[SkinBus]) -> Vec<BusReport> {
    let report = |(number, bus): (usize, &SkinBus)| {
        let (segment, statistics) = (bus.segment(), bus.segment().statistics());
        let seconds = segment.now().as_secs_f64();
        BusReport {
            bus: number,
            load: segment.load(),
            frames: statistics.frames,
            rate_hz: if seconds > 0.0 {
                statistics.frames as f64 / seconds
            } else {
                0.0
            },
            errors: statistics.errors,
            overflows: segment.overflows(bus.host()),
        }
    };
    buses.iter().enumerate().map(report).collect()
}

/// Transfers that crossed the boards' bus of this number; empty where no log is kept.
pub fn transfers(i2c: &I2cHandle, bus: u8) -> Vec<Transfer> {
    // Refused only from inside another look at the bus.
    let log = i2c.with(|bus| bus.take_log()).unwrap_or_default();
    let messages = log.into_iter().flat_map(|record| {
        let error = record.result.err().map(|e| e.to_string());
        record.messages.into_iter().map(move |message| Transfer {
            start_ns: record.start.0,
            end_ns: record.end.0,
            bus,
            address: message.address,
            read: message.read,
            data: message.bytes,
            error: error.clone(),
        })
    });
    messages.collect()
}
