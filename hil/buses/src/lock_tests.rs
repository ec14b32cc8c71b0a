//! Tests of `lock.rs`.

use sha2::{Digest, Sha256};

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
    let own = std::process::id();
    let locks_of_all = fs::read_to_string("/proc/locks").unwrap_or_default();
    let is_told = locks_of_all.contains(&format!(" {own} "));
    assert_eq!(*pid, is_told.then_some(own), "{refused}");
    assert_eq!(refused.holder(), who(*pid));
    // Another name of the same hardware is the same; other hardware is not.
    let renamed = locks.take(&hardware("another name", 1)).unwrap_err();
    assert!(renamed.to_string().starts_with("unit another name: in use"));
    locks.take(&hardware("one", 2)).unwrap();
    drop(first);
    locks.take(&hardware("one", 1)).unwrap();
    let nowhere = BusLock::within(&locks.0.join("none"), &hardware("one", 1));
    let nowhere = nowhere.unwrap_err();
    assert!(matches!(nowhere, LockError::Open { .. }));
    assert_eq!(nowhere.holder(), "nobody");
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
fn a_holder_is_found_by_the_system_s_list() {
    let locks = "1: FLOCK  ADVISORY  WRITE 16 fe:00:70 0 EOF\n\
                 2: POSIX  ADVISORY  WRITE 17 fe:00:80 0 EOF\n\
                 3: FLOCK  ADVISORY  WRITE 18 fe:00:80 0 EOF\n\
                 3: -> FLOCK  ADVISORY  WRITE 19 fe:00:90 0 EOF\n";
    let found = [70, 80, 90, 8].map(|inode| holder_in(locks, &inode.to_string()));
    assert_eq!(found, [Some(16), Some(18), Some(19), None]);
    assert_eq!(who(None), "another program");
    let own = std::process::id();
    let name = fs::read_to_string("/proc/self/comm").unwrap();
    assert!(who(Some(own)).starts_with(&format!("process {own} (")));
    assert!(!name.trim().is_empty() && !who(Some(own)).ends_with("()"));
}

#[test]
fn locks_are_where_every_user_may_write() {
    use std::os::unix::fs::PermissionsExt;
    let locks = Locks::new("lock-folder");
    let file = locks.0.join("file");
    fs::write(&file, "").unwrap();
    for (place, mode, is_open) in [
        (&locks.0, 0o777, true),
        (&locks.0, 0o755, false),
        (&file, 0o666, false),
    ] {
        fs::set_permissions(place, fs::Permissions::from_mode(mode)).unwrap();
        let found = for_all(place);
        assert_eq!(found == place, is_open, "{mode:o}");
        assert!(is_open || found == Path::new("/tmp"));
    }
    // By the real one any program asks any other.
    let own = Sha256::digest(std::process::id().to_string());
    let own = Hardware::unit("one", &own.into());
    let held = BusLock::take(&own).unwrap();
    ask_off(&own).unwrap();
    assert!(held.is_asked_off());
    fs::remove_file(file_of(folder(), &own)).unwrap();
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
        let written = fs::read_to_string(&lock).unwrap();
        assert_eq!(written, "palpate-lock 1\ndriver unit\n");
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
