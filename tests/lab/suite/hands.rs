//! A bench of two displays: both are driven, each fails alone, and what ends the run switches off both. Each has an adapter
//! of its own, or both are on one board.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::fmt::Write as _;
use std::fs::File;
use std::io::{Read, Write as _};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use nix::pty::{Winsize, openpty};
use nix::sys::signal::{Signal, kill};
use palpate_buses::can::Endpoint;
use palpate_buses::guardian::Latch;
use palpate_core::codec::can::CanFrame;
use serde_json::Value;

use super::deaths::stop_thread;
use super::emulator::Emulator;
use super::tools::{hil, in_lab, scene, scratch, sh, text, vcan};
use super::ward::{Fate, TooSlow, Ward, fate, now_ns, patiently};

/// Longer than a run goes on with a dead bus, 3 s.
const GIVEN_UP: Duration = Duration::from_millis(4500);

/// Everything is off within this after a blow.
const LIMIT_NS: u64 = 100_000_000;

/// The bridge on the ward's adapter has the OE line of its chips; on one board there is no other adapter.
#[derive(Clone, Copy, Default)]
struct Built<'a> {
    oe: bool,
    one_board: bool,
    /// What happens to the thumb's adapter.
    faults: &'a str,
}

/// Two emulated boards, adapters and thimbles: `index` is the ward's, `thumb` the other one's.
struct Hand {
    ward: Ward,
    thumb: Emulator,
    /// The thumb's sensor bus.
    can: Endpoint,
    scene: String,
}

impl Hand {
    fn open() -> Self {
        Self::built(Built::default())
    }

    fn built(built: Built<'_>) -> Self {
        let press = scene("press.toml");
        let failing = scratch("failing.toml");
        let text = std::fs::read_to_string(&press).unwrap();
        std::fs::write(&failing, text + built.faults).unwrap();
        let failing = failing.display().to_string();
        vcan("vcan1");
        let thumb = Emulator::start(&["--await-start", "--scene", &failing, "--can", "vcan1"]);
        let ward = Ward::open(&press, if built.oe { &["--oe"] } else { &[] });
        let nodes = [&*ward.emulator.node, &*thumb.node];
        let mut text = match built.one_board {
            true => bench(&nodes[..1], "three-in-line", [(0, 0), (0, 3)]),
            false => bench(&nodes, "thimble-8", [(0, 0), (1, 0)]),
        };
        if let Some(chip) = &ward.emulator.oe {
            let oe = format!("[real]\noe = {{ chip = \"{chip}\", line = 0 }}\n");
            text = text.replace("[real]\n", &oe);
        }
        std::fs::write(ward.bench(), text).unwrap();
        let this = Self {
            scene: two_fingers(&press),
            can: Endpoint::open("vcan1", &[]).unwrap(),
            ward,
            thumb,
        };
        this.unlatch();
        this
    }

    fn latches(&self) -> [Latch; 2] {
        [&self.ward.emulator.node, &self.thumb.node].map(|node| Latch::of(Path::new(node)))
    }

    fn unlatch(&self) {
        self.latches()
            .iter()
            .for_each(|latch| latch.clear().unwrap());
    }

    /// The thumb's board is silent from now on, until a start command.
    fn silence_thumb(&self) {
        let stop = CanFrame::new(0x20F, &[0x07, 0x01]).unwrap();
        self.can.send(&stop).unwrap();
    }

    /// A run that drives both.
    fn run(&mut self) -> super::ward::Run {
        self.silence_thumb();
        self.thumb.told.clear();
        let run = self.ward.run(&self.scene.clone(), &[]);
        self.thumb.wait_for("driving");
        run
    }

    /// A finger that this machine was too slow for says so in the end.
    fn check_speed(&self) -> Result<(), TooSlow> {
        match self.ward.said().contains("late-tick") {
            true => Err(TooSlow),
            false => Ok(()),
        }
    }

    /// Both are known to be off.
    fn is_off(&mut self) {
        assert!(matches!(self.ward.fate(0), Fate::Off(_)), "index");
        assert!(matches!(fate(&mut self.thumb, 0), Fate::Off(_)), "thumb");
    }

    /// The next run is refused, for this; then a person clears it.
    fn is_latched(&self, cause: &str) {
        let refused = self.ward.command(&self.scene, &[]).output().unwrap();
        let said = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(4), "{said}");
        assert!(said.contains(cause), "{said}");
        let (hil, bench) = (hil().display(), self.ward.bench().display());
        let cleared = sh(&format!("{hil} off --unlatch --bench {bench}"));
        assert!(cleared.contains("the stop is cleared"), "{cleared}");
        assert!(self.latches().iter().all(|latch| latch.read().is_none()));
    }
}

