//! `palpate-link` on hardware at both ends: a skin of boards on vcan0, a display on a board at an I2C node, and the network
//! of this machine between them. `ci/link bench` runs it, since zenoh takes minutes to build.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;

use super::tools::{hil, in_lab, scene, scratch, sh};
use super::ward::{Fate, HEARTBEAT_MS, Run, TooSlow, Ward, cool, guardian_of, now_ns, patiently};

const FINGER: [&str; 2] = ["--finger", "r1/left/index"];
const AT: &str = "127.0.0.1:7450";
/// Off within this of the newest reading: a turn comes once per millisecond, a transfer takes half of one.
const STALE_NS: u64 = 103_000_000;
/// Silence between two bursts finds no wire driven and stops nothing: so often is a skin killed at most until one is.
const KILLS: usize = 5;
/// The guardian's own work on top of its patience.
const SLACK_NS: u64 = 40_000_000;

/// A process with what it says and prints.
struct Program {
    run: Run,
    said: PathBuf,
    told: PathBuf,
}

impl Program {
    fn start(name: &str, words: &[&str]) -> (Child, PathBuf, PathBuf) {
        let [said, told] = ["said", "json"].map(|what| scratch(&format!("link-{name}.{what}")));
        let child = Command::new(std::env::var("PALPATE_LINK").unwrap())
            .args([&[name, &scene("press.toml"), "--json"], &FINGER[..], words].concat())
            .env("PALPATE_DRILL", "1")
            .stdin(Stdio::null())
            .stdout(File::create(&told).unwrap())
            .stderr(File::create(&said).unwrap())
            .spawn();
        (child.unwrap(), said, told)
    }

    fn said(&self) -> String {
        std::fs::read_to_string(&self.said).unwrap()
    }

    fn told(&self) -> Value {
        serde_json::from_str(&std::fs::read_to_string(&self.told).unwrap()).unwrap()
    }
}

/// A robot's skin.
struct Skin {
    child: Child,
    said: PathBuf,
}

impl Skin {
    fn start() -> Self {
        let (child, said, _) = Program::start("skin", &["--can", "vcan0", "--connect", AT]);
        Self { child, said }
    }

    fn strike(&mut self, signal: Signal) -> String {
        kill(Pid::from_raw(self.child.id() as i32), signal).unwrap();
        self.child.wait().unwrap();
        std::fs::read_to_string(&self.said).unwrap()
    }
}

