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
