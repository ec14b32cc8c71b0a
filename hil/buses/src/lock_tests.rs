//! Tests of `lock.rs`.

use super::*;

/// A folder of locks, gone with the value.
struct Locks(PathBuf);

impl Locks {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("palpate-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn take(&self, hardware: &Hardware) -> Result<BusLock, LockError> {
        BusLock::within(&self.0, hardware)
    }
}

impl Drop for Locks {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Hardware by a name and a number.
fn hardware(name: &str, number: u8) -> Hardware {
    Hardware::unit(name, &[number; 32])
}

#[test]
fn a_second_program_is_refused_and_told_who_has_the_bus() {
    let locks = Locks::new("lock");
    let first = locks.take(&hardware("one", 1)).unwrap();
    let refused = locks.take(&hardware("one", 1)).unwrap_err();
    let LockError::Held { pid, .. } = &refused else {
        panic!("{refused}");
    };
    // Inside a container the system may keep the number to itself.
    assert!(pid.is_none_or(|p| p == std::process::id()), "{refused}");
    // Another name of the same hardware is the same; other hardware is not.
    let renamed = locks.take(&hardware("another name", 1)).unwrap_err();
    assert!(renamed.to_string().starts_with("unit another name: in use"));
    locks.take(&hardware("one", 2)).unwrap();
    drop(first);
    locks.take(&hardware("one", 1)).unwrap();
    let nowhere = BusLock::within(&locks.0.join("none"), &hardware("one", 1));
    assert!(matches!(nowhere, Err(LockError::Open { .. })));
}

#[test]
fn a_holder_learns_that_it_is_asked_off_and_its_successor_does_not() {
    let locks = Locks::new("lock-asked");
    let held = locks.take(&hardware("one", 1)).unwrap();
    assert!(!held.is_asked_off());
    ask_off_within(&locks.0, &hardware("another name", 1)).unwrap();
    assert!(held.is_asked_off());
    drop(held);
    assert!(!locks.take(&hardware("one", 1)).unwrap().is_asked_off());
}

#[test]
fn neither_a_link_nor_a_pipe_nor_a_folder_is_a_lock() {
    let locks = Locks::new("lock-odd");
    let (one, target) = (hardware("one", 1), locks.0.join("target"));
    let lock = file_of(&locks.0, &one);
    std::os::unix::fs::symlink(&target, &lock).unwrap();
    locks.take(&one).unwrap_err();
    assert!(!target.exists(), "a link was followed");
    fs::remove_file(&lock).unwrap();
    nix::unistd::mkfifo(&lock, nix::sys::stat::Mode::S_IRWXU).unwrap();
    locks.take(&one).unwrap_err();
    ask_off_within(&locks.0, &one).unwrap_err();
    fs::remove_file(&lock).unwrap();
    fs::create_dir(&lock).unwrap();
    locks.take(&one).unwrap_err();
}

#[test]
fn a_lock_of_a_newer_version_is_refused_and_one_of_an_older_is_taken() {
    let locks = Locks::new("lock-versions");
    let one = hardware("one", 1);
    let lock = file_of(&locks.0, &one);
    fs::write(&lock, "palpate-lock 2\nwhatever\n").unwrap();
    for refused in [
        locks.take(&one).unwrap_err(),
        ask_off_within(&locks.0, &one).unwrap_err(),
    ] {
        let said = refused.to_string();
        assert!(said.contains("newer version"), "{said}");
    }
    assert_eq!(
        fs::read_to_string(&lock).unwrap(),
        "palpate-lock 2\nwhatever\n",
        "it was left alone"
    );
    for older in ["palpate-lock 0\n", "", "off\n", "palpate-lock"] {
        fs::write(&lock, older).unwrap();
        let held = locks.take(&one).unwrap();
        assert!(!held.is_asked_off(), "{older:?}");
        drop(held);
        assert_eq!(fs::read_to_string(&lock).unwrap(), content(&one));
    }
}

#[test]
fn a_lock_is_for_all_users() {
    use std::os::unix::fs::PermissionsExt;
    let locks = Locks::new("lock-mode");
    let one = hardware("one", 1);
    let _held = locks.take(&one).unwrap();
    let mode = fs::metadata(file_of(&locks.0, &one)).unwrap().permissions();
    assert_eq!(mode.mode() & 0o777, 0o666);
}
