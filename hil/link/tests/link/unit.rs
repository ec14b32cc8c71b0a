//! A display on outputs that are no emulation of its own: those of a driver unit, a process beside it.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use palpate_buses::served::wait::monotonic_ns;
use serde_json::Value;

use super::programs::{FINGER, Folder, Program, display, pause, port, skin};

/// Off after the newest reading: a turn comes once per millisecond, a transfer takes half of one.
const LIMIT_MS: f64 = 103.0;

/// Bursts begin every 117 ms and last for 38 ms: 36 ms after a beginning is 100 ms before the middle of the next one.
const PHASE_NS: u64 = 36_000_000;
/// Between two bursts no output is on for so long.
const QUIET_NS: u64 = 50_000_000;
/// A unit that says nothing for so long has nothing to say.
const PATIENCE: Duration = Duration::from_secs(30);

/// Where the arguments of `hil` are for a copy of this program that shall be `hil`.
const ARGUMENTS: &str = "PALPATE_TEST_HIL";

/// `hil`, which is no program of this package: this one again, with the test below.
fn hil(folder: &Folder, arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(["--exact", "unit::is_hil", "--nocapture"])
        .env(ARGUMENTS, arguments.join("\n"))
        .env("PALPATE_STATE", folder.file("state"))
        .current_dir(folder.path());
    command
}

/// The other tests start it; without what they say it has nothing to be.
#[test]
fn is_hil() {
    let Ok(arguments) = std::env::var(ARGUMENTS) else {
        return;
    };
    let line = std::iter::once("hil").chain(arguments.split('\n'));
    let status = palpate_hil::program::main(line.map(Into::into), None);
    std::process::exit(status.into());
}

/// A unit with emulated boards, and what it told.
struct Unit {
    child: Child,
    lines: Receiver<Value>,
    folder: Folder,
    address: String,
    told: Vec<Value>,
}

impl Unit {
    fn start() -> Self {
        let folder = Folder::new();
        let made = hil(&folder, &["unit", "--new-key", "unit.key"]).output();
        assert!(made.unwrap().status.success());
        let arguments = ["unit", "--json", "--key", "unit.key", "--at", "127.0.0.1:0"];
        let mut child = hil(&folder, &arguments)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let (send, lines) = channel();
        std::thread::spawn(move || {
            // The harness that this process is has words of its own.
            let lines = out.lines().map_while(Result::ok);
            for told in lines.filter_map(|line| serde_json::from_str(&line).ok()) {
                if send.send(told).is_err() {
                    break;
                }
            }
        });
        let mut this = Self {
            child,
            lines,
            folder,
            address: String::new(),
            told: Vec::new(),
        };
        let is_serving = |told: &Value| told["event"] == "serving";
        this.hear(1, is_serving);
        let serving = this.told.iter().find(|told| is_serving(told)).unwrap();
        this.address = serving["address"].as_str().unwrap().to_owned();
        this
    }

    /// Takes in what it tells until so many of these have come.
    #[track_caller]
    fn hear(&mut self, mut count: usize, of: impl Fn(&Value) -> bool) {
        while count > 0 {
            let told = self.lines.recv_timeout(PATIENCE).unwrap();
            count -= usize::from(of(&told));
            self.told.push(told);
        }
    }

    /// Waits until outputs have risen so often.
    #[track_caller]
    fn wait_for_edges(&mut self, count: usize) {
        self.hear(count, |told| {
            told["event"] == "edge" && told["high"] == true
        });
    }

    /// Waits for a moment 100 ms before the middle of the burst to come: silence from there on finds a wire that is driven.
    fn wait_for_phase(&mut self) {
        let mut last_ns = 0;
        loop {
            self.wait_for_edges(1);
            let edge_ns = self.told.last().unwrap()["t_ns"].as_u64().unwrap();
            let begins = edge_ns - last_ns > QUIET_NS;
            last_ns = edge_ns;
            let late_ns = monotonic_ns().saturating_sub(edge_ns);
            if begins && late_ns < PHASE_NS {
                pause((PHASE_NS - late_ns) / 1_000_000);
                return;
            }
        }
    }

    /// Ends it; when its last output fell, nanoseconds of this machine's clock.
    fn last_edge_ns(&mut self) -> u64 {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args(["-s", "TERM", &id]).status();
        assert!(sent.unwrap().success());
        self.hear(1, |told| told["event"] == "record");
        let record = self.told.last().unwrap();
        assert_eq!(record["event"], "record");
        assert_eq!(record["off"], true, "{record}");
        let edges = self.told.iter().filter(|told| told["event"] == "edge");
        edges.map(|e| e["t_ns"].as_u64().unwrap()).max().unwrap()
    }