impl Drop for Skin {
    /// A failed test leaves no process behind.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Skin and display, of which the second drives.
fn felt(ward: &mut Ward) -> (Skin, Program) {
    ward.stop_boards();
    cool();
    ward.emulator.told.clear();
    let bench = ward.bench().display().to_string();
    let (mut child, said, told) = Program::start("display", &["--bench", &bench, "--listen", AT]);
    let mut skin = Skin::start();
    ward.emulator.wait_while("driving", || {
        let said = [&said, &skin.said].map(|said| std::fs::read_to_string(said).unwrap());
        assert!(child.try_wait().unwrap().is_none(), "no display: {said:?}");
        assert!(
            skin.child.try_wait().unwrap().is_none(),
            "no skin: {said:?}"
        );
    });
    let guardian = guardian_of(&child);
    // Felt for a while, and struck in a burst.
    ward.emulator.hear(Duration::from_millis(1500));
    ward.emulator.wait_for("driving");
    let run = Run { child, guardian };
    (skin, Program { run, said, told })
}

/// Refused with status 4 while the stop is latched; then a person clears it.
fn is_latched(ward: &Ward, cause: &str) {
    let held = ward.latch().read().unwrap();
    assert!(held.cause.starts_with(cause), "{held:?}");
    let bench = ward.bench().display().to_string();
    let (mut child, said, _) = Program::start("display", &["--bench", &bench, "--listen", AT]);
    let status = child.wait().unwrap();
    let said = std::fs::read_to_string(said).unwrap();
    assert_eq!(status.code(), Some(4), "{said}");
    assert!(said.contains("stopped earlier"), "{said}");
    let cleared = sh(&format!(
        "{} off --unlatch --bench {bench}",
        hil().display()
    ));
    assert!(cleared.contains("the stop is cleared"), "{cleared}");
}

fn off_within(ward: &mut Ward, struck_ns: u64, limit_ns: u64, what: &str) {
    let fate = ward.fate(struck_ns);
    println!("{what}: {fate:?}");
    assert!(
        matches!(fate, Fate::Off(ns) if ns.is_none_or(|ns| ns <= limit_ns)),
        "{what}: {fate:?}"
    );
}

#[test]
fn boards_on_can_are_felt_on_an_i2c_board_until_either_end_is_gone() {
    if !in_lab("two ends of a link on hardware") {
        return;
    }
    sh("ip link set lo up");
    patiently(until_gone);
}

/// The robot's program dies. The display goes on without outputs, and says so in the end where a wire was driven at the time;
/// whether one was.
fn dies(ward: &mut Ward) -> Result<bool, TooSlow> {
    let (mut skin, mut display) = felt(ward);
    ward.check_speed()?;
    let struck_ns = now_ns();
    skin.strike(Signal::SIGKILL);
    off_within(ward, struck_ns, STALE_NS, "the skin is killed");
    ward.check_speed()?;
    let said = display.said();
    assert!(display.run.child.try_wait().unwrap().is_none(), "{said}");
    kill(display.run.pid(), Signal::SIGINT).unwrap();
    let ended = display.run.end();
    let (said, told) = (display.said(), display.told());
    assert!(told["held"].as_u64().unwrap() > 20, "{told}");
    if ended.success() {
        assert_eq!(ward.latch().read(), None, "{said}");
        return Ok(false);
    }
    assert_eq!(ended.code(), Some(4), "{said}");
    assert!(said.contains("stale-input"), "{said}");
    is_latched(ward, "stale-input");
    Ok(true)
}

fn until_gone() -> Result<(), TooSlow> {
    let mut ward = Ward::open(&scene("press.toml"), &["--oe"]);
    let mut stopped = false;
    for _ in 0..KILLS {
        stopped = dies(&mut ward)?;
        if stopped {
            break;
        }
    }
    assert!(stopped, "{KILLS} skins died between two bursts");

    // The wearer's STOP: in order, and nothing is latched.
    let (mut skin, mut display) = felt(&mut ward);
    ward.check_speed()?;
    let struck_ns = now_ns();
    kill(display.run.pid(), Signal::SIGINT).unwrap();
    let ended = display.run.end();
    ward.check_speed()?;
    assert!(ended.success(), "{ended}: {}", display.said());
    off_within(&mut ward, struck_ns, STALE_NS, "the wearer's STOP");
    assert_eq!(ward.latch().read(), None);
    let heard = skin.strike(Signal::SIGINT);
    assert!(heard.contains("stopped by SIGINT"), "{heard}");

    // The display dies: the guardian switches off.
    let (skin, mut display) = felt(&mut ward);
    ward.check_speed()?;
    let struck_ns = now_ns();
    kill(display.run.pid(), Signal::SIGKILL).unwrap();
    display.run.end();
    let limit_ns = HEARTBEAT_MS * 1_000_000 + SLACK_NS;
    off_within(&mut ward, struck_ns, limit_ns, "the display is killed");
    drop(skin);
    is_latched(&ward, "the run died without a word");
    let record = ward.emulator.stop();
    assert_eq!(record["driving"], Value::Array(Vec::new()), "{record}");
    Ok(())
}

#[test]
fn a_display_whose_adapter_is_gone_ends_as_a_run_does() {
    if !in_lab("a display's adapter unplugged") {
        return;
    }
    sh("ip link set lo up");
    patiently(unplugged);
}

fn unplugged() -> Result<(), TooSlow> {
    let mut ward = Ward::open(&scene("press.toml"), &[]);
    let (_skin, mut display) = felt(&mut ward);
    ward.check_speed()?;
    let driver = "/sys/bus/hid/drivers/mcp2221";
    let device = sh(&format!("ls {driver} | grep -m1 04D8"));
    std::fs::write(format!("{driver}/unbind"), device.trim()).unwrap();
    let ended = display.run.child.wait().unwrap();
    assert_eq!(ended.code(), Some(3), "{}", display.said());
    // The guardian waits for the adapter, and switches off what is on it.
    std::fs::write(format!("{driver}/bind"), device.trim()).unwrap();
    display.run.end();
    assert!(matches!(ward.fate(0), Fate::Off(_)));
    ward.emulator.stop();
    Ok(())
}
