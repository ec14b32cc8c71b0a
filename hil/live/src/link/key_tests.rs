//! Tests of `key.rs`.

use std::fs;

use super::*;

#[test]
fn a_key_is_read_as_it_was_made_and_only_if_no_one_else_can_read_it() {
    let folder = std::env::temp_dir().join(format!("palpate-key-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("unit.key");
    make(&path).unwrap();
    let mode = fs::metadata(&path).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    let key = read(&path).unwrap();
    assert_ne!(key, [0; LENGTH]);
    let again = make(&path).unwrap_err().to_string();
    assert!(again.contains("expected a new file"), "{again}");
    assert_eq!(read(&path).unwrap(), key);
    fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
    let seen = read(&path).unwrap_err().to_string();
    assert!(
        seen.contains("mode 640") && seen.contains("chmod 600"),
        "{seen}"
    );
    fs::set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    for bad in [
        "",
        "00",
        &text[1..],
        &format!("{text}00"),
        &text.replace(&text[..1], "g"),
        &"é".repeat(32),
        &"0".repeat(64),
    ] {
        fs::write(&path, bad).unwrap();
        let said = read(&path).unwrap_err().to_string();
        assert!(said.contains("64 hexadecimal digits"), "{bad}: {said}");
    }
    fs::remove_dir_all(&folder).unwrap();
}