    /// A display on it.
    fn display(&self, port: &str) -> Program {
        let (key, state) = (self.folder.file("unit.key"), self.folder.file("state"));
        let arguments = ["display", "sphere-along", "--json", "--connect", port];
        let on = ["--unit", &self.address, "--key", &key];
        let mut command = Command::new(env!("CARGO_BIN_EXE_palpate-link"));
        command.args([&arguments[..], &FINGER, &on].concat());
        Program::start(command.env("PALPATE_STATE", state))
    }
}

impl Drop for Unit {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_skin_that_dies_leaves_no_output_of_a_unit_on_and_the_stop_is_kept() {
    let mut unit = Unit::start();
    let port = port();
    let mut robot = skin(&port, &["--seconds", "30"]);
    let mut wearer = unit.display(&port);
    unit.wait_for_edges(12);
    unit.wait_for_phase();
    robot.signal("KILL");
    let killed_ns = monotonic_ns();
    pause(500);
    wearer.signal("INT");
    let (status, felt, said) = wearer.ended();
    assert_eq!(status, Some(4), "{felt}{said}");
    assert!(said.contains("hil off --unlatch"), "{said}");
    assert!(felt["unit"]["begun"].as_u64().unwrap() > 0, "{felt}");
    // What was stopped stays so.
    let (status, _, said) = unit.display(&port).ended();
    assert_eq!(status, Some(4), "{said}");
    assert!(said.contains("stopped earlier"), "{said}");
    let clear = ["off", "--unlatch", "--key", "unit.key", "--unit"];
    let clear = [&clear[..], &[&unit.address]].concat();
    assert!(hil(&unit.folder, &clear).output().unwrap().status.success());
    let off_ms = (unit.last_edge_ns() as f64 - killed_ns as f64) * 1e-6;
    assert!(off_ms <= LIMIT_MS, "{off_ms} ms after the skin died");
    println!("outputs off {off_ms:.1} ms after the skin died");
}

#[test]
fn ctrl_c_of_a_wearer_switches_the_unit_off_and_the_robot_hears_of_it() {
    let mut unit = Unit::start();
    let port = port();
    let mut robot = skin(&port, &["--seconds", "30"]);
    let mut wearer = unit.display(&port);
    unit.wait_for_edges(12);
    wearer.signal("INT");
    let struck_ns = monotonic_ns();
    let (status, felt, said) = wearer.ended();
    assert_eq!(status, Some(0), "{felt}{said}");
    robot.signal("INT");
    let (status, sent, told) = robot.ended();
    assert_eq!(status, Some(0), "{told}");
    assert_eq!(
        sent["stops"][0], "wearer: stopped by SIGINT",
        "{sent}{told}"
    );
    let off_ms = (unit.last_edge_ns() as f64 - struck_ns as f64) * 1e-6;
    assert!(off_ms <= LIMIT_MS, "{off_ms} ms after the wearer's STOP");
    // In order: the next one may start.
    assert_eq!(felt["unit"]["stops"], 0, "{felt}");
}

#[test]
fn a_skin_that_ends_in_order_lets_go_and_the_next_one_is_felt() {
    let mut unit = Unit::start();
    let port = port();
    let mut robot = skin(&port, &["--seconds", "30"]);
    let mut wearer = unit.display(&port);
    unit.wait_for_edges(12);
    robot.signal("INT");
    let (status, _, told) = robot.ended();
    assert_eq!(status, Some(0), "{told}");
    let before = unit.told.len();
    // Another publisher may follow one that was not felt for a second.
    pause(1500);
    let mut robot = skin(&port, &["--seconds", "30"]);
    unit.wait_for_edges(60);
    wearer.signal("INT");
    let (status, felt, said) = wearer.ended();
    robot.signal("INT");
    let (_, _, told) = robot.ended();
    assert_eq!(status, Some(0), "{felt}{said}{told}");
    assert_eq!(felt["unit"]["stops"], 0, "{felt}{said}");
    // Longer than silence, and driven after it.
    let rising = |told: &&Value| told["event"] == "edge" && told["high"] == true;
    let times = unit.told[before..].iter().filter(rising);
    let times: Vec<u64> = times.map(|e| e["t_ns"].as_u64().unwrap()).collect();
    let gap = times.windows(2).map(|t| t[1] - t[0]).max();
    assert!(gap > Some(500_000_000), "{gap:?}");
    unit.last_edge_ns();
}

#[test]
fn a_bench_without_its_hardware_is_refused_with_a_sentence() {
    let port = port();
    let nowhere = ["--i2c", "/dev/i2c-palpate-none"];
    let (status, _, said) = display(&port, &nowhere).ended();
    assert_eq!(status, Some(2), "an emulated bench is no hardware: {said}");
    let line = "hil new bench my-bench --can can0 --i2c /dev/i2c-palpate-none";
    assert!(said.contains(line), "{said}");
    let (status, _, said) = skin(&port, &["--can", "none0"]).ended();
    assert_eq!(status, Some(3), "{said}");
    assert!(said.contains("none0"), "{said}");
}
