//! Events of served hardware: told while it serves, and summed up at the end.

use std::io::{self, Write};

use palpate_core::codec::drv2605::ADDRESS;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::DisplayTotals;
use palpate_files::Output;
use serde::Serialize;

use crate::telling::Say;

/// An event of served hardware. Times are nanoseconds of CLOCK_MONOTONIC, so that other programs on this machine can
/// compare theirs with them; within one run they are the emulators' own time plus a constant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Told<'a> {
    /// Both ends are there.
    Serving {
        /// Time of the event, ns of CLOCK_MONOTONIC.
        t_ns: u64,
        /// The scene.
        scene: &'a str,
        /// CAN interfaces, in the order of the sensor buses.
        can: Vec<&'a str>,
        /// The I2C node.
        i2c: &'a str,
        /// 7-bit addresses of the chips behind it; of motors those of their switches.
        chips: Vec<u8>,
        /// Kind of these chips.
        #[serde(skip)]
        kind: &'static str,
        /// The GPIO chip whose line 0 is on the chips' OE pins, if it is.
        oe: Option<&'a str>,
    },
    /// The line on the chips' OE pins changed.
    Oe {
        /// Time of the event, ns of CLOCK_MONOTONIC.
        t_ns: u64,
        /// High: every output is cut.
        high: bool,
    },
    /// A start command began the scene.
    Started {
        /// Time of the event, ns of CLOCK_MONOTONIC.
        t_ns: u64,
    },
    /// An output changed.
    Edge(PinEdge),
    /// A chip has begun to drive outputs.
    Driving {
        /// End of the transfer that began it.
        t_ns: u64,
        /// The chip's 7-bit address.
        chip: u8,
    },
    /// No output of a chip is driven any more, and none will be.
    AllOff {
        /// The later of the transfer that ended it and the last falling edge.
        t_ns: u64,
        /// The chip's 7-bit address.
        chip: u8,
    },
    /// A fault of the scene came or went.
    Fault {
        /// Time of the event, ns of CLOCK_MONOTONIC.
        t_ns: u64,
        /// Words of the fault.
        text: &'a str,
    },
    /// The summary at the end.
    Record(&'a Record),
}

/// An output that changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PinEdge {
    /// The time of the change on the emulated pin, nanoseconds of CLOCK_MONOTONIC.
    pub t_ns: u64,
    /// The chip's 7-bit address.
    pub chip: u8,
    /// The chip's output.
    pub channel: u8,
    /// `true` where the output is high.
    pub high: bool,
}

/// One output of the display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct WireRecord {
    /// The chip's 7-bit address.
    pub chip: u8,
    /// The chip's output.
    pub channel: u8,
    /// Pulses that have ended.
    pub pulses: u64,
    /// The longest of them, microseconds.
    pub longest_us: f64,
    /// Time at which the pulse that has not ended began, ns.
    #[serde(skip)]
    high_since_ns: Option<u64>,
}

/// One CAN interface.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct CanRecord {
    /// Name of the interface.
    pub name: String,
    /// Frames sent.
    pub sent: u64,
    /// Frames that the interface did not take.
    pub lost: u64,
    /// Frames of other programs.
    pub received: u64,
    /// Received frames for which the emulated wire had no room.
    pub crowded_out: u64,
    /// Frames that no board reads: extended, remote, error.
    pub foreign: u64,
}

/// A motor of the display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MotorRecord {
    /// Address of the switch before its driver, or of a driver alone on the bus.
    pub chip: u8,
    /// The switch's channel.
    pub channel: u8,
    /// Times that it was driven, with the braking at their end.
    pub bursts: u64,
    /// The longest of them, milliseconds.
    pub longest_ms: f64,
    /// Time at which the drive that goes on began.
    #[serde(skip)]
    since: Option<Nanos>,
}

