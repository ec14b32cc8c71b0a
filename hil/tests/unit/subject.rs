//! The kinds of unit that the suite runs against.

use std::collections::VecDeque;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use nix::fcntl::{FcntlArg, fcntl};
use palpate_buses::datagrams::Datagrams as Socket;
use palpate_buses::pacer::RunClock;
use palpate_core::codec::link::{Buffer, MOST};
use palpate_core::guard::{HARD, Plant};
use palpate_core::peltier::Regulator;
use palpate_core::physics::{PeltierParameters, Thermistor};
use palpate_core::units::{Duration, Instant};
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Edge, Pca9685, Pin};
use palpate_emulators::display::peltier::{Peltier, PeltierHandle};
use palpate_emulators::time::Nanos;
use palpate_emulators::unit::OeLine;
use palpate_unit::{Datagrams, Settings, Unit};
use serde_json::Value;

use super::held::{KEY, Seen, Subject, wires};

#[derive(Default)]
struct Air {
    there: VecDeque<Vec<u8>>,
    back: Vec<Vec<u8>>,
}

impl Datagrams for Air {
    type Peer = ();

    fn receive(&mut self, buffer: &mut Buffer) -> Option<(usize, ())> {
        let datagram = self.there.pop_front()?;
        let length = datagram.len().min(MOST);
        buffer[..length].copy_from_slice(&datagram[..length]);
        Some((length, ()))
    }

    fn send(&mut self, datagram: &[u8], (): ()) {
        self.back.push(datagram.to_vec());
    }
}

/// The unit's own code in virtual time.
pub struct Model {
    unit: Unit<I2cHandle, OeLine, PeltierHandle>,
    bus: I2cHandle,
    module: PeltierHandle,
    air: Air,
    now: u64,
    high: [Option<u64>; 16],
    seen: Seen,
}

impl Model {
    pub fn new() -> Self {
        let chips = vec![Pca9685::new(Config::new(0x40))];
        let bus = I2cHandle::new(I2cSegment::new(BusClock::Fast, chips));
        let settings = Settings {
            key: &KEY,
            boot: 99,
            wires: &wires(),
            addresses: &[0x40],
            limits: HARD,
            plant: Plant::default(),
            worn: None,
            converters: None,
        };
        let (parameters, thermistor) = (PeltierParameters::default(), Thermistor::default());
        let module = PeltierHandle::new(Peltier::new(parameters, thermistor, 25.0));
        let warms = (module.clone(), Regulator::new(parameters, thermistor));
        let lines = (bus.clone(), OeLine(bus.clone()));
        let mut unit = Unit::warming(&settings, lines, Some(warms)).unwrap();
        unit.start(Instant::from_micros(1));
        Self {
            unit,
            bus,
            module,
            air: Air::default(),
            now: 1,
            high: [None; 16],
            seen: Seen::default(),
        }
    }

    fn advance(&mut self) {
        let (high, seen) = (&mut self.high, &mut self.seen);
        let mut each = |_: usize, edge: Edge| {
            let channel = usize::from(edge.channel.0);
            seen.edge(high, channel, edge.at.0, edge.pin == Pin::High);
        };
        let to = Nanos(self.now * 1000);
        self.module.with(|module| module.advance(to));
        self.bus
            .with(|segment| segment.advance(to, &mut each))
            .unwrap();
    }
}

impl Subject for Model {
    fn now(&self) -> Instant {
        Instant::from_micros(self.now)
    }

    fn send(&mut self, datagram: &[u8]) {
        self.air.there.push_back(datagram.to_vec());
    }

    fn pass(&mut self, time: Duration) -> Vec<Vec<u8>> {
        let end = self.now + time.as_micros();
        loop {
            self.advance();
            let now = Instant::from_micros(self.now);
            self.unit.turn(now, &mut self.air);
            if self.now >= end && self.air.there.is_empty() {
                return std::mem::take(&mut self.air.back);
            }
            self.now = (self.now + 100).min(end.max(self.now));
        }
    }

    fn end(mut self) -> Seen {
        self.unit.end(Instant::from_micros(self.now));
        self.now += 20_000;
        self.advance();
        self.seen.high = self.high.iter().flatten().count();
        self.seen.refused = self.unit.counts().refused.into();
        self.seen
    }
}

