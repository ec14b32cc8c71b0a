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

/// Bytes that come in pieces of one length, as a pipe delivers them.
struct Pieces<'a>(&'a [u8], usize);

impl Read for Pieces<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let most = self.1.min(out.len());
        self.0.read(&mut out[..most])
    }
}

#[test]
fn a_format_does_not_depend_on_the_pieces_of_a_pipe() {
    for text in [
        "(1436509052.249713) can0 104#93\n(1436509052.249813) can0 105#93\n",
        "# restarted\n\n(1436509052.249713) can0 104#93\n",
        "DROPCOUNT: dropped 3 CAN frames\n",
        "  can0  104   [1]  93\n",
        "frame,time_us,module,contact\n1,2,3,4\n",
        "\u{FEFF}ch0;ch1\n1,5;2,5\n",
        "{\"version\":1,\"seed\":1,\"scene_digest\":\"8\"}\n{\"t_us\":1}\n",
        "---\nsource: a.rs\n---\npalpate schedule of idle\n",
        "$version palpate $end\n",
        "// version 8.0.0\ndate Sun Mar 1 12:00:00 pm 2026\n",
        "date Sun Mar 1 12:00:00 pm 2026\nbase hex  timestamps absolute\n",
        "<?xml version=\"1.0\"?>\n<testsuites>\n",
        "name = \"mine\"\n",
    ] {
        let format = Format::recognise(text.as_bytes());
        assert!(format.is_some(), "{text}");
        for length in 1..text.len() {
            let pieces = Pieces(text.as_bytes(), length);
            let text = Text::new("f", pieces, 1000).waiting();
            let found = Lines::over(text).format().unwrap();
            assert_eq!(found, format, "pieces of {length}");
        }
    }
}

/// A row that comes in pieces tells its separator, and a stream that goes on does not wait for more.
#[test]
fn a_live_stream_waits_for_its_first_row() {
    let text = "\u{FEFF}# of a skin\n\n10;20\n11;21\n";
    for length in 1..text.len() {
        let mut lines = Lines::over(Text::new("f", Pieces(text.as_bytes(), length), 1000));
        assert!(lines.start().unwrap().contains("10;20\n"), "{length}");
        let read = text.len() - lines.text.get_ref().input.0.len();
        let row = text.find("11").unwrap();
        assert!(read < row + length, "{length}: {read} bytes were read");
    }
}
