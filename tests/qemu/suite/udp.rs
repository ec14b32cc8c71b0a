//! The unit by UDP, in real time: what a host on a network meets.
#![allow(clippy::disallowed_methods, reason = "these tests live in real time")]

use std::fs::Permissions;
use std::net::UdpSocket;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration as Span, Instant as Wall};

use palpate_core::codec::link::{MOST, State};
use palpate_core::driver::{Actuators, UnitDriver, UnitSettings};
use palpate_core::guard::{Guard, Plant, WornWire};
use palpate_core::random::RandomStream;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Duration, Instant, Ticks};
use palpate_qemu::{Chips, Guest, Image, LIMITS, Machine, Network, WIRES, free_of};
use serde_json::Value;

use super::machines::{KEY, image, in_qemu};

/// A guest whose boards a thread of its own serves, and a socket to it.
struct Worn {
    socket: UdpSocket,
    chips: Arc<Mutex<Chips>>,
    driver: UnitDriver,
    guard: Guard,
    began: Wall,
    sent: Vec<Vec<u8>>,
    server: Option<JoinHandle<Guest>>,
    end: Arc<Mutex<bool>>,
}

in_qemu! {
    a_host_plays_by_udp_and_leaves_nothing_on
    ten_thousand_spoiled_datagrams_by_udp_switch_nothing_on
    the_program_runs_a_scene_on_it
}

fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Worn {
    fn start(machine: Machine) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        // A port that is free now; QEMU takes it in a moment.
        let port = UdpSocket::bind("127.0.0.1:0")
            .unwrap()
            .local_addr()
            .unwrap()
            .port();
        socket.connect(("127.0.0.1", port)).unwrap();
        socket.set_read_timeout(Some(Span::from_millis(1))).unwrap();
        let image = image(&machine, "unit");
        let mut guest = Guest::start(machine, &image, Network::Udp(port)).unwrap();
        let chips = Arc::new(Mutex::new(Chips::new(true)));
        let end = Arc::new(Mutex::new(false));
        let (served, ends) = (Arc::clone(&chips), Arc::clone(&end));
        let server = thread::spawn(move || {
            while !*locked(&ends) {
                let (head, bytes) = guest.question().unwrap();
                let (ns, outcome, bytes) = locked(&served).answer(&head, &bytes).unwrap();
                guest.answer(ns, outcome, &bytes).unwrap();
            }
            guest
        });
        let settings = UnitSettings {
            delay: Duration::from_millis(20),
            resumes: true,
        };
        Self {
            socket,
            chips,
            driver: UnitDriver::new(&KEY, u64::from(port), settings),
            guard: Guard::new(LIMITS, Plant::default(), &WIRES, WornWire::default()).unwrap(),
            began: Wall::now(),
            sent: Vec::new(),
            server: Some(server),
            end,
        }
    }

    fn now(&self) -> Instant {
        Instant::from_micros(self.began.elapsed().as_micros() as u64)
    }

    /// A look of the host's program.
    fn look(&mut self) {
        let mut buffer = [0; MOST];
        let now = self.now();
        if let Some(datagram) = self.driver.datagram(now, Some(now), &mut buffer) {
            self.sent.push(datagram.to_vec());
            // Before QEMU has its port this is refused.
            let _ = self.socket.send(datagram);
        }
        if let Ok(length) = self.socket.recv(&mut buffer) {
            let _ = self.driver.hear(self.now(), &mut buffer[..length]);
        }
    }

    fn run(&mut self, span: Span) {
        let until = Wall::now() + span;
        while Wall::now() < until {
            self.look();
        }
    }

    /// Until the unit can be driven.
    fn meet(&mut self) {
        let began = Wall::now();
        while self.driver.ready(self.now()).is_err() {
            assert!(began.elapsed() < Span::from_secs(30), "no answer by UDP");
            self.look();
        }
        self.run(Span::from_millis(100));
    }

    fn burst(&mut self, wire: u16) {
        let at = self.now();
        let stimulus = Stimulus {
            wire,
            width: Ticks::new(100),
            peak: Plant::default().peak,
            at,
            until: at + Duration::from_millis(38),
        };
        self.guard.hear(at);
        let update = self
            .guard
            .admit(at, Board((wire / 8) as u8), &[stimulus], |_| ());
        let _ = self.driver.apply(&update);
    }

    fn rises(&self) -> usize {
        locked(&self.chips).levels.iter().filter(|l| l.high).count()
    }
}

impl Worn {
    /// The guest's memory at the end.
    fn memory(mut self) -> Vec<u8> {
        *locked(&self.end) = true;
        let mut guest = self.server.take().unwrap().join().unwrap();
        guest.save_memory().unwrap();
        loop {
            let (head, bytes) = guest.question().unwrap();
            let (ns, outcome, bytes) = locked(&self.chips).answer(&head, &bytes).unwrap();
            guest.answer(ns, outcome, &bytes).unwrap();
            if let Some(memory) = guest.memory() {
                return memory;
            }
        }
    }
}

