//! What is no text, never ends or is cut by a power failure, as readers meet it.

use super::*;

fn lines(bytes: &[u8], longest: usize) -> (Vec<String>, Result<Option<String>, String>) {
    let mut lines = Lines::over(Text::new("f", bytes, longest));
    let mut read = Vec::new();
    loop {
        match lines.advance() {
            Ok(Some((_, line))) => read.push(line.to_owned()),
            Ok(None) => return (read, Ok(lines.note())),
            Err(e) => return (read, Err(e.to_string())),
        }
    }
}

fn said(bytes: &[u8], longest: usize) -> String {
    lines(bytes, longest).1.unwrap_err()
}

#[test]
fn lines_come_without_their_ends_and_the_mark_of_the_first() {
    let (read, note) = lines(b"\xEF\xBB\xBFa\r\n\nb", 8);
    assert_eq!(
        (read, note),
        (vec!["a".into(), String::new(), "b".into()], Ok(None))
    );
}

#[test]
fn a_tail_of_nuls_goes_with_the_line_it_cut_and_is_noted() {
    let (read, note) = lines(b"a\nb\nhalf\0\0\0", 8);
    assert_eq!(read, ["a", "b"]);
    let note = note.unwrap().unwrap();
    assert!(
        note.starts_with("f:3: the file ends in 3 NUL bytes"),
        "{note}"
    );
    let (read, note) = lines(b"a\n\0\0", 8);
    assert_eq!((read.len(), note.unwrap().is_some()), (1, true));
}

#[test]
fn other_nuls_are_refused_with_their_line() {
    assert!(said(b"\0\0\0", 8).starts_with("f:1: expected a text, found 1 NUL"));
    let amid = "f:2: expected text, found 2 NUL bytes in the middle of the file";
    assert_eq!(said(b"a\n\0\0b\n", 8), amid);
    assert_eq!(said(b"a\n\0\0\n", 8), amid);
}

/// However much comes: no more than a line is held.
#[test]
fn a_line_without_an_end_is_refused_at_its_bound() {
    let mut lines = Lines::over(Text::new("f", io::repeat(b'x'), 1000));
    let error = lines.advance().unwrap_err().to_string();
    assert_eq!(
        error,
        "f:1: expected a line of at most 1000 bytes, found a longer one"
    );
    assert!(lines.line.capacity() < 1 << 18);
    let mut zeros = Lines::over(Text::new("f", io::repeat(0), 1000));
    assert!(zeros.advance().is_err());
    assert_eq!(said(b"ok\nxxxxxxxxx", 8).split(':').nth(1), Some("2"));
}

#[test]
fn no_utf_8_is_named_by_its_line() {
    assert_eq!(
        said(b"a\nb\xFF\n", 8),
        "f:2: expected UTF-8 text, found byte 0xFF"
    );
}

#[cfg(unix)]
#[test]
fn what_is_no_ordinary_file_is_refused_at_once() {
    let folder = std::env::temp_dir().join(format!("palpate-reading-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let sparse = folder.join("sparse");
    File::create(&sparse).unwrap().set_len(6 << 30).unwrap();
    let said = |path: &Path| read_bytes(path, "a scene", 1000).unwrap_err().to_string();
    assert!(said(&folder).ends_with("expected a scene, found a folder"));
    assert!(said(Path::new("/dev/zero")).contains("found a device"));
    assert!(said(&folder.join("none")).contains("no such file"));
    assert!(said(&sparse).ends_with("a scene of at most 1000 bytes, found 6442450944 bytes"));
    let found = Lines::open(&sparse, "a log", 1000).unwrap_err().found;
    assert_eq!(found, "NUL bytes");
    std::fs::remove_dir_all(&folder).unwrap();
}
