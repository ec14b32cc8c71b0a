//! Running other people's programs.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

/// `true` in the lab; else says what is skipped.
pub fn in_lab(test: &str) -> bool {
    let there = std::env::var_os("PALPATE_IN_LAB").is_some();
    if !there {
        println!("SKIPPED {test}: not in the lab; ci/lab-suite runs it there");
    }
    there
}

/// Runs a line of shell text and returns what it printed.
#[track_caller]
pub fn sh(line: &str) -> String {
    let output = try_sh(line);
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert!(
        output.status.success(),
        "`{line}`: {}\n{out}{err}",
        output.status
    );
    out
}

/// Runs a line of shell text, whatever becomes of it.
pub fn try_sh(line: &str) -> Output {
    let shell = Command::new("sh")
        .args(["-c", line])
        .stdin(Stdio::null())
        .output();
    shell.unwrap()
}

/// What a program printed.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A virtual CAN interface of this name, up, with room for a burst.
pub fn vcan(name: &str) {
    sh(&format!(
        "ip link show {name} >/dev/null 2>&1 || ip link add {name} type vcan; ip link set {name} up"
    ));
}

/// A client of ours around a published library, in Python.
#[track_caller]
pub fn python(script: &str, arguments: &str) -> String {
    let python = std::env::var("PALPATE_LAB_PYTHON").unwrap();
    let script = here().join("suite/clients").join(script);
    sh(&format!("{python} {} {arguments}", script.display()))
}

/// `hil`, in memory: a program that is read over the lab's file system takes a second to start.
pub fn hil() -> &'static Path {
    static HIL: OnceLock<PathBuf> = OnceLock::new();
    HIL.get_or_init(|| {
        let folder = scratch("bin");
        std::fs::create_dir_all(&folder).unwrap();
        let copy = folder.join("hil");
        std::fs::copy(std::env::var("PALPATE_HIL").unwrap(), &copy).unwrap();
        copy
    })
}

/// A scene or bench of the suite.
pub fn scene(name: &str) -> String {
    let file = here().join("suite/scenes").join(name);
    file.display().to_string()
}

/// A number that the environment may say.
pub fn number_of(name: &str, default: u64) -> u64 {
    let said = std::env::var(name).ok();
    said.map_or(default, |n| n.parse().unwrap())
}

/// A place of this run's own for a file.
pub fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("palpate-lab-{}-{name}", std::process::id()))
}

/// This package's folder.
pub fn here() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}
