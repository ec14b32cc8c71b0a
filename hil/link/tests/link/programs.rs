//! The program as a process, on ports of this machine that are free, and `hil` beside it.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use palpate_buses::pacer::RunClock;
use palpate_core::units::Duration;
use serde_json::Value;

pub const FINGER: [&str; 2] = ["--finger", "r1/left/index"];

/// A port that is free.
pub fn port() -> String {
    let free = TcpListener::bind("127.0.0.1:0").unwrap();
    format!("127.0.0.1:{}", free.local_addr().unwrap().port())
}

/// A program that is gone with this value.
pub struct Program(Option<Child>);

impl Program {
    pub fn start(command: &mut Command) -> Self {
        let command = command.stdin(Stdio::null()).stdout(Stdio::piped());
        Self(Some(command.stderr(Stdio::piped()).spawn().unwrap()))
    }

    fn child(&mut self) -> &mut Child {
        self.0.as_mut().unwrap()
    }

    /// Sends it a signal, by name.
    #[track_caller]
    pub fn signal(&mut self, name: &str) {
        let id = self.child().id().to_string();
        let sent = Command::new("kill").args(["-s", name, &id]).status();
        assert!(sent.unwrap().success());
    }

    /// Waits until it has ended: its exit status, the JSON that it printed, what it said.
    pub fn ended(mut self) -> (Option<i32>, Value, String) {
        let child = self.0.take().unwrap();
        let Output {
            status,
            stdout,
            stderr,
        } = child.wait_with_output().unwrap();
        let value = serde_json::from_slice(&stdout).unwrap_or(Value::Null);
        let said = String::from_utf8_lossy(&stderr).into_owned();
        (status.code(), value, said)
    }
}

impl Drop for Program {
    /// A failed test leaves nothing behind.
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// `palpate-link` with these arguments.
pub fn link(arguments: &[&str]) -> Program {
    Program::start(Command::new(env!("CARGO_BIN_EXE_palpate-link")).args(arguments))
}

/// A skin of the default scene that listens there.
pub fn skin(port: &str, more: &[&str]) -> Program {
    let arguments = ["skin", "sphere-along", "--json", "--listen", port];
    link(&[&arguments, &FINGER[..], more].concat())
}

/// Its display, which connects there.
pub fn display(port: &str, more: &[&str]) -> Program {
    let arguments = ["display", "sphere-along", "--json", "--connect", port];
    link(&[&arguments, &FINGER[..], more].concat())
}

/// Lets time pass.
pub fn pause(ms: u64) {
    let clock = RunClock::start();
    clock.sleep_until(clock.now() + Duration::from_millis(ms));
}

/// A folder of its own, gone with it.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("palpate-link-{}-{n}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The name of a file in it.
    pub fn file(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
