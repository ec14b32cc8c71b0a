//! Formats by their first bytes.

use super::*;

#[test]
fn formats_are_told_by_their_first_bytes() {
    for (start, format) in [
        (&b"\x89MCAP0\r\n\x01"[..], Some(Format::Mcap)),
        (b"(1436509052.249713) can0 104#93\n", Some(Format::Candump)),
        (
            b"# restarted\n(1436509052.249713) can0 104#93\n",
            Some(Format::Candump),
        ),
        (b"  can0  104   [1]  93\n", Some(Format::Candump)),
        (b"DROPCOUNT: dropped 3 CAN frames", Some(Format::Candump)),
        (
            b"{\"version\":1,\"seed\":1,\"scene_digest\":\"8\"}\n{",
            Some(Format::Schedule),
        ),
        (b"frame,time_us,module,contact\n", Some(Format::Contacts)),
        (
            b"palpate contact path of idle (emulated)\n",
            Some(Format::Golden),
        ),
        (
            b"---\nsource: a.rs\n---\npalpate schedule of idle\n",
            Some(Format::Golden),
        ),
        (b"$version palpate $end\n", Some(Format::Vcd)),
        (b"\0\0\0\0\0\0\0\x01\x49\0", Some(Format::Fst)),
        (b"\xFE\0\0\0\0\0\0\0\x80", Some(Format::Fst)),
        (b"GHDLwave\n\x10\0\x01\x01", Some(Format::Ghw)),
        (b"<!DOCTYPE html>\n", Some(Format::Html)),
        (
            b"<?xml version=\"1.0\"?>\n<testsuites>",
            Some(Format::Junit),
        ),
        (b"<?xml version=\"1.0\"?>\n<rss>", Some(Format::Xml)),
        (b"<svg xmlns=\"..\">", Some(Format::Svg)),
        (b"{\"a\": 1}", Some(Format::Json)),
        (b"[{\"text\": 1}]", Some(Format::Json)),
        (b"# a scene\nname = \"mine\"\n", Some(Format::Toml)),
        (b"[[outputs]]\n", Some(Format::Toml)),
        (b"\xEF\xBB\xBFtxl1_x,txl1_y\n1,2\n", Some(Format::Csv)),
        (b"1,2\n3,4\n", Some(Format::Csv)),
        (b"\x10\0\0\0\0\0\0\0{}", Some(Format::Safetensors)),
        (b"hello\n", None),
        (b"", None),
    ] {
        assert_eq!(Format::recognise(start), format, "{}", start.escape_ascii());
    }
    for start in [
        &b"\0\0\0"[..],
        b"\x1f\x8b\x08",
        b"PK\x03\x04",
        b"\xFF\xFEt\0",
        b"date Sun Mar 1 12:00:00 pm 2026\nbase hex  timestamps absolute\n",
        b";$FILEVERSION=2.0\n",
        b"LOGG\x90\0\0\0",
        b"Time Stamp,ID,Extended,Dir,Bus,LEN,D1\n",
        b"PAR1\x15\x04",
    ] {
        assert!(matches!(Format::recognise(start), Some(Format::Binary(_))));
    }
}

#[test]
fn every_shipped_settings_file_is_toml() {
    for name in palpate_fixtures::scene_names() {
        let text = palpate_fixtures::scene(name).unwrap();
        assert_eq!(
            Format::recognise(text.as_bytes()),
            Some(Format::Toml),
            "{name}"
        );
    }
    for name in palpate_fixtures::layout_names() {
        let text = palpate_fixtures::layout(name).unwrap();
        assert_eq!(
            Format::recognise(text.as_bytes()),
            Some(Format::Toml),
            "{name}"
        );
    }
}

/// Git and editors of other systems leave a file like this.
#[test]
fn a_heading_is_found_behind_a_mark_and_between_lines_of_windows() {
    let plain = "---\nsource: x\nwhy: y\n---\npalpate contacts of a (b)\n";
    let (head, body) = headed(plain);
    assert_eq!(head, Some("source: x\nwhy: y"));
    assert_eq!(body, "palpate contacts of a (b)\n");
    let windows = format!("\u{FEFF}{}", plain.replace('\n', "\r\n"));
    let (head, body) = headed(&windows);
    assert_eq!(head, Some("source: x\r\nwhy: y"));
    assert_eq!(body, "palpate contacts of a (b)\r\n");
    assert_eq!(Format::recognise(windows.as_bytes()), Some(Format::Golden));
}
