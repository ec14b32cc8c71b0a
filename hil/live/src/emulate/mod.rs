//! Serving the emulators to other programs: boards on CAN interfaces, the display behind an I2C node.
//!
//! The emulators' time is the wall clock's: before anything is sent, heard or answered they are advanced
//! to now. An I2C transfer is answered when it would have ended on the wire, so no client can be faster than
//! the bus. The clock delays what happens and changes no value.

mod display;
mod hardware;
mod motors;
mod record;
mod served;

use std::collections::VecDeque;
use std::os::fd::AsFd;

use palpate_buses::served::can::Interface;
use palpate_buses::served::mcp2221::{Mcp2221, REPORT};
use palpate_buses::served::uhid::{Request, Uhid};
use palpate_buses::served::wait::{Signals, monotonic_ns, wait};
use palpate_emulators::time::Nanos;

use palpate_files::Setup;
use palpate_run::Failure;

pub(crate) use display::ServedDisplay;
use hardware::{Hardware, starts};
use record::Told;
pub use record::{CanRecord, Flowed, MotorRecord, PinEdge, Record, Shaken, WireRecord, Worked};

use crate::telling::{Teller, Telling};

/// Time whose frames leave together once its last one has ended on the emulated wire: a turn for each frame would be
/// too many on a full bus.
const TURN_NS: u64 = 500_000;
/// Time between two looks at the outputs when nothing else happens.
const IDLE_NS: u64 = 10_000_000;
/// Longest time for the kernel to make a node of the bridge.
const NODE_NS: u64 = 60_000_000_000;
/// The bridge's pin that an OE line hangs on.
const OE_PIN: usize = 0;

/// Interfaces, seed and output of an emulator that serves.
#[derive(Clone, Debug)]
pub struct Options {
    /// CAN interfaces; empty: vcan0 and on, one a sensor bus.
    pub can: Vec<String>,
    /// `true` to begin the scene with a start command.
    pub await_start: bool,
    /// Pin 0 of the bridge, a GPIO line, is on the chips' OE pins, with a pull-up: cut until a client drives it
    /// low.
    pub oe: bool,
    /// Seed of all randomness.
    pub seed: u64,
    /// Form of the words on standard output.
    pub telling: Telling,
}

/// Serves until a signal comes.
///
/// # Errors
/// [`Failure::Input`] for a scene or bench that cannot be built, [`Failure::Device`] for an interface or a node that is
/// not to be had, with the remedy.
pub fn serve(setup: &Setup, options: &Options) -> Result<(), Failure> {
    let mut hardware = Hardware::new(setup, options)?;
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    let can = open(&options.can, hardware.buses())?;
    let uhid = Uhid::plug().map_err(|e| {
        Failure::Device(format!(
            "/dev/uhid: {e}; the I2C node needs root and `modprobe -a uhid hid-mcp2221 i2c-dev`"
        ))
    })?;
    let teller = Teller::new(options.telling)?;
    let epoch = monotonic_ns();
    if options.oe {
        hardware.display.set_output_enable(Nanos::ZERO, true);
    }
    if !options.await_start {
        hardware.begin_scene(Nanos::ZERO)?;
    }
    let record = Record {
        source: "emulated",
        can: can.iter().map(|i| named(i.name())).collect(),
        ..Record::default()
    };
    Server {
        setup,
        await_start: options.await_start,
        oe: options.oe.then_some(true),
        driving: hardware.display.driving(),
        hardware,
        can,
        uhid,
        bridge: Mcp2221::default(),
        answers: VecDeque::new(),
        signals,
        epoch,
        node: None,
        record,
        teller,
    }
    .run()
}

fn broken(error: std::io::Error) -> Failure {
    Failure::Device(format!("/dev/uhid: {error}"))
}

fn named(name: &str) -> CanRecord {
    CanRecord {
        name: name.into(),
        ..CanRecord::default()
    }
}

/// Opens one interface a sensor bus.
fn open(names: &[String], buses: usize) -> Result<Vec<Interface>, Failure> {
    let names = if names.is_empty() {
        (0..buses).map(|n| format!("vcan{n}")).collect()
    } else {
        names.to_vec()
    };
    if names.len() != buses {
        return Err(Failure::Input(format!(
            "--can: the scene's layout has {buses} sensor buses, found {} interfaces",
            names.len()
        )));
    }
    let interface = |name: &String| {
        Interface::open(name).map_err(|e| {
            Failure::Device(format!(
                "{name}: {e}; for a virtual interface: `modprobe vcan; ip link add {name} type vcan; \
                 ip link set {name} up` as root"
            ))
        })
    };
    names.iter().map(interface).collect()
}

