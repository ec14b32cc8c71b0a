//! The program where the device that was asked for is not there: one line that says so, and nothing written.

use std::fs;
use std::process::Command;

// but on macOS, where a card needs no driver
#[cfg(not(all(feature = "gpu", target_os = "macos")))]
#[test]
fn a_missing_graphics_card_is_said_before_anything_is_written() {
    let folder = std::env::temp_dir().join(format!("palpate-train-device-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let mut rows = "txl1_x,txl1_y\n".to_owned();
    (0..20).for_each(|row| rows += &format!("{row},{}\n", row % 3));
    for number in 0..10 {
        fs::write(folder.join(format!("felt_{number}.csv")), &rows).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_palpate-train"));
    command
        .arg(&folder)
        .arg("--model")
        .arg(folder.join("m.safetensors"));
    command.arg("--checkpoint").arg(folder.join("checkpoint"));
    command.args(["--device", "gpu"]);
    // no driver for Vulkan to find, whatever this machine has
    command
        .env("VK_DRIVER_FILES", "/dev/null")
        .env("VK_ICD_FILENAMES", "/dev/null");
    let said = command.output().unwrap();
    let error = String::from_utf8(said.stderr).unwrap();
    assert_eq!(said.status.code(), Some(2), "{error}");
    let what = if cfg!(feature = "gpu") {
        "expected a graphics card with a Vulkan driver, found none"
    } else {
        "cargo build --release -p palpate-train --features gpu"
    };
    assert!(
        error.contains(what) && error.contains("--device cpu"),
        "{error}"
    );
    assert!(!error.contains("panicked"), "{error}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 10);
    fs::remove_dir_all(folder).unwrap();
}
