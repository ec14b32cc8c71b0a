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
