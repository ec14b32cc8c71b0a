//! Tests of `lock.rs`.

use super::*;

#[test]
fn a_second_program_is_refused_and_told_who_has_the_bus() {
    let folder = std::env::temp_dir().join(format!("palpate-lock-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let path = Path::new("/dev/null");
    let first = BusLock::within(&folder, path).unwrap();
    let refused = BusLock::within(&folder, path).unwrap_err();
    let LockError::Held { pid, .. } = &refused else {
        panic!("{refused}");
    };
    // Inside a container the system may keep the number to itself.
    assert!(pid.is_none_or(|p| p == std::process::id()), "{refused}");
    // Another name of the same bus is the same bus; another bus is not.
    let link = folder.join("link");
    std::os::unix::fs::symlink(path, &link).unwrap();
    BusLock::within(&folder, &link).unwrap_err();
    BusLock::within(&folder, Path::new("/dev/zero")).unwrap();
    drop(first);
    BusLock::within(&folder, path).unwrap();
    fs::remove_dir_all(&folder).unwrap();
    let nowhere = BusLock::within(&folder, path);
    assert!(matches!(nowhere, Err(LockError::Open { .. })));
}

#[test]
fn a_holder_learns_that_it_is_asked_off_and_its_successor_does_not() {
    let folder = std::env::temp_dir().join(format!("palpate-lock-asked-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let path = Path::new("/dev/null");
    let held = BusLock::within(&folder, path).unwrap();
    assert!(!held.is_asked_off());
    let mut file = open(&file_of(&folder, path)).unwrap();
    file.write_all(b"off\n").unwrap();
    assert!(held.is_asked_off());
    drop(held);
    assert!(!BusLock::within(&folder, path).unwrap().is_asked_off());
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn neither_a_link_nor_a_pipe_nor_a_folder_is_a_lock() {
    let folder = std::env::temp_dir().join(format!("palpate-lock-odd-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let (path, target) = (Path::new("/dev/null"), folder.join("target"));
    let lock = file_of(&folder, path);
    std::os::unix::fs::symlink(&target, &lock).unwrap();
    BusLock::within(&folder, path).unwrap_err();
    assert!(!target.exists(), "a link was followed");
    fs::remove_file(&lock).unwrap();
    nix::unistd::mkfifo(&lock, nix::sys::stat::Mode::S_IRWXU).unwrap();
    BusLock::within(&folder, path).unwrap_err();
    fs::remove_file(&lock).unwrap();
    fs::create_dir(&lock).unwrap();
    BusLock::within(&folder, path).unwrap_err();
    fs::remove_dir_all(&folder).unwrap();
}