/// When an event was.
fn at(told: &Value) -> u64 {
    told["t_ns"].as_u64().unwrap()
}

/// When outputs of these channels went high.
fn highs(told: &[Value], channels: std::ops::Range<u64>) -> impl Iterator<Item = u64> {
    let is_high = move |t: &&Value| {
        t["event"] == "edge"
            && t["high"] == true
            && channels.contains(&t["channel"].as_u64().unwrap())
    };
    told.iter().filter(is_high).map(at)
}

/// The suite's bench with a display of this layout at each of these adapters and channels.
fn bench(nodes: &[&str], layout: &str, places: [(usize, usize); 2]) -> String {
    let text = std::fs::read_to_string(scene("bench.toml")).unwrap();
    let head = text.split("[[outputs]]").next().unwrap();
    let mut bench = head
        .replace("\"/dev/i2c-0\"", &format!("\"{}\"", nodes.join("\", \"")))
        .replace("[\"vcan0\"]", "[\"vcan0\", \"vcan1\"]")
        .replace("thimble-8", layout);
    let wires = if layout == "thimble-8" { 8 } else { 3 };
    for (name, (bus, first)) in ["index", "thumb"].iter().zip(places) {
        let output = |channel| format!("{{ bus = {bus}, board = 0x40, channel = {channel} }}");
        let outputs: Vec<String> = (first..first + wires).map(output).collect();
        let outputs = outputs.join(", ");
        write!(
            bench,
            "\n[[displays]]\nname = \"{name}\"\noutputs = [{outputs}]\n"
        )
        .unwrap();
    }
    bench
}

/// The suite's scene, with a module on each sensor bus and a finger for each.
fn two_fingers(press: &str) -> String {
    let modules = [0, 1].map(|bus| {
        format!(
            "[[modules]]\nname = \"pad-{bus}\"\ngrid = {{ rows = 4, columns = 4, pitch_mm = 4.7 }}\nplace_mm = [{}.0, 0.0]\nbus = {bus}\nboards = [4]\n",
            bus * 30
        )
    });
    let layout = scratch("two-pads.toml");
    let head = "kind = \"sensor\"\nname = \"two-pads\"\ndescription = \"Two pads\"\n";
    std::fs::write(&layout, format!("{head}{}", modules.concat())).unwrap();
    let fingers = ["index", "thumb"].iter().zip(0..).map(|(name, module)| {
        format!("\n[[fingers]]\ndisplay = \"{name}\"\nmodules = [{module}]\n")
    });
    let text = std::fs::read_to_string(press).unwrap();
    let layout = format!("layout = \"{}\"", layout.display());
    let text = text.replace("layout = \"uskin-4x4\"", &layout);
    // Bursts of two displays on one board take turns.
    let text = text.replace("tau_d_ms = 35.0", "tau_d_ms = 35.0\nsoa_ms = 117.0");
    let file = scratch("two-fingers.toml");
    std::fs::write(&file, text + &fingers.collect::<String>()).unwrap();
    file.display().to_string()
}

#[test]
fn two_fingers_are_driven_and_a_killed_run_leaves_neither_on() {
    if !in_lab("two displays, a killed run") {
        return;
    }
    patiently(killed);
}

fn killed() -> Result<(), TooSlow> {
    let mut hand = Hand::open();
    let mut run = hand.run();
    hand.ward.emulator.hear(Duration::from_millis(500));
    hand.check_speed()?;
    kill(run.pid(), Signal::SIGKILL).unwrap();
    run.end();
    hand.is_off();
    hand.is_latched("the run died without a word");
    for (name, emulator) in [("index", hand.ward.emulator), ("thumb", hand.thumb)] {
        let record = emulator.stop();
        let wires = record["wires"].as_array().unwrap();
        let pulses = wires.iter().map(|w| w["pulses"].as_u64().unwrap());
        assert!(pulses.sum::<u64>() > 0, "{name}: {record}");
    }
    Ok(())
}

#[test]
fn a_finger_whose_boards_fall_silent_is_stopped_alone_and_latched_at_once() {
    if !in_lab("two displays, one stopped by its guard") {
        return;
    }
    patiently(silent);
}

