//! Tests of `candump.rs`.

use super::*;

#[test]
fn lines_survive_the_round_trip_to_the_microsecond() {
    let text = "(1436509052.249713) can0 104#938406805591BB0C\n(0000000000.000001) vcan1 20F#0700\n(0000000001.000000) can0 7FF#\n(18446744073709.551615) can0 000#00\n";
    let log = read(text).unwrap();
    let mut again = String::new();
    for l in &log.frames {
        write_line(&mut again, l.at, &l.interface, &l.frame);
    }
    assert_eq!(again, text);
    assert_eq!(log.frames[0].at.as_micros(), 1_436_509_052_249_713);
    assert_eq!((log.frames.len(), log.other_kinds), (4, 0));
}

#[test]
fn other_kinds_of_frames_are_counted() {
    let text = "(1.000000) can0 00000104#00 R\n\n(1.000000) can0 104#R\n(1.000000) can0 104##0AA\n(1.000000) can0 20000080#0000000000000000\n(1.000000) can0 104#00 T\n";
    let log = read(text).unwrap();
    assert_eq!((log.frames.len(), log.other_kinds), (1, 4));
}

#[test]
fn a_log_that_was_cut_is_read_up_to_the_cut() {
    let text = "(1.000000) can0 104#00\n(1.000100) can0 104#000102\n";
    for cut in 24..text.len() - 1 {
        let log = read(&text[..cut]).unwrap();
        // Whole bytes are a whole frame: a log cannot tell.
        assert!(
            log.frames.len() == 2 || log.cut == Some(2),
            "{}",
            &text[..cut]
        );
    }
    assert_eq!(read("(1.0000").unwrap_err().line, 1, "nothing was saved");
}

#[test]
fn malformed_lines_are_named() {
    for bad in [
        "hello",
        "(1.0) can0 104#00",
        "1.000000 can0 104#00",
        "(99999999999999999999.000000) can0 104#00",
        "(18446744073709551.000000) can0 104#00",
        "(1.000000) can0 104",
        "(1.000000) can0 10#00",
        "(1.000000) can0 FFF#00",
        "(1.000000) can0 104#0",
        "(1.000000) can0 104#é",
        "(1.000000) can0 104#000102030405060708",
        "(1.000000) can0 104#00 X",
        "(1.000000) can0 104#00 R R",
    ] {
        let error = read(&format!("(1.000000) can0 104#00\n{bad}\n")).unwrap_err();
        assert_eq!(error.line, 2, "{bad}");
    }
}
