//! Tests of `dump.rs`.

use super::*;

const HEAD: &str = "$timescale 1 us $end $scope module top $end\n$var wire 1 ! a $end $upscope $end $enddefinitions $end\n";

fn edges(text: &str) -> Vec<(u64, bool)> {
    let capture = read("a.vcd", text.as_bytes()).unwrap();
    assert_eq!(capture.notes, [""; 0]);
    capture.signals[0].edges.clone()
}

#[test]
fn a_bit_is_a_bit_however_it_is_written() {
    let same = [(0, false), (1000, true), (3000, false)];
    for body in [
        "#0 0! #1 1! #3 0!",
        "#0\nb0 !\n#1\nb1 !\n#3\nb0 !\n",
        "#0\n$dumpvars 0! $end\n#1\n$comment #2 0! $end\nH!\n#3\nL!\n",
        "#-5\n0!\n#-4\n1!\n#-2\n0!\n",
        "#750000\n0!\n#750001\nb0001 !\n#750003\n0!\nr1.5 \"\n",
    ] {
        assert_eq!(edges(&format!("{HEAD}{body}")), same, "{body}");
    }
    for kind in ["logic", "bit", "reg", "port", "ubit"] {
        let head = HEAD.replace("wire", kind);
        assert_eq!(edges(&format!("{head}#0 0! #1 1! #3 0!")), same, "{kind}");
    }
    let attributes = format!("$attrbegin misc 02 state 1 $end\n{HEAD}#0 0! #1 1! #3 0!");
    assert_eq!(edges(&attributes), same);
}

#[test]
fn a_signal_has_the_names_of_its_scopes_its_bit_and_its_aliases() {
    let text = "$scope struct s $end $var wire 1 ! pwm [3] $end $upscope $end $var logic 1 ! led $end $var real 64 # t $end\n\
                $var wire 8 $ bus [7:0] $end $timescale 10 ns $end $enddefinitions $end #0 1!";
    let capture = read("a.vcd", text.as_bytes()).unwrap();
    let [signal] = capture.signals.as_slice() else {
        panic!("one signal");
    };
    assert_eq!(signal.name, "pwm[3]");
    assert!(
        ["pwm[3]", "s.pwm[3]", "led"]
            .iter()
            .all(|name| signal.is_called(name))
    );
    assert!(!signal.is_called("pwm"));
    assert_eq!(capture.resolution_ns, 10);
}

#[test]
fn unknown_levels_are_not_seen() {
    let capture = read(
        "a.vcd",
        format!("{HEAD}#0 0! #1 1! #2 x! #4 0! #5 1! #6 0! #7 x! #9").as_bytes(),
    )
    .unwrap();
    let signal = &capture.signals[0];
    assert_eq!(signal.unseen, [(2000, 4000), (7000, 9000)]);
    assert_eq!(signal.pulses(capture.end_ns, 100_000), [(5000, 1000)]);
}

#[test]
fn wrong_declarations_are_refused_and_a_missing_scale_is_said() {
    for (text, said) in [
        (
            HEAD.replace("1 us", "0ps"),
            "expected a $timescale of 1 and more s, ms, us, ns, ps or fs, found `0ps`",
        ),
        (
            HEAD.replace("wire 1 ! a", "wire 1"),
            "expected a kind, a width, a code and a name behind $var",
        ),
        (
            format!("1! {HEAD}"),
            "expected declarations that end with $enddefinitions, found `1!`",
        ),
        (
            HEAD.replace("$enddefinitions $end", ""),
            "expected declarations that end with $enddefinitions, found none",
        ),
    ] {
        let error = read("a.vcd", text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    let unscaled = read(
        "a.vcd",
        format!("{}#0 1!", HEAD.replace("$timescale 1 us $end", "")).as_bytes(),
    );
    assert!(unscaled.unwrap().notes[0].contains("no $timescale"));
}

#[test]
fn a_damaged_dump_gives_what_came_before() {
    for (bad, said) in [
        (
            "#1.5",
            "expected a stamp that is a whole number, found `#1.5`",
        ),
        ("?!", "expected a keyword, a stamp or a value, found `?!`"),
        ("1", "expected a keyword, a stamp or a value, found `1`"),
    ] {
        let capture = read(
            "a.vcd",
            format!("{HEAD}#0 0! #1 1! #2 0!\n{bad}\n1!").as_bytes(),
        )
        .unwrap();
        assert_eq!(capture.signals[0].edges.len(), 3);
        assert!(capture.notes[0].contains(said), "{:?}", capture.notes);
        assert!(
            capture.notes[0].ends_with("3 changes until 0.000002 s were read"),
            "{:?}",
            capture.notes
        );
    }
}