impl MotorRecord {
    /// A motor behind this switch and channel that was never driven.
    pub(super) fn new(behind: Option<(u8, u8)>) -> Self {
        let (chip, channel) = behind.unwrap_or((ADDRESS, 0));
        Self {
            chip,
            channel,
            ..Self::default()
        }
    }

    /// Tells whether the motor is driven.
    pub(super) const fn is_driven(&self) -> bool {
        self.since.is_some()
    }

    /// Takes whether the motor is driven from `at` on. Returns `true` for a change.
    pub(super) fn change(&mut self, at: Nanos, driven: bool) -> bool {
        match (driven, self.since) {
            (true, None) => self.since = Some(at),
            (false, Some(since)) => {
                self.since = None;
                self.bursts += 1;
                let lasted_ms = at.since(since).0 as f64 / 1e6;
                self.longest_ms = self.longest_ms.max(lasted_ms);
            }
            _ => return false,
        }
        true
    }
}

/// Motion of emulated motors.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Shaken {
    /// The display's motors, in its order.
    pub motors: Vec<MotorRecord>,
    /// Largest amplitude of a face on the skin, um.
    pub face_um: f64,
    /// Largest rise of a coil over the air, K.
    pub coil_rise_k: f64,
    /// Largest drive, V peak.
    pub drive_v: f64,
}

impl Shaken {
    fn words(&self, out: &mut dyn Write) -> io::Result<()> {
        for (n, motor) in self.motors.iter().enumerate() {
            if motor.bursts > 0 {
                writeln!(
                    out,
                    "  motor {n:<8} {} bursts, longest {:.0} ms ({:#04x}, channel {})",
                    motor.bursts, motor.longest_ms, motor.chip, motor.channel
                )?;
            }
        }
        writeln!(
            out,
            "  faces          {:.0} um at most; coil {:.1} K over the air; {:.2} V peak",
            self.face_um, self.coil_rise_k, self.drive_v
        )
    }
}

/// Work of the display's outputs.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Worked {
    /// Currents of wires.
    Wires(Flowed),
    /// Motion of motors.
    Motors(Shaken),
}

/// Currents of emulated wires: pulses, energy and temperatures.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Flowed {
    /// The display's wires, in its order.
    pub wires: Vec<WireRecord>,
    /// Electrical energy, millijoules.
    pub energy_mj: f64,
    /// Largest supply current, amperes.
    pub peak_supply_a: f64,
    /// Hottest temperature of any wire, degrees C.
    pub hottest_wire_c: f64,
    /// Index of that wire.
    pub hottest_wire: usize,
    /// Hottest temperature of the skin, 0.1 mm deep, degrees C.
    pub hottest_skin_c: f64,
    /// Hazardous things done to the chips.
    pub hazards: u64,
}

/// Record of the whole time served.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Record {
    /// Always `emulated`.
    pub source: &'static str,
    /// Time served, seconds.
    pub served_s: f64,
    /// The interfaces.
    pub can: Vec<CanRecord>,
    /// The I2C node.
    pub i2c: String,
    /// Transfers on it.
    pub transfers: u64,
    /// Work of the outputs.
    #[serde(flatten)]
    pub worked: Option<Worked>,
    /// Chips that still drive outputs at the end, by address.
    pub driving: Vec<u8>,
    /// Largest lateness of a frame or an I2C answer, milliseconds.
    pub latest_ms: f64,
}

impl WireRecord {
    /// An output that was never driven.
    fn new(chip: u8, channel: u8) -> Self {
        Self {
            chip,
            channel,
            ..Self::default()
        }
    }

    /// Counts an edge of the output at `t_ns`.
    fn edge(&mut self, t_ns: u64, high: bool) {
        if high {
            self.high_since_ns = Some(t_ns);
        } else if let Some(since) = self.high_since_ns.take() {
            self.pulses += 1;
            self.longest_us = self.longest_us.max(t_ns.saturating_sub(since) as f64 / 1e3);
        }
    }
}

