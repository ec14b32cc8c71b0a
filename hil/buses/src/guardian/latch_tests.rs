//! Tests of `latch.rs`.

use sha2::{Digest, Sha256};

use super::*;
use std::os::unix::fs::{MetadataExt, PermissionsExt};

/// What nobody wrote another cause for.
const ENDED: &str = "it ended without a word";

/// A folder of stops and one of locks, gone with the value.
struct Stops(PathBuf);

impl Stops {
    fn new(name: &str) -> Self {
        let folder = env::temp_dir().join(format!("palpate-stops-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("locks")).unwrap();
        Self(folder)
    }

    fn hardware() -> Hardware {
        Hardware::unit("one", &[1; 32])
    }

    fn latch(&self) -> Latch {
        Latch::within(&self.0.join("state"), &Self::hardware())
    }

    fn lock(&self) -> BusLock {
        BusLock::within(&self.0.join("locks"), &Self::hardware()).unwrap()
    }
}

impl Drop for Stops {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn the_first_cause_is_kept_until_a_person_clears_it() {
    let stops = Stops::new("first");
    let (latch, lock) = (stops.latch(), stops.lock());
    assert_eq!(latch.read(), None);
    let mut armed = latch.arm(&lock, ENDED).unwrap();
    armed.latch("the run died\nat once", false).unwrap();
    let held = latch.read().unwrap();
    assert_eq!(
        (held.cause.as_str(), held.verified),
        ("the run died at once", false)
    );
    let written_s = fs::metadata(&latch.file).unwrap().mtime() as u64;
    assert!(written_s.abs_diff(held.at_s) < 60, "{held:?}");
    let said = held.refusal(&"the bench");
    assert!(
        said.starts_with("the bench: stopped earlier: the run died at once; not everything was"),
        "{said}"
    );
    armed.latch("something else", true).unwrap();
    let later = latch.read().unwrap();
    assert_eq!(
        (&later.cause, later.at_s, later.verified),
        (&held.cause, held.at_s, true)
    );
    latch.clear(&lock).unwrap();
    latch.clear(&lock).unwrap();
    assert_eq!((latch.read(), latch.read_locked(&lock)), (None, None));
}

#[test]
fn what_a_run_leaves_armed_is_a_stop_for_the_next_one_alone() {
    let stops = Stops::new("armed");
    let (latch, lock) = (stops.latch(), stops.lock());
    let armed = latch.arm(&lock, ENDED).unwrap();
    assert_eq!(latch.read(), None, "a run is on");
    let held = latch.read_locked(&lock).unwrap();
    assert_eq!((held.cause.as_str(), held.verified), (ENDED, false));
    armed.disarm();
    assert_eq!(latch.read_locked(&lock), None);
    let _armed = latch.arm(&lock, ENDED).unwrap();
    latch.clear(&lock).unwrap();
    assert_eq!(latch.read_locked(&lock), None);
}

#[test]
fn a_stop_needs_no_room_and_keeps_its_first_cause() {
    let stops = Stops::new("full");
    let (latch, lock) = (stops.latch(), stops.lock());
    let mut armed = latch.arm(&lock, ENDED).unwrap();
    let about = || fs::metadata(&latch.file).unwrap();
    let before = about();
    let long = "ä\n".repeat(RECORD);
    armed.latch(&long, false).unwrap();
    armed.latch("a later one", true).unwrap();
    let held = latch.read().unwrap();
    assert!(held.verified && held.cause.starts_with("ä ä "), "{held:?}");
    assert!(held.cause.len() <= CAUSE);
    let after = about();
    assert_eq!(
        (after.ino(), after.len(), after.blocks()),
        (before.ino(), RECORD as u64, before.blocks()),
        "nothing grew"
    );
    // A disarmed record does not take the stop with it.
    armed.disarm();
    assert!(latch.read().is_some());
}

#[test]
fn a_folder_that_cannot_be_had_is_refused_with_the_line_that_makes_it() {
    let stops = Stops::new("none");
    let latch = Latch::within(Path::new("/dev/null/state"), &Stops::hardware());
    let refused = latch.arm(&stops.lock(), ENDED).unwrap_err();
    assert!(
        refused.contains("`sudo install -d -m 1777 /dev/null/state`"),
        "{refused}"
    );
}

#[test]
fn stops_are_of_all_users() {
    let stops = Stops::new("users");
    let (latch, lock) = (stops.latch(), stops.lock());
    let _armed = latch.arm(&lock, ENDED).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o7777;
    assert_eq!(mode(&stops.0.join("state")), 0o1777);
    assert_eq!(mode(&latch.file), 0o666);
}

#[test]
fn a_record_that_is_cut_or_damaged_holds() {
    let stops = Stops::new("cut");
    let (latch, lock) = (stops.latch(), stops.lock());
    for latched in [None, Some("a stop")] {
        let mut armed = latch.arm(&lock, ENDED).unwrap();
        if let Some(cause) = latched {
            armed.latch(cause, true).unwrap();
        }
        armed.disarm();
        let whole = fs::read(&latch.file).unwrap();
        for length in 0..whole.len() {
            fs::write(&latch.file, &whole[..length]).unwrap();
            let held = latch.read();
            assert!(held.is_some(), "cut at {length}");
        }
        for other in [
            &[&whole[..], b" "].concat()[..],
            &b"?"[..],
            &[0; RECORD],
            &[b' '; RECORD + 1],
            &[0xFF; RECORD],
        ] {
            fs::write(&latch.file, other).unwrap();
            assert!(latch.read().unwrap().cause.contains("damaged"));
        }
        latch.clear(&lock).unwrap();
        assert_eq!(latch.read_locked(&lock), None);
    }
}

#[test]
fn a_record_of_a_newer_version_holds_and_is_not_cleared_here() {
    let stops = Stops::new("newer");
    let (latch, lock) = (stops.latch(), stops.lock());
    latch.arm(&lock, ENDED).unwrap().disarm();
    let own = fs::read_to_string(&latch.file).unwrap();
    for newer in [
        own.replace("palpate-stop 1\n", "palpate-stop 2\n"),
        "palpate-stop 17\nanything else\n".to_owned(),
    ] {
        fs::write(&latch.file, &newer).unwrap();
        let held = latch.read().unwrap();
        assert!(held.cause.contains("newer version"), "{held:?}");
        let kept = latch.clear(&lock).unwrap_err().to_string();
        assert!(kept.contains("newer version"), "{kept}");
        assert_eq!(fs::read_to_string(&latch.file).unwrap(), newer);
    }
    // One of no version is no clear record either.
    fs::write(&latch.file, own.replace("palpate-stop 1\n", "")).unwrap();
    assert!(latch.read().is_some());
}

#[test]
fn neither_a_link_nor_a_pipe_is_a_record() {
    let stops = Stops::new("odd");
    let (latch, lock) = (stops.latch(), stops.lock());
    latch.arm(&lock, ENDED).unwrap().disarm();
    let target = stops.0.join("target");
    fs::rename(&latch.file, &target).unwrap();
    std::os::unix::fs::symlink(&target, &latch.file).unwrap();
    assert!(latch.read().is_some(), "a link to a clear record");
    let refused = latch.arm(&lock, ENDED).unwrap_err();
    // No other file is tried to be made in its place.
    assert!(!refused.contains("exists"), "{refused}");
    latch.clear(&lock).unwrap_err();
    fs::remove_file(&latch.file).unwrap();
    nix::unistd::mkfifo(&latch.file, nix::sys::stat::Mode::S_IRWXU).unwrap();
    assert!(latch.read().is_some());
    latch.arm(&lock, ENDED).unwrap_err();
    latch.clear(&lock).unwrap_err();
}

#[test]
fn what_is_left_armed_is_a_stop_where_nobody_holds_the_lock() {
    let stops = Stops::new("look");
    let own = Hardware::unit(
        "one",
        &Sha256::digest(stops.0.to_string_lossy().as_bytes()).into(),
    );
    let latch = Latch::within(&stops.0.join("state"), &own);
    let lock = BusLock::take(&own).unwrap();
    let mut armed = latch.arm(&lock, ENDED).unwrap();
    assert_eq!(latch.look(), None, "a run is on");
    armed.latch("a stop", false).unwrap();
    assert_eq!(latch.look().unwrap().cause, "a stop");
    latch.clear(&lock).unwrap();
    let _armed = latch.arm(&lock, ENDED).unwrap();
    drop(lock);
    assert_eq!(latch.look().unwrap().cause, ENDED);
    // Its file is of this test alone.
    let lock = format!("palpate-{}.lock", own.file());
    for folder in ["/run/lock", "/tmp"] {
        let _ = fs::remove_file(Path::new(folder).join(&lock));
    }
}

#[test]
fn stops_are_in_one_folder_of_all_users_and_count_there_from_any_other() {
    let system = Path::new(SYSTEM);
    for (named, folder) in [
        (None, system),
        (Some("state"), system),
        (Some(""), system),
        (Some("/elsewhere"), Path::new("/elsewhere")),
    ] {
        assert_eq!(folder_by(named.map(OsString::from)), folder);
        let latch = Latch::within(folder, &Stops::hardware());
        let files: Vec<_> = latch.files().map(|file| file.parent().unwrap()).collect();
        match folder == system {
            true => assert_eq!(files, [system]),
            false => assert_eq!(files, [folder, system]),
        }
    }
    assert!(folder().is_absolute());
    match stops_folder() {
        Ok(writable) => assert_eq!(writable, folder()),
        Err((why, line)) => {
            let name = folder().display().to_string();
            assert!(
                why.starts_with(&name) && line.ends_with(&name),
                "{why}: {line}"
            );
        }
    }
}
