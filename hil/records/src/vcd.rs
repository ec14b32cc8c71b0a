//! The display side as a Value Change Dump (IEEE 1364-2005, 18.2), for GTKWave, Surfer and PulseView: pins,
//! commanded ticks, wire and skin temperature.
//!
//! Times are nanoseconds since the start of the run, and there is no date: the same run gives the same bytes.

use std::io::{self, Write};

use crate::fixed::milli;
use crate::trace::{Event, Header, Trace, VERSION, event};

/// Variables of a wire, in the order of their declaration.
const PIN: usize = 0;
const ON: usize = 1;
const OFF: usize = 2;
const WIRE_C: usize = 3;
const SKIN_C: usize = 4;
const KINDS: usize = 5;

/// Writes a whole run.
///
/// # Errors
/// The writer's error.
pub fn write_vcd(trace: &Trace, out: &mut dyn Write) -> io::Result<()> {
    let mut vcd = Vcd::begin(&trace.header, out)?;
    vcd.events(&trace.events)?;
    vcd.finish(trace.ledger.length_us.saturating_mul(1000))
}

/// A dump that grows.
///
/// A run on a real bench knows neither its pins nor its temperatures: there only the commanded ticks are
/// declared. They cannot be mistaken for a measurement.
#[derive(Debug)]
pub struct Vcd<W> {
    out: W,
    /// Board and channel of each wire.
    outputs: Vec<(u8, u8)>,
    emulated: bool,
    now_ns: Option<u64>,
}

impl<W: Write> Vcd<W> {
    /// Writes the declarations and the state before the start: pins low, ticks 0, temperatures unknown.
    ///
    /// # Errors
    /// The writer's error.
    pub fn begin(header: &Header, mut out: W) -> io::Result<Self> {
        let (emulated, source) = (header.source.is_emulated(), header.source.word());
        let plain = |text: &str| text.replace(char::is_whitespace, " ").replace('$', "_");
        writeln!(out, "$version palpate {} $end", env!("CARGO_PKG_VERSION"))?;
        writeln!(
            out,
            "$comment trace version {VERSION}, {}; scene {} {}, bench {}, limits {}, seed {} $end",
            header.source.words(),
            plain(&header.scene),
            header.scene_digest,
            plain(&header.bench),
            header.limits_digest,
            header.seed
        )?;
        writeln!(out, "$timescale 1 ns $end\n$scope module {source} $end")?;
        for (wire, info) in header.wires.iter().enumerate() {
            let (board, channel) = (info.board, info.channel);
            writeln!(out, "$scope module wire{wire} $end")?;
            if emulated {
                let id = Code::new(wire, PIN);
                writeln!(out, "$var wire 1 {id} pin_b{board}_ch{channel} $end")?;
            }
            for (kind, name) in [(ON, "on_ticks"), (OFF, "off_ticks")] {
                writeln!(
                    out,
                    "$var reg 13 {} {name} [12:0] $end",
                    Code::new(wire, kind)
                )?;
            }
            if emulated {
                for (kind, name) in [(WIRE_C, "wire_celsius"), (SKIN_C, "skin_celsius")] {
                    writeln!(out, "$var real 64 {} {name} $end", Code::new(wire, kind))?;
                }
            }
            writeln!(out, "$upscope $end")?;
        }
        let face = Code(header.wires.len() * KINDS);
        if header.warmth {
            writeln!(out, "$var real 64 {face} face_celsius $end")?;
        }
        writeln!(out, "$upscope $end\n$enddefinitions $end\n#0\n$dumpvars")?;
        for wire in 0..header.wires.len() {
            if emulated {
                writeln!(out, "0{}", Code::new(wire, PIN))?;
            }
            for kind in [ON, OFF] {
                writeln!(out, "b0 {}", Code::new(wire, kind))?;
            }
        }
        writeln!(out, "$end")?;
        let outputs = header.wires.iter().map(|w| (w.board, w.channel));
        Ok(Self {
            outputs: outputs.collect(),
            out,
            emulated,
            now_ns: Some(0),
        })
    }

    /// Appends events in the order of time. One that comes late keeps its value and loses its place: a dump
    /// cannot go back.
    ///
    /// # Errors
    /// The writer's error.
    pub fn events(&mut self, events: &[Event]) -> io::Result<()> {
        for event in events {
            let t_ns = event.t_ns();
            match event {
                Event::Edge(edge) => {
                    let wire = self.wire(edge.board, edge.channel);
                    if let Some(wire) = wire.filter(|_| self.emulated) {
                        self.time(t_ns)?;
                        writeln!(self.out, "{}{}", u8::from(edge.high), Code::new(wire, PIN))?;
                    }
                }
                Event::Schedule(entry) => {
                    if let Some(wire) = self.wire(entry.board.0, entry.channel.0) {
                        self.ticks(t_ns, wire, entry.on, entry.off)?;
                    }
                }
                Event::AllOff(off) => {
                    for wire in 0..self.outputs.len() {
                        if self.outputs[wire].0 == off.board {
                            self.ticks(t_ns, wire, 0, 0)?;
                        }
                    }
                }
                Event::Wire(now) => self.celsius(now, WIRE_C)?,
                Event::Skin(now) => self.celsius(now, SKIN_C)?,
                Event::Face(now) => {
                    let face = Code(self.outputs.len() * KINDS);
                    self.time(t_ns)?;
                    writeln!(self.out, "r{} {face}", milli(now.face_mc.into()))?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Ends the dump at the end of the run.
    ///
    /// # Errors
    /// The writer's error.
    pub fn finish(mut self, end_ns: u64) -> io::Result<()> {
        self.time(end_ns)?;
        self.out.flush()
    }

    /// Writer of the file.
    pub const fn get_mut(&mut self) -> &mut W {
        &mut self.out
    }

    fn wire(&self, board: u8, channel: u8) -> Option<usize> {
        self.outputs.iter().position(|o| *o == (board, channel))
    }

    fn ticks(&mut self, t_ns: u64, wire: usize, on: u16, off: u16) -> io::Result<()> {
        self.time(t_ns)?;
        writeln!(self.out, "b{on:b} {}", Code::new(wire, ON))?;
        writeln!(self.out, "b{off:b} {}", Code::new(wire, OFF))
    }

    fn celsius(&mut self, now: &event::Temperature, kind: usize) -> io::Result<()> {
        let wire = usize::from(now.wire);
        if !self.emulated || wire >= self.outputs.len() {
            return Ok(());
        }
        self.time(now.t_us.saturating_mul(1000))?;
        let id = Code::new(wire, kind);
        writeln!(self.out, "r{} {id}", milli(now.milli_c.into()))
    }

    fn time(&mut self, t_ns: u64) -> io::Result<()> {
        if self.now_ns.is_none_or(|now| t_ns > now) {
            self.now_ns = Some(t_ns);
            writeln!(self.out, "#{t_ns}")?;
        }
        Ok(())
    }
}

/// The identifier code of a variable: a number in base 94, printable characters from `!`.
struct Code(usize);

impl Code {
    const fn new(wire: usize, kind: usize) -> Self {
        Self(wire * KINDS + kind)
    }
}

impl std::fmt::Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        use std::fmt::Write;
        let mut rest = self.0;
        loop {
            f.write_char(char::from(b'!' + (rest % 94) as u8))?;
            rest /= 94;
            if rest == 0 {
                return Ok(());
            }
            rest -= 1;
        }
    }
}

#[cfg(test)]
#[path = "vcd_tests.rs"]
mod tests;
