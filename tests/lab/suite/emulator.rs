//! `hil emulate` as a process, with what it says.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use serde_json::Value;

use super::tools::{hil, sh, vcan};

/// Generous: the lab's processor is emulated.
const PATIENCE: Duration = Duration::from_secs(120);
const ROUND: Duration = Duration::from_millis(500);

/// When something was told, nanoseconds of the lab's clock.
pub fn at(told: &Value) -> u64 {
    told["t_ns"].as_u64().unwrap()
}

pub struct Emulator {
    child: Child,
    lines: Receiver<Value>,
    /// Events told so far.
    pub told: Vec<Value>,
    /// Whether a chip drives, by what was told.
    pub is_driving: bool,
    /// `/dev/i2c-N`.
    pub node: String,
    /// The GPIO chip whose line 0 is on the chips' OE pins, if it is.
    pub oe: Option<String>,
}

impl Emulator {
    /// On vcan0, with further options.
    pub fn start(options: &[&str]) -> Self {
        vcan("vcan0");
        // Hardware is never busy with something else: before the loop, after the guardian.
        let mut child = Command::new("chrt")
            .args(["--fifo", "55"])
            .arg(hil())
            .args(["emulate", "--json"])
            .args(options)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let (send, lines) = channel();
        std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                if send.send(serde_json::from_str(&line).unwrap()).is_err() {
                    break;
                }
            }
        });
        let mut this = Self {
            child,
            lines,
            told: Vec::new(),
            is_driving: false,
            node: String::new(),
            oe: None,
        };
        let serving = this.wait_for("serving");
        this.node = serving["i2c"].as_str().unwrap().to_owned();
        this.oe = serving["oe"].as_str().map(str::to_owned);
        this
    }

    /// The N of `/dev/i2c-N`.
    pub fn number(&self) -> &str {
        self.node.trim_start_matches("/dev/i2c-")
    }

    /// Waits until an event of this kind is told.
    #[track_caller]
    pub fn wait_for(&mut self, event: &str) -> Value {
        self.wait_while(event, || {})
    }

    /// Waits until an event of this kind is told; `check` is called now and then meanwhile.
    #[track_caller]
    pub fn wait_while(&mut self, event: &str, mut check: impl FnMut()) -> Value {
        let mut silence = Duration::ZERO;
        loop {
            match self.lines.recv_timeout(ROUND) {
                Ok(told) => {
                    self.note(told.clone());
                    silence = Duration::ZERO;
                    if told["event"] == event {
                        return told;
                    }
                }
                Err(RecvTimeoutError::Timeout) if silence < PATIENCE => {
                    silence += ROUND;
                    check();
                }
                Err(e) => panic!("waiting for `{event}`: {e}"),
            }
        }
    }

    /// Takes in what is told until nothing but the edges of a steady state has been for this long.
    #[track_caller]
    pub fn hear_until_quiet(&mut self, quiet: Duration) {
        let began = std::time::Instant::now();
        let mut changed = began;
        while changed.elapsed() < quiet {
            assert!(began.elapsed() < PATIENCE, "it never ends");
            if let Ok(told) = self.lines.recv_timeout(quiet) {
                if told["event"] != "edge" {
                    changed = std::time::Instant::now();
                }
                self.note(told);
            }
        }
    }

    /// Takes in what is told within a time.
    pub fn hear(&mut self, time: Duration) {
        std::thread::sleep(time);
        while let Ok(told) = self.lines.try_recv() {
            self.note(told);
        }
    }

    fn note(&mut self, told: Value) {
        match told["event"].as_str() {
            Some("driving") => self.is_driving = true,
            Some("all_off") => self.is_driving = false,
            _ => {}
        }
        self.told.push(told);
    }

    /// Whether it still runs.
    pub fn is_alive(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Stops it as Ctrl-C does and returns its record.
    #[track_caller]
    pub fn stop(mut self) -> Value {
        assert!(self.is_alive(), "hil emulate has ended by itself");
        sh(&format!("kill -INT {}", self.child.id()));
        let record = self.wait_for("record");
        assert!(self.child.wait().unwrap().success());
        record
    }
}

impl Drop for Emulator {
    /// A failed test leaves no emulator behind.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