fn silent() -> Result<(), TooSlow> {
    let mut hand = Hand::open();
    let mut run = hand.run();
    hand.silence_thumb();
    hand.ward.emulator.hear(Duration::from_millis(1000));
    hand.thumb.hear(Duration::from_millis(10));
    hand.check_speed()?;
    assert!(!hand.thumb.is_driving);
    // The board sends again by now; the finger stays off, the other one goes on.
    hand.thumb.told.clear();
    hand.ward.wait_for_outputs(false)?;
    hand.ward.wait_for_outputs(true)?;
    hand.thumb.hear(Duration::from_millis(500));
    let again = hand.thumb.told.iter().any(|t| t["event"] == "driving");
    assert!(!again, "the thumb is driven after a stop");
    // Latched for both adapters while the other finger goes on, which is not off.
    for latch in hand.latches() {
        let held = latch.read().unwrap();
        assert!(held.cause.starts_with("thumb: stale-input"), "{held:?}");
        assert!(!held.verified, "{held:?}");
    }
    kill(run.pid(), Signal::SIGINT).unwrap();
    let ended = run.end();
    let said = hand.ward.said();
    hand.check_speed()?;
    assert_eq!(ended.code(), Some(4), "{said}");
    assert!(said.contains("display `thumb`: stale-input"), "{said}");
    let [index, thumb] = [&hand.ward.emulator.node, &hand.thumb.node];
    let clear = format!("hil off --unlatch --i2c {index} --i2c {thumb}");
    assert!(said.contains(&clear), "{said}");
    assert!(
        hand.latches()
            .iter()
            .all(|latch| latch.read().unwrap().verified)
    );
    hand.is_off();
    hand.is_latched("thumb: stale-input");
    Ok(())
}

#[test]
fn an_adapter_that_is_gone_takes_its_finger_and_no_other() {
    if !in_lab("two displays, one adapter gone") {
        return;
    }
    patiently(gone);
}

fn gone() -> Result<(), TooSlow> {
    let mut hand = Hand::open();
    let mut run = hand.run();
    let driver = "/sys/bus/hid/drivers/mcp2221";
    let adapter = format!("/sys/bus/i2c/devices/i2c-{}", hand.thumb.number());
    let node = std::fs::canonicalize(adapter).unwrap();
    let device = node.parent().and_then(Path::file_name).unwrap();
    let device = device.to_str().unwrap();
    hand.thumb.wait_for("all_off");
    std::fs::write(format!("{driver}/unbind"), device).unwrap();
    hand.ward.emulator.hear(GIVEN_UP);
    hand.check_speed()?;
    assert!(run.child.try_wait().unwrap().is_none(), "the run goes on");
    hand.ward.wait_for_outputs(false)?;
    hand.ward.wait_for_outputs(true)?;
    kill(run.pid(), Signal::SIGINT).unwrap();
    let ended = run.child.wait().unwrap();
    let said = hand.ward.said();
    hand.check_speed()?;
    assert_eq!(ended.code(), Some(3), "{said}");
    assert!(said.contains("display `thumb`"), "{said}");
    assert!(said.contains("thumb: actuators: dead for"), "{said}");
    // The guardian waits for the adapter, and switches off what is on it.
    std::fs::write(format!("{driver}/bind"), device).unwrap();
    run.end();
    hand.is_off();
    hand.is_latched("thumb: ");
    Ok(())
}

#[test]
fn a_finger_whose_loop_hangs_ends_in_everything_off() {
    if !in_lab("two displays, one loop hangs") {
        return;
    }
    patiently(hung);
}

fn hung() -> Result<(), TooSlow> {
    let mut hand = Hand::open();
    let mut run = hand.run();
    hand.ward.emulator.hear(Duration::from_millis(500));
    hand.check_speed()?;
    let struck = now_ns();
    stop_thread(run.pid(), "loop");
    let ended = run.end();
    hand.check_speed()?;
    assert_eq!(ended.signal(), Some(Signal::SIGKILL as i32), "{ended}");
    let fates = [hand.ward.fate(struck), fate(&mut hand.thumb, struck)];
    for (name, fate) in ["index", "thumb"].iter().zip(fates) {
        let is_off = matches!(fate, Fate::Off(after) if after.unwrap_or(0) <= LIMIT_NS);
        assert!(is_off, "{name}: {fate:?}");
    }
    println!("two displays, one loop hangs: off after (ns) {fates:?}");
    hand.is_latched("the run hung");
    Ok(())
}

#[test]
fn an_oe_line_cuts_every_display_while_one_has_lost_its_bus() {
    if !in_lab("two displays, an OE line") {
        return;
    }
    patiently(cut);
}

