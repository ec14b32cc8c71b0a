//! Tests of `output.rs`.

use super::*;

#[test]
fn nothing_half_written_stays() {
    let folder = std::env::temp_dir().join(format!("palpate-output-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("schedule.jsonl");
    let failed = write_file(&path, |out| {
        out.write_all(b"half")?;
        Err(io::Error::other("disk full"))
    });
    assert_eq!(failed.unwrap_err().status(), 3);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
    write_file(&path, |out| out.write_all(b"whole")).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "whole");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
    fs::remove_dir_all(&folder).unwrap();
    let nowhere = write_file(&folder.join("x"), |_| Ok(())).unwrap_err();
    assert!(
        nowhere.to_string().contains("cannot be written"),
        "{nowhere}"
    );
}
