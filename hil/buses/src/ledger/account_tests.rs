//! Tests of `account.rs`.

use super::*;

/// A folder of its own.
fn folder(name: &str) -> PathBuf {
    let name = format!("palpate-account-{name}-{}", std::process::id());
    let folder = std::env::temp_dir().join(name);
    let _ = fs::remove_dir_all(&folder);
    folder
}

#[test]
fn a_file_that_is_cut_changed_or_longer_is_not_believed() {
    let payload = [7, 0, 255, 1];
    let good = whole(&payload);
    assert_eq!(parse(&good), Ok(&payload[..]));
    for length in 0..good.len() {
        let why = parse(&good[..length]).unwrap_err();
        assert_eq!(why, "it is cut or damaged", "{length}");
    }
    for bit in 0..8 * good.len() {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert!(parse(&bad).is_err(), "{bit}");
    }
    assert!(parse(&[&good[..], &[0]].concat()).is_err());
    assert_eq!(parse(&whole(&[])), Ok(&[][..]));
    for version in [VERSION - 1, VERSION + 1, u32::MAX] {
        let mut other = good.clone();
        other[8..12].copy_from_slice(&version.to_le_bytes());
        let end = other.len() - TAIL;
        let sum = checksum(&other[..end]).to_le_bytes();
        other[end..].copy_from_slice(&sum);
        let why = parse(&other).unwrap_err();
        assert!(
            why.contains(&format!("found {version}: another version")),
            "{why}"
        );
    }
}

#[test]
fn what_is_written_is_read_again_and_a_neighbour_is_nobody() {
    let folder = folder("written");
    let account = Account::open(&folder, "a.heat").unwrap();
    assert!(account.payload().unwrap().is_none());
    let held = account.hold().unwrap();
    held.write(b"one").unwrap();
    held.write(b"another").unwrap();
    // A death in the midst of a write.
    fs::write(folder.join("a.heat.new"), "half of it").unwrap();
    let read = Account::open(&folder, "a.heat").unwrap();
    assert_eq!(read.payload().unwrap(), Some(&b"another"[..]));
    held.write(b"a third").unwrap();
    drop(held);
    let changed = read.hold().unwrap_err();
    assert!(matches!(changed, LedgerError::Changed(_)), "{changed}");
    assert!(Account::forget(&folder, "a.heat").unwrap());
    assert!(!Account::forget(&folder, "a.heat").unwrap());
    let read = Account::open(&folder, "a.heat").unwrap();
    assert!(read.payload().unwrap().is_none());
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn an_account_has_one_holder() {
    let folder = folder("held");
    let open = || Account::open(&folder, "b.dose").unwrap();
    let first = open().hold().unwrap();
    let refused = open().hold().unwrap_err();
    assert!(matches!(refused, LedgerError::Held(_)), "{refused}");
    first.write(b"x").unwrap();
    let refused = Account::forget(&folder, "b.dose").unwrap_err();
    assert!(matches!(refused, LedgerError::Held(_)), "{refused}");
    // Who lets go within two seconds is waited for.
    let (held, soon) = (first, RunClock::start());
    let late = std::thread::spawn(move || {
        soon.sleep_until(soon.now() + Duration::from_millis(300));
        drop(held);
    });
    open().hold().unwrap();
    late.join().unwrap();
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_cannot_be_read_or_kept_is_refused_with_the_way_out() {
    let folder = folder("odd");
    fs::create_dir_all(folder.join("c.heat")).unwrap();
    let refused = Account::open(&folder, "c.heat").unwrap_err();
    assert!(
        matches!(refused, LedgerError::Unreadable { .. }),
        "{refused}"
    );
    std::os::unix::fs::symlink("/dev/null", folder.join("d.heat")).unwrap();
    let refused = Account::open(&folder, "d.heat").unwrap_err();
    assert!(
        matches!(refused, LedgerError::Unreadable { .. }),
        "{refused}"
    );
    let nowhere = Account::open(Path::new("/dev/null/state"), "e.heat");
    let refused = match nowhere {
        Ok(account) => account.hold().unwrap_err(),
        Err(refused) => refused,
    };
    let text = refused.to_string();
    assert!(text.contains("/dev/null/state"), "{text}");
    let account = Account {
        file: "/dev/null/state/e.heat".into(),
        read: None,
    };
    let text = account.hold().unwrap_err().to_string();
    assert!(
        text.contains("`sudo install -d -m 1777 /dev/null`"),
        "{text}"
    );
    fs::remove_dir_all(&folder).unwrap();
}