/// A folder of its own, gone with it.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("palpate-unit-{}-{n}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Writes a key file.
pub fn write_key(path: &Path, key: &[u8; 32]) {
    use std::os::unix::fs::PermissionsExt;
    let hex: String = key.iter().map(|byte| format!("{byte:02x}")).collect();
    fs::write(path, hex).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o600)).unwrap();
}

/// The program, with a state folder of its own.
pub fn hil(folder: &Folder) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
    command
        .current_dir(&folder.0)
        .env("PALPATE_STATE", folder.0.join("state"));
    command
}

/// `hil unit` on emulated boards, over UDP.
pub struct Process {
    pub folder: Folder,
    child: Child,
    lines: BufReader<ChildStdout>,
    pub address: std::net::SocketAddr,
    socket: Socket,
    clock: RunClock,
}

impl Process {
    pub fn new() -> Self {
        Self::on(&[])
    }

    /// The same with further arguments.
    pub fn on(more: &[&str]) -> Self {
        Self::with(&KEY, more)
    }

    /// The same under a key of its own: to the programs of a computer a unit is its key.
    pub fn alone(more: &[&str]) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(1);
        let mut key = KEY;
        key[..4].copy_from_slice(&std::process::id().to_le_bytes());
        key[4..8].copy_from_slice(&COUNT.fetch_add(1, Ordering::Relaxed).to_le_bytes());
        Self::with(&key, more)
    }

    fn with(key: &[u8; 32], more: &[&str]) -> Self {
        let folder = Folder::new();
        write_key(&folder.0.join("unit.key"), key);
        let mut command = hil(&folder);
        command.args(["unit", "--json", "--key", "unit.key", "--at", "127.0.0.1:0"]);
        command.args(more);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap());
        let mut first = String::new();
        lines.read_line(&mut first).unwrap();
        let serving: Value = serde_json::from_str(&first).unwrap();
        let address = serving["address"].as_str().unwrap().parse().unwrap();
        Self {
            folder,
            child,
            lines,
            address,
            socket: Socket::towards(address).unwrap(),
            clock: RunClock::start(),
        }
    }

    /// From now on its pipe takes little that nobody reads.
    pub fn narrow(&self) {
        let size = FcntlArg::F_SETPIPE_SZ(4096);
        fcntl(self.lines.get_ref(), size).unwrap();
    }

    /// Blocks until it has told of so many rising edges.
    pub fn wait_for_edges(&mut self, count: usize) -> Vec<Value> {
        let mut told = Vec::new();
        let mut line = String::new();
        let mut rising = 0;
        while rising < count && self.lines.read_line(&mut line).unwrap() > 0 {
            let event: Value = serde_json::from_str(&line).unwrap();
            rising += usize::from(event["event"] == "edge" && event["high"] == true);
            told.push(event);
            line.clear();
        }
        told
    }

    /// Ends it with a signal; everything it told since, the record last.
    pub fn finish(mut self) -> Vec<Value> {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args(["-TERM", &id]).status().unwrap();
        assert!(sent.success());
        let lines = self.lines.by_ref().lines();
        let told = lines.map(|line| serde_json::from_str(&line.unwrap()).unwrap());
        let told = told.collect();
        assert!(self.child.wait().unwrap().success());
        told
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What its JSON Lines say of its outputs.
pub fn seen(told: &[Value]) -> Seen {
    let (mut seen, mut high) = (Seen::default(), [None; 16]);
    for event in told.iter().filter(|event| event["event"] == "edge") {
        let channel = event["channel"].as_u64().unwrap() as usize;
        let t_ns = event["t_ns"].as_u64().unwrap();
        seen.edge(&mut high, channel, t_ns, event["high"] == true);
    }
    let record = told.last().unwrap();
    assert_eq!(record["event"], "record");
    seen.high = high.iter().flatten().count() + usize::from(record["off"] != true);
    seen.refused = record["refused"].as_u64().unwrap();
    seen
}

impl Subject for Process {
    fn now(&self) -> Instant {
        self.clock.now()
    }

    fn send(&mut self, datagram: &[u8]) {
        self.socket.send(datagram, self.address);
    }

    fn pass(&mut self, time: Duration) -> Vec<Vec<u8>> {
        self.clock.sleep_until(self.clock.now() + time);
        let mut buffer = [0; MOST];
        let received = std::iter::from_fn(|| {
            let (length, _) = self.socket.receive(&mut buffer)?;
            Some(buffer[..length].to_vec())
        });
        received.collect()
    }

    fn end(self) -> Seen {
        seen(&self.finish())
    }
}