impl Drop for Worn {
    fn drop(&mut self) {
        *locked(&self.end) = true;
        if let Some(server) = self.server.take() {
            // Its own failure has been said already.
            let _ = server.join();
        }
    }
}

fn a_host_plays_by_udp_and_leaves_nothing_on(machine: Machine) {
    let mut worn = Worn::start(machine);
    worn.meet();
    for n in 0..20 {
        worn.burst(n % 16);
        worn.run(Span::from_millis(80));
    }
    let status = *worn.driver.status().unwrap();
    println!("{status:?}");
    assert!(status.applied > 15, "{status:?}");
    assert!(worn.rises() > 50, "{}", worn.rises());
    // The host dies in the middle of a burst.
    worn.burst(12);
    worn.run(Span::from_millis(25));
    thread::sleep(Span::from_millis(1500));
    let chips = locked(&worn.chips);
    assert!(!chips.any_high());
    assert_eq!(chips.boots.len(), 1);
    drop(chips);
    // Variables, the network's among them, and the deepest stack leave room.
    let file = Image::read(&image(&machine, "unit"), machine.memory.0).unwrap();
    let free = free_of(&worn.memory(), &file);
    println!("{} bytes of variables, {free} never used", file.variables);
    assert!(free >= 4096, "{free} bytes are left");
}

fn ten_thousand_spoiled_datagrams_by_udp_switch_nothing_on(machine: Machine) {
    let mut worn = Worn::start(machine);
    worn.meet();
    for n in 0..5 {
        worn.burst(n);
        worn.run(Span::from_millis(80));
    }
    let recorded = std::mem::take(&mut worn.sent);
    // The boards are seen as far as the last transfer; each is read back once per second.
    worn.run(Span::from_millis(1500));
    let rises = worn.rises();
    let mut s = RandomStream::new(2, "spoiled datagrams");
    for n in 0..10_000 {
        let mut datagram = recorded[(s.next_u64() as usize) % recorded.len()].clone();
        if n % 3 > 0 {
            super::sessions::spoil(&mut s, &mut datagram);
        }
        let _ = worn.socket.send(&datagram);
        if n % 8 == 0 {
            worn.look();
        }
    }
    worn.run(Span::from_millis(1000));
    assert_eq!(worn.rises(), rises);
    worn.meet();
    let status = *worn.driver.status().unwrap();
    println!("{status:?}");
    assert!(matches!(status.state, State::Ready), "{status:?}");
    assert!(status.refused > 1000, "{status:?}");
}

/// The program, which `ci/unit` builds.
fn hil() -> PathBuf {
    let built = std::env::var_os("PALPATE_HIL").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/debug/hil"),
        PathBuf::from,
    );
    assert!(
        built.exists(),
        "{}: expected the program; ci/unit builds it",
        built.display()
    );
    built
}

fn the_program_runs_a_scene_on_it(machine: Machine) {
    let worn = Worn::start(machine);
    let folder = std::env::temp_dir().join(format!("palpate-qemu-hil-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir(&folder).unwrap();
    let key = folder.join("unit.key");
    std::fs::write(&key, KEY.map(|byte| format!("{byte:02x}")).concat()).unwrap();
    std::fs::set_permissions(&key, Permissions::from_mode(0o600)).unwrap();
    let unit = worn.socket.peer_addr().unwrap().to_string();
    // The images count the periods of the plant that is theirs by default.
    let bench = include_str!("../../../fixtures/benches/emulated.toml");
    let [own, file] = ["drive.current_ma", "drive.pwm_hz = 200\ndrive.current_ma"];
    let (bench, path) = (bench.replace(own, file), folder.join("bench.toml"));
    std::fs::write(&path, bench).unwrap();
    let run = Command::new(hil())
        .args(["run", "sphere-along", "--json", "--unit", &unit])
        .args(["--illusion", "linear", "--bench"])
        .arg(&path)
        .arg("--key")
        .arg(&key)
        .env("PALPATE_STATE", &folder)
        .output()
        .unwrap();
    let _ = std::fs::remove_dir_all(&folder);
    let said = String::from_utf8_lossy(&run.stderr);
    let summary: Value = serde_json::from_slice(&run.stdout).unwrap_or_default();
    println!(
        "{}, {:?}: {}\n{said}",
        machine.name, run.status, summary["unit"]
    );
    // The boards are seen as far as the last transfer; each is read back once per second.
    thread::sleep(Span::from_millis(1500));
    assert!(!locked(&worn.chips).any_high());
    assert!(run.status.success(), "{said}");
    assert!(worn.rises() > 100, "{}", worn.rises());
}
