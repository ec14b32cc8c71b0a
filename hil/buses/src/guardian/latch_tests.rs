//! Tests of `latch.rs`.

use super::*;

#[test]
fn the_first_cause_is_kept_until_a_person_clears_it() {
    let folder = env::temp_dir().join(format!("palpate-latch-{}", std::process::id()));
    let latch = Latch::within(&folder, Path::new("/dev/i2c-1"));
    assert_eq!(latch.read(), None);
    latch.set("the run died\nat once", false).unwrap();
    let held = latch.read().unwrap();
    assert_eq!(
        (held.cause.as_str(), held.verified),
        ("the run died at once", false)
    );
    latch.set("something else", true).unwrap();
    let later = latch.read().unwrap();
    assert_eq!(
        (&later.cause, later.at_s, later.verified),
        (&held.cause, held.at_s, true)
    );
    latch.clear().unwrap();
    latch.clear().unwrap();
    assert_eq!(latch.read(), None);
    // What was damaged holds.
    fs::write(&latch.file, "?").unwrap();
    assert_eq!(latch.read().unwrap().cause, "not told");
    let _ = fs::remove_dir_all(&folder);
}

#[test]
fn what_a_guardian_leaves_armed_is_a_stop_for_the_next_one_alone() {
    let folder = env::temp_dir().join(format!("palpate-armed-{}", std::process::id()));
    let latch = Latch::within(&folder, Path::new("/dev/i2c-1"));
    let armed = latch.arm().unwrap();
    assert_eq!(latch.read(), None, "a run is on");
    let held = latch.read_locked().unwrap();
    assert_eq!((held.cause.as_str(), held.verified), (ABANDONED, false));
    armed.disarm();
    assert_eq!(latch.read_locked(), None);
    let _armed = latch.arm().unwrap();
    latch.clear().unwrap();
    assert_eq!(latch.read_locked(), None);
    let _ = fs::remove_dir_all(&folder);
}

#[test]
fn a_stop_is_latched_in_a_folder_that_takes_nothing_more_and_keeps_its_first_cause() {
    let folder = env::temp_dir().join(format!("palpate-armed-full-{}", std::process::id()));
    let latch = Latch::within(&folder, Path::new("/dev/i2c-1"));
    let mut armed = latch.arm().unwrap();
    let long = "ä\n".repeat(RECORD);
    armed.latch(&long, false).unwrap();
    armed.latch("a later one", true).unwrap();
    let held = latch.read().unwrap();
    assert!(held.verified && held.cause.starts_with("ä ä "), "{held:?}");
    assert!(held.cause.len() <= CAUSE);
    assert_eq!(
        fs::metadata(&latch.file).unwrap().len(),
        RECORD as u64,
        "nothing grew"
    );
    // A disarmed record does not take the stop with it.
    armed.disarm();
    assert!(latch.read_locked().is_some());
    let file = Path::new("/dev/null/state");
    let refused = Latch::within(file, Path::new("/dev/i2c-1"))
        .arm()
        .unwrap_err();
    assert!(refused.contains("install -d /dev/null/state"), "{refused}");
    let _ = fs::remove_dir_all(&folder);
}
