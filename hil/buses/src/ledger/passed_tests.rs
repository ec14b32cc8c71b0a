//! Tests of `passed.rs`.

use std::fs;
use std::path::PathBuf;

use super::*;

/// A folder of accounts that goes with the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let name = format!("palpate-passed-{name}-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const fn output(channel: u8) -> Output {
    Output {
        bus: 0,
        board: 0x40,
        channel,
    }
}

#[test]
fn wires_are_passed_until_they_are_cold_again() {
    let folder = Folder::new("kept");
    assert_eq!(passed(&folder.0, "one"), []);
    keep_passed(&folder.0, "one", &[output(0), output(1)], true).unwrap();
    keep_passed(&folder.0, "one", &[output(1), output(2)], true).unwrap();
    assert_eq!(passed(&folder.0, "one"), [output(0), output(1), output(2)]);
    assert_eq!(passed(&folder.0, "two"), []);
    keep_passed(&folder.0, "one", &[output(0), output(2)], false).unwrap();
    assert_eq!(passed(&folder.0, "one"), [output(1)]);
}

#[test]
fn another_start_of_the_machine_and_a_damaged_account_leave_no_wire_passed() {
    let folder = Folder::new("lost");
    keep_passed(&folder.0, "one", &[output(3)], true).unwrap();
    let account = Account::open(&folder.0, &name_of("one")).unwrap();
    let other = Uptime {
        boot: Uptime::now().boot ^ 1,
        us: 0,
    };
    assert_eq!(read_outputs(&account, other), []);
    let unknown = Uptime { boot: 0, us: 0 };
    assert_eq!(read_outputs(&account, unknown), []);
    let file = folder.0.join(name_of("one"));
    let mut bytes = fs::read(&file).unwrap();
    bytes[20] ^= 1;
    fs::write(&file, bytes).unwrap();
    assert_eq!(passed(&folder.0, "one"), []);
    keep_passed(&folder.0, "one", &[output(4)], true).unwrap();
    assert_eq!(passed(&folder.0, "one"), [output(4)]);
}
