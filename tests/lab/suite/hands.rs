//! A bench of two displays on two adapters: both are driven, each fails alone, and what ends the run switches off both.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use palpate_buses::can::Endpoint;
use palpate_buses::guardian::Latch;
use palpate_core::codec::can::CanFrame;

use super::emulator::Emulator;
use super::tools::{hil, in_lab, scene, scratch, sh, text, vcan};
use super::ward::{Fate, TooSlow, Ward, fate, latch_of, patiently, unlatch};

/// Longer than a run goes on with a dead bus, 3 s.
const GIVEN_UP: Duration = Duration::from_millis(4500);

/// A bench's adapters, and each display's bus and first channel.
pub type Wiring = (Vec<String>, [(usize, u8); 2]);

/// Two emulated boards, adapters and thimbles: `index` is the ward's, `thumb` the other one's.
pub struct Hand {
    pub ward: Ward,
    pub thumb: Emulator,
    /// The thumb's sensor bus.
    can: Endpoint,
    pub scene: String,
}

impl Hand {
    pub fn open() -> Self {
        Self::wired(&scene("press.toml"), &[], own_adapters)
    }

    /// Of the thumb's own scene, further options of the ward, and a wiring.
    pub fn wired(
        thumb_scene: &str,
        options: &[&str],
        wiring: impl Fn(&Emulator, &Emulator) -> Wiring,
    ) -> Self {
        let press = scene("press.toml");
        vcan("vcan1");
        let thumb = Emulator::start(&["--await-start", "--scene", thumb_scene, "--can", "vcan1"]);
        let ward = Ward::open(&press, options);
        let (nodes, displays) = wiring(&ward.emulator, &thumb);
        let text = std::fs::read_to_string(ward.bench()).unwrap();
        std::fs::write(ward.bench(), bench(&text, &nodes, displays)).unwrap();
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
        [&self.ward.emulator.node, &self.thumb.node].map(|node| latch_of(node))
    }

    fn unlatch(&self) {
        self.ward.unlatch();
        unlatch(&self.thumb.node);
    }

    /// The thumb's board is silent from now on, until a start command.
    pub fn silence_thumb(&self) {
        let stop = CanFrame::new(0x20F, &[0x07, 0x01]).unwrap();
        self.can.send(&stop).unwrap();
    }

    /// A run that drives both, each on an adapter of its own.
    pub fn run(&mut self) -> super::ward::Run {
        self.silence_thumb();
        self.thumb.told.clear();
        let run = self.ward.run(&self.scene.clone(), &[]);
        self.thumb.wait_for("driving");
        run
    }

    /// Two displays of one board take turns: onsets twice as far apart.
    pub fn slow_down(&self) {
        let text = std::fs::read_to_string(&self.scene).unwrap();
        let slow = text.replace("[illusion]\n", "[illusion]\nsoa_ms = 117.0\n");
        std::fs::write(&self.scene, slow).unwrap();
    }

    /// A finger that this machine was too slow for says so in the end.
    pub fn check_speed(&self) -> Result<(), TooSlow> {
        match self.ward.said().contains("late-tick") {
            true => Err(TooSlow),
            false => Ok(()),
        }
    }

    /// Both are known to be off.
    pub fn is_off(&mut self) {
        assert!(matches!(self.ward.fate(0), Fate::Off(_)), "index");
        assert!(matches!(fate(&mut self.thumb, 0), Fate::Off(_)), "thumb");
    }

    /// The next run is refused, for this; then a person clears it.
    pub fn is_latched(&self, cause: &str) {
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

/// An adapter for each display.
pub fn own_adapters(index: &Emulator, thumb: &Emulator) -> Wiring {
    let nodes = [index, thumb].map(|emulator| emulator.node.clone());
    (nodes.into(), [(0, 0), (1, 0)])
}

/// The ward's bench with these adapters, and a display on eight channels from one on of a bus.
fn bench(text: &str, nodes: &[String], displays: [(usize, u8); 2]) -> String {
    let head = text.split("[[outputs]]").next().unwrap();
    let set = |line: &str| match line.split_once(" = ") {
        Some(("i2c", _)) => format!("i2c = {nodes:?}"),
        Some(("can", _)) => "can = [\"vcan0\", \"vcan1\"]".into(),
        _ => line.to_owned(),
    };
    let mut bench = head.lines().map(set).collect::<Vec<_>>().join("\n");
    for ((bus, first), name) in displays.into_iter().zip(["index", "thumb"]) {
        let output = |channel| format!("{{ bus = {bus}, board = 0x40, channel = {channel} }}");
        let outputs: Vec<String> = (first..first + 8).map(output).collect();
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
    // Touched for a second and then no more: a wire that is left on would end the whole run.
    let lifted = scratch("lifted.toml");
    let press = std::fs::read_to_string(scene("press.toml")).unwrap();
    std::fs::write(&lifted, press.replace("end_s = 600.0", "end_s = 1.2")).unwrap();
    let mut hand = Hand::wired(&lifted.display().to_string(), &[], own_adapters);
    let mut run = hand.run();
    let driver = "/sys/bus/hid/drivers/mcp2221";
    let adapter = format!("/sys/bus/i2c/devices/i2c-{}", hand.thumb.number());
    let node = std::fs::canonicalize(adapter).unwrap();
    let device = node.parent().and_then(Path::file_name).unwrap();
    let device = device.to_str().unwrap();
    hand.thumb.hear_until_quiet(Duration::from_millis(500));
    assert!(!hand.thumb.is_driving);
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
