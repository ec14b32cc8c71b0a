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
    assert_eq!((log.frames.len(), log.beside), (4, Beside::default()));
}

#[test]
fn other_kinds_of_frames_are_counted() {
    let text = "(1.000000) can0 00000104#00 R\n\n(1.000000) can0 104#R\n(1.000000) can0 104##0AA\n(1.000000) can0 20000080#0000000000000000\n(1.000000) can0 104#00 T\n";
    let log = read(text).unwrap();
    assert_eq!((log.frames.len(), log.beside.other_kinds), (1, 4));
}

#[test]
fn a_log_as_can_utils_writes_and_plays_it() {
    let text = "# a remark\n(1.000000123) can0 104#1122334455667788_F\n\
        DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\nbench restarted\n\
        DROPCOUNT: dropped 1 CAN frame on 'can0' socket (total drops 4)\n\
        (1.000001999) can0 45123#81:00:12345678#11223344.556677\n(1.000002) can0 104#R8_E\n";
    let log = read(text).unwrap();
    assert_eq!(log.frames.len(), 1);
    assert_eq!(log.frames[0].at.as_micros(), 1_000_000);
    assert_eq!(
        log.frames[0].frame.data(),
        [0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88]
    );
    let beside = Beside {
        other_kinds: 2,
        dropped: 4,
        remarks: 2,
    };
    assert_eq!(log.beside, beside);
}

#[test]
fn columns_of_a_terminal_are_the_same_frames() {
    let logged =
        read("(1436509052.249713) can0 104#938406805591BB0C\n(1436509052.249714) can0 004#\n");
    for text in [
        " (1436509052.249713)  can0  104   [8]  93 84 06 80 55 91 BB 0C\n (1436509052.249714)  can0  004   [0]\n",
        " (1436509052.249713)  can0  RX - -  104   [8]  93 84 06 80 55 91 BB 0C   '....U...'\n (1436509052.249714)  can0  TX B E  004   [0] \n",
        "(1436509052.249713)  can0  104   {F}  93 84 06 80 55 91 BB 0C\n(1436509052.249714)  can0  004   [0]\n",
    ] {
        assert_eq!(read(text), logged, "{text}");
    }
    let others = " (1.000000)  can0  00000104   [1]  00\n (1.000000)  can0  104  [04]  00 01 02 03\n (1.000000)  can0  104   [2]  remote request\n";
    assert_eq!(read(others).unwrap().beside.other_kinds, 3);
    let untimed = read("  can0  104   [1]  00\n").unwrap_err();
    assert_eq!(
        untimed.expected,
        "a time before the frame (candump -L or candump -t a writes one)"
    );
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
        "can0 104#00",
        " can0  104   [1]  00",
        "(1.000000)  can0  104   [2]  00",
        "(1.000000) can0 104#00_F",
        "(1.000000) can0 104#0011223344556677_10",
        "DROPCOUNT: dropped",
        "(1.0) can0 104#00",
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