fn cut() -> Result<(), TooSlow> {
    let faults =
        "\n[[faults]]\nat_s = 2.0\nuntil_s = 2.6\nkind = \"i2c-address-nack\"\nrate = 1.0\n";
    let mut hand = Hand::built(Built {
        oe: true,
        faults,
        ..Built::default()
    });
    let mut run = hand.run();
    hand.ward.emulator.hear(Duration::from_millis(5000));
    hand.thumb.hear(Duration::from_millis(10));
    kill(run.pid(), Signal::SIGINT).unwrap();
    let ended = run.end();
    let said = hand.ward.said();
    hand.check_speed()?;
    assert!(ended.success(), "{ended}: {said}");
    let mut faults = hand.thumb.told.iter().filter(|t| t["event"] == "fault");
    let [from, to] = [faults.next(), faults.next()].map(|told| at(told.unwrap()));
    let index = &hand.ward.emulator.told;
    let cut = |t: &&Value| t["event"] == "oe" && t["high"] == true && at(t) > from;
    let cut = index.iter().find(cut).map(at).unwrap();
    assert!(cut - from <= 2 * LIMIT_NS, "cut {} ns after", cut - from);
    let within = highs(index, 0..8).filter(|t| (cut..to).contains(t));
    assert_eq!(within.count(), 0, "index is driven while OE is cut");
    for (name, told) in [("index", index), ("thumb", &hand.thumb.told)] {
        assert!(highs(told, 0..8).any(|t| t > to), "{name} comes back");
    }
    println!(
        "two displays, an OE line: cut {} us after the fault",
        (cut - from) / 1000
    );
    hand.is_off();
    Ok(())
}

#[test]
fn displays_on_one_board_of_one_adapter_fail_alone() {
    if !in_lab("two displays on one board") {
        return;
    }
    patiently(beside);
}

fn beside() -> Result<(), TooSlow> {
    let mut hand = Hand::built(Built {
        one_board: true,
        ..Built::default()
    });
    hand.silence_thumb();
    let scene = hand.scene.clone();
    let mut run = hand.ward.run(&scene, &[]);
    hand.ward.emulator.hear(Duration::from_millis(2000));
    hand.check_speed()?;
    let silent = now_ns();
    hand.silence_thumb();
    hand.ward.emulator.hear(Duration::from_millis(1500));
    hand.check_speed()?;
    let told = &hand.ward.emulator.told;
    let [index, thumb] = [0..3, 3..6].map(|channels| highs(told, channels).collect::<Vec<_>>());
    assert!(thumb.iter().any(|t| *t < silent), "the thumb was driven");
    assert!(
        thumb.iter().all(|t| *t < silent + 2 * LIMIT_NS),
        "and stopped"
    );
    assert!(
        index.iter().any(|t| *t < silent),
        "the index finger was driven"
    );
    assert!(
        index.iter().any(|t| *t > silent + 1_000_000_000),
        "and goes on"
    );
    kill(run.pid(), Signal::SIGKILL).unwrap();
    run.end();
    assert!(matches!(hand.ward.fate(0), Fate::Off(_)));
    hand.is_latched("thumb: stale-input");
    Ok(())
}

#[test]
fn two_displays_are_watched_one_at_a_time() {
    if !in_lab("two displays, a live view") {
        return;
    }
    patiently(watched);
}

fn watched() -> Result<(), TooSlow> {
    let mut hand = Hand::open();
    hand.ward.stop_boards();
    hand.silence_thumb();
    let size = Winsize {
        ws_row: 40,
        ws_col: 100,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    let pair = openpty(Some(&size), None).unwrap();
    let (mut keys, mut screen) = {
        let master = File::from(pair.master);
        (master.try_clone().unwrap(), master)
    };
    let drawn = std::thread::spawn(move || {
        let mut drawn = Vec::new();
        // A terminal whose last holder is gone fails to be read.
        let _ = screen.read_to_end(&mut drawn);
        text(&drawn)
    });
    let mut command = hand.ward.command(&hand.scene, &["--watch"]);
    let terminal = |fd: &std::os::fd::OwnedFd| Stdio::from(fd.try_clone().unwrap());
    command
        .stdin(terminal(&pair.slave))
        .stdout(terminal(&pair.slave))
        .stderr(Stdio::null());
    let mut run = command.spawn().unwrap();
    // What holds the far end open otherwise would keep the reader waiting.
    drop((command, pair.slave));
    hand.ward.emulator.wait_for("driving");
    hand.thumb.wait_for("driving");
    keys.write_all(b"\t").unwrap();
    hand.ward.emulator.hear(Duration::from_millis(1000));
    keys.write_all(b"q").unwrap();
    let ended = run.wait().unwrap();
    let drawn = drawn.join().unwrap();
    hand.ward.check_speed()?;
    assert!(
        drawn.contains("display 1 of 2; Tab shows the next"),
        "{drawn}"
    );
    assert!(drawn.contains("by the person who watched"), "{drawn}");
    assert_eq!(ended.code(), Some(0), "{drawn}");
    hand.is_off();
    Ok(())
}