impl Flowed {
    /// Wires on these outputs, none of them driven.
    pub fn new(outputs: &[Output]) -> Self {
        let wires = outputs.iter().map(|o| WireRecord::new(o.board, o.channel));
        Self {
            wires: wires.collect(),
            ..Self::default()
        }
    }

    /// Counts an edge.
    pub fn edge(&mut self, edge: &PinEdge) {
        let is = |w: &&mut WireRecord| w.chip == edge.chip && w.channel == edge.channel;
        let Some(wire) = self.wires.iter_mut().find(is) else {
            return; // an output without a wire
        };
        wire.edge(edge.t_ns, edge.high);
    }

    /// Takes over the display's totals.
    pub fn totals(&mut self, totals: &DisplayTotals) {
        self.energy_mj = totals.electrical_j * 1e3;
        self.peak_supply_a = f64::from(totals.peak_supply.0) / 1e3;
        (self.hottest_wire_c, self.hottest_wire) = totals.hottest_wire;
        self.hottest_skin_c = totals.hottest_tissue_c;
    }

    /// Writes lines of a summary: the wires that were driven, their totals, hazards if there were any.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn words(&self, out: &mut dyn Write) -> io::Result<()> {
        for (n, wire) in self.wires.iter().enumerate() {
            if wire.pulses > 0 {
                writeln!(
                    out,
                    "  wire {n:<9} {} pulses, longest {:.0} us (chip {:#04x}, channel {})",
                    wire.pulses, wire.longest_us, wire.chip, wire.channel
                )?;
            }
        }
        writeln!(
            out,
            "  hottest        wire {} at {:.1} C, skin {:.2} C; {:.1} mJ, at most {:.2} A",
            self.hottest_wire,
            self.hottest_wire_c,
            self.hottest_skin_c,
            self.energy_mj,
            self.peak_supply_a
        )?;
        if self.hazards > 0 {
            writeln!(out, "  hazards        {}", self.hazards)?;
        }
        Ok(())
    }
}

impl Record {
    /// Writes the record as words of a summary.
    fn words(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "served {:.1} s (emulated)", self.served_s)?;
        for can in &self.can {
            writeln!(
                out,
                "  {:<14} {} frames sent, {} lost; {} received, {} crowded out, {} foreign",
                can.name, can.sent, can.lost, can.received, can.crowded_out, can.foreign
            )?;
        }
        writeln!(out, "  {:<14} {} transfers", self.i2c, self.transfers)?;
        match &self.worked {
            Some(Worked::Wires(flowed)) => flowed.words(out)?,
            Some(Worked::Motors(shaken)) => shaken.words(out)?,
            None => {}
        }
        if self.driving.is_empty() {
            writeln!(out, "  outputs        off")?;
        }
        for chip in &self.driving {
            writeln!(out, "  outputs        chip {chip:#04x} STILL DRIVES")?;
        }
        writeln!(out, "  latest         {:.1} ms", self.latest_ms)
    }
}

impl Say for Told<'_> {
    /// Writes words for few events: the served interfaces, faults, the record.
    fn words(&self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Told::Serving {
                scene,
                can,
                i2c,
                chips,
                kind,
                oe,
                ..
            } => {
                writeln!(out, "serving {scene} (emulated); Ctrl-C stops")?;
                for name in can {
                    writeln!(out, "  {name:<14} uSkin boards")?;
                }
                write!(out, "  {i2c:<14} {kind} at")?;
                for chip in chips {
                    write!(out, " {chip:#04x}")?;
                }
                writeln!(out)?;
                match oe {
                    Some(oe) => writeln!(out, "  {oe:<14} line 0 on the chips' OE pins, pulled up"),
                    None => Ok(()),
                }
            }
            Told::Fault { text, .. } => writeln!(out, "  {text}"),
            Told::Record(record) => record.words(out),
            _ => Ok(()),
        }
    }
}