/// The served hardware, and the time until which it has run.
struct Server<'a> {
    setup: &'a Setup,
    await_start: bool,
    /// The level of the line on the OE pins, if there is one.
    oe: Option<bool>,
    hardware: Hardware<'a>,
    can: Vec<Interface>,
    uhid: Uhid,
    bridge: Mcp2221,
    /// Answers of the bridge, each with the time at which it may go.
    answers: VecDeque<(Nanos, [u8; REPORT])>,
    signals: Signals,
    /// The monotonic clock at the emulators' zero.
    epoch: u64,
    /// The I2C node, once there is one.
    node: Option<String>,
    /// The chips by address, and whether each drives.
    driving: Vec<(u8, bool)>,
    record: Record,
    teller: Teller,
}

impl Server<'_> {
    fn now(&self) -> Nanos {
        Nanos(monotonic_ns().saturating_sub(self.epoch))
    }

    /// Keeps the largest lateness of messages: one that was due at `due` leaves now.
    fn was_due(&mut self, due: Nanos, now: Nanos) {
        let late_ms = now.since(due).0 as f64 / 1e6;
        self.record.latest_ms = self.record.latest_ms.max(late_ms);
    }

    fn run(mut self) -> Result<(), Failure> {
        let mut ready = vec![true; 2 + self.can.len()];
        while !(ready[0] && self.signals.raised()) {
            self.advance()?;
            self.exchange_frames(&ready[2..])?;
            if ready[1] {
                self.take_requests()?;
            }
            self.answer_requests()?;
            self.look_at_outputs()?;
            self.find_node()?;
            self.teller.flush()?;
            ready = self.sleep()?;
        }
        self.finish()
    }

    /// Waits until a client asks for something or there is something to do.
    fn sleep(&self) -> Result<Vec<bool>, Failure> {
        let now = self.now();
        let frames = self.hardware.next_event().max(now + Nanos(TURN_NS));
        let answer = self.answers.front().map_or(Nanos::MAX, |a| a.0);
        let until = frames.min(answer).min(now + Nanos(IDLE_NS));
        let mut fds = vec![self.signals.as_fd(), self.uhid.as_fd()];
        fds.extend(self.can.iter().map(AsFd::as_fd));
        wait(&fds, self.epoch + until.0).map_err(|e| Failure::Device(format!("waiting: {e}")))
    }

    /// Advances the emulators to the clock's time.
    fn advance(&mut self) -> Result<(), Failure> {
        let (now, epoch, teller) = (self.now(), self.epoch, &mut self.teller);
        let tell = |edge| teller.tell(&Told::Edge(edge));
        let faults = self.hardware.advance(now, epoch, tell)?;
        let t_ns = epoch + now.0;
        let mut tell = |text: &String| teller.tell(&Told::Fault { t_ns, text });
        faults.iter().try_for_each(&mut tell)
    }

    /// Sends the boards' frames, and takes everybody else's.
    fn exchange_frames(&mut self, ready: &[bool]) -> Result<(), Failure> {
        let gone = |name: &str, e: std::io::Error| Failure::Device(format!("{name}: {e}"));
        let now = self.now();
        while let Some((due, received)) = self.hardware.frame() {
            self.was_due(due, now);
            if let Some(interface) = self.can.get_mut(usize::from(received.bus)) {
                let sent = interface.send(&received.frame);
                sent.map_err(|e| gone(interface.name(), e))?;
            }
        }
        for (bus, _) in ready.iter().enumerate().filter(|r| *r.1) {
            loop {
                let interface = &mut self.can[bus];
                let heard = interface.receive();
                let Some(frame) = heard.map_err(|e| gone(interface.name(), e))? else {
                    break;
                };
                if self.await_start && starts(&frame) && !self.hardware.sends() {
                    let now = self.now();
                    self.hardware.begin_scene(now)?;
                    let t_ns = self.epoch + now.0;
                    self.teller.tell(&Told::Started { t_ns })?;
                } else if !self.hardware.hear(bus, &frame) {
                    self.record.can[bus].crowded_out += 1;
                }
            }
        }
        Ok(())
    }

    /// Takes requests of the kernel's driver to the bridge.
    fn take_requests(&mut self) -> Result<(), Failure> {
        while let Some(request) = self.uhid.receive().map_err(broken)? {
            match &request {
                Request::Report(report) => {
                    self.advance()?;
                    let (_, before) = self.hardware.display.transfers();
                    let answer = self.bridge.answer(report, &mut self.hardware.i2c());
                    let (end, after) = self.hardware.display.transfers();
                    self.follow_oe()?;
                    // A report that needed no bus is answered at once.
                    let due = if after > before { end } else { Nanos::ZERO };
                    self.answers.extend(answer.map(|a| (due, a)));
                }
                _ => self.uhid.refuse(&request).map_err(broken)?,
            }
        }
        Ok(())
    }

    /// Passes the bridge's pin on to the chips; one that is not driven is pulled up.
    fn follow_oe(&mut self) -> Result<(), Failure> {
        let high = self.bridge.pin(OE_PIN).unwrap_or(true);
        if self.oe.is_some_and(|level| level != high) {
            self.oe = Some(high);
            let now = self.now();
            self.advance()?;
            self.hardware.display.set_output_enable(now, high);
            let t_ns = self.epoch + now.0;
            self.teller.tell(&Told::Oe { t_ns, high })?;
        }
        Ok(())
    }

    /// Gives the answers that are due.
    fn answer_requests(&mut self) -> Result<(), Failure> {
        let now = self.now();
        while let Some((due, answer)) = self.answers.pop_front_if(|a| a.0 <= now) {
            if due > Nanos::ZERO {
                self.was_due(due, now);
            }
            self.uhid.send(&answer).map_err(broken)?;
        }
        Ok(())
    }

    /// Tells of chips that have begun or ceased to drive outputs.
    fn look_at_outputs(&mut self) -> Result<(), Failure> {
        let driving = self.hardware.display.driving();
        let t_ns = self.epoch + self.hardware.display.changed().0;
        for (&(chip, is), &(_, was)) in driving.iter().zip(&self.driving) {
            if is && !was {
                self.teller.tell(&Told::Driving { t_ns, chip })?;
            } else if was && !is {
                self.teller.tell(&Told::AllOff { t_ns, chip })?;
            }
        }
        self.driving = driving;
        Ok(())
    }

    /// Tells the served interfaces once the kernel has a node for the bridge.
    fn find_node(&mut self) -> Result<(), Failure> {
        if self.node.is_some() {
            return Ok(());
        }
        let t_ns = monotonic_ns();
        // The driver makes the GPIO chip after the adapter.
        let gpio = self.uhid.gpio().map(|chip| chip.display().to_string());
        let nodes = self
            .uhid
            .node()
            .filter(|_| self.oe.is_none() || gpio.is_some());
        if let Some(node) = nodes {
            let node = node.display().to_string();
            self.teller.tell(&Told::Serving {
                t_ns,
                scene: &self.setup.scene.value.name,
                can: self.can.iter().map(Interface::name).collect(),
                i2c: &node,
                chips: self.driving.iter().map(|chip| chip.0).collect(),
                kind: self.hardware.display.kind(),
                oe: gpio.as_deref().filter(|_| self.oe.is_some()),
            })?;
            self.record.i2c.clone_from(&node);
            self.node = Some(node);
            // The search for the node is none of the boards' lateness.
            self.record.latest_ms = 0.0;
        } else if t_ns > self.epoch + NODE_NS {
            return Err(Failure::Device(
                "the kernel made no /dev/i2c-N of the bridge: `modprobe -a hid-mcp2221 i2c-dev` as root"
                    .into(),
            ));
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(), Failure> {
        self.advance()?;
        self.look_at_outputs()?;
        let record = &mut self.record;
        record.served_s = monotonic_ns().saturating_sub(self.epoch) as f64 / 1e9;
        for (record, interface) in record.can.iter_mut().zip(&self.can) {
            let counts = interface.counts();
            (record.sent, record.lost) = (counts.sent, counts.lost);
            (record.received, record.foreign) = (counts.received, counts.foreign);
        }
        record.transfers = self.hardware.display.transfers().1;
        record.worked = Some(self.hardware.display.worked());
        record.driving = (self.driving.iter().filter(|c| c.1).map(|c| c.0)).collect();
        self.teller.finish(&Told::Record(&self.record))
    }
}
