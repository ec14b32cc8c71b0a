//! One wire, once: what is said before it is heated and after, and what is refused.

use serde_json::Value;

use super::*;

/// The object of a pulse on an emulated bench.
fn object(args: &[&str]) -> Value {
    let words = [&["pulse", "--yes", "--json"], args].concat();
    serde_json::from_str(&good(&words)).unwrap()
}

#[test]
fn an_emulated_wire_is_heated_once_within_the_limits() {
    let of = object(&["3"]);
    assert_eq!(
        (&of["source"], &of["bench"]),
        (&"emulated".into(), &"emulated".into())
    );
    assert_eq!(
        (&of["sent"], &of["stimuli"], &of["wire"]),
        (&true.into(), &1.into(), &3.into())
    );
    assert_eq!(of["felt_by_table"], true);
    let number = |key: &str| of[key].as_f64().unwrap();
    // A pulse is no wider than the table of limits lets it be, and the skin stays under its own.
    assert!((1.0..=200.0).contains(&number("width_us")), "{of}");
    assert!(
        number("length_ms") >= 1.0 && number("off_ms") >= number("length_ms"),
        "{of}"
    );
    assert!((33.0..43.0).contains(&number("skin_c")), "{of}");
    assert!(of["used"]["wire_power"].as_f64().unwrap() > 0.0, "{of}");
    let line = good(&["pulse", "3", "--yes"]);
    assert!(
        line.lines().all(|line| line.chars().count() <= 80),
        "{line}"
    );
    let line = line.split_whitespace().collect::<Vec<_>>().join(" ");
    for words in [
        "emulated: wire 3 of bench `emulated`: sent",
        "confirmed off",
        "heat: ",
        "hil doctor",
    ] {
        assert!(line.contains(words), "no `{words}` in: {line}");
    }
    assert_eq!(good(&["pulse", "3", "--yes", "--quiet"]), "");
}

#[test]
fn a_bench_of_several_displays_names_the_one() {
    let of = object(&["7", "--bench", "allegro-hand", "--finger", "index"]);
    assert_eq!(
        (&of["sent"], &of["stimuli"]),
        (&true.into(), &1.into()),
        "{of}"
    );
    let several = ["pulse", "7", "--yes", "--bench", "allegro-hand"];
    refused_with(
        &several,
        &["--finger: expected one of", "`index`", "`thumb`"],
    );
    let unknown = [&several[..], &["--finger", "toe"]].concat();
    refused_with(&unknown, &["--finger: expected one of", "found `toe`"]);
    refused_with(
        &["pulse", "7", "--yes", "--finger", "index"],
        &["--finger: expected nothing", "one display"],
    );
}

#[test]
fn a_wire_that_is_not_there_and_a_question_without_a_terminal_are_refused() {
    refused_with(
        &["pulse", "8", "--yes"],
        &["a wire of bench `emulated`, 0 to 7, found 8"],
    );
    for wrong in ["-1", "three", "1e99", "", "0.5"] {
        refused_with(
            &["pulse", wrong, "--yes"],
            &["WIRE", "a whole number from 0 to 127"],
        );
    }
    refused_with(&["pulse"], &["WIRE"]);
    refused_with(
        &["pulse", "3"],
        &[
            "wire 3 of bench `emulated` (emulated) will be heated for",
            "mJ",
            "C allowed",
            "Expected --yes",
        ],
    );
}

#[test]
fn a_terminal_is_asked_once() {
    // `script` gives a program a terminal; without it there is nothing to see here.
    if Command::new("script").arg("--version").output().is_err() {
        return;
    }
    for (answer, status, words) in [
        ("y\n", 0, "confirmed off"),
        ("n\n", 2, "nothing was heated"),
        ("\n", 2, "nothing was heated"),
    ] {
        let line = format!("{} pulse 3", env!("CARGO_BIN_EXE_hil"));
        let mut script = Command::new("script");
        script
            .args(["-qec", &line, "/dev/null"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut script = script.spawn().unwrap();
        let mut input = script.stdin.take().unwrap();
        std::io::Write::write_all(&mut input, answer.as_bytes()).unwrap();
        let said = script.wait_with_output().unwrap();
        drop(input);
        let text = String::from_utf8_lossy(&said.stdout).into_owned();
        assert_eq!(said.status.code(), Some(status), "{text}");
        assert!(
            text.contains("Heat it? [y/N]") && text.contains(words),
            "{text}"
        );
    }
}
