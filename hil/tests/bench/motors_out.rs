//! Ways out of a run on motors: STOP on its page, a terminal that takes nothing, a full disk, a reader that goes away.

use std::fs;
use std::io::Read;
use std::net::TcpStream;
use std::path::Path;
use std::time::Duration;

use nix::sys::signal::Signal;
use nix::sys::stat::Mode;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket, client};

use crate::guardian_faults::full_pipe;
use crate::motors::{END, on_motors, scene};
use crate::rig::{Bench, OFF_MS, is_soon, now_ns};
use crate::run::{Run, Said};

/// Longest burst of the scene, ms.
const BURST_MS: f64 = 60.0;
/// Time in which a run writes or prints something: its record grows with every piece.
const NEXT_WRITE: Duration = Duration::from_secs(5);

fn hil() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_hil"))
}

fn words<'a>(scene: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["run", scene, "--bench", "motors.toml"], more].concat()
}

/// Checks that a run which was driving ended with every motor at rest, and that none shook for longer than a burst and the
/// way to its end.
#[track_caller]
fn assert_ended(bench: &Bench, run: Run<'_>) -> Said {
    let said = run.finish(END);
    bench.assert_off_within(BURST_MS + OFF_MS, 0);
    assert!(bench.longest_on() > 5.0, "no motor shook");
    said
}

/// Opens the page of a run, which begins then.
fn opened(run: &Run<'_>) -> WebSocket<TcpStream> {
    let host = || {
        Some(
            run.told()
                .split_once("http://")?
                .1
                .split_once('/')?
                .0
                .to_owned(),
        )
    };
    assert!(is_soon(END, || host().is_some()), "{}", run.told());
    let host = host().unwrap();
    let mut request = format!("ws://{host}/live").into_client_request().unwrap();
    let origin = format!("http://{host}").parse().unwrap();
    request.headers_mut().insert("Origin", origin);
    client(request, TcpStream::connect(&host).unwrap())
        .unwrap()
        .0
}

#[test]
fn stop_on_the_page_ends_a_run_on_motors_at_rest_and_latched() {
    on_motors(|bench| {
        let _feed = bench.feed();
        let scene = scene(bench, 30.0);
        let run = bench.start(&words(&scene, &["--serve", "127.0.0.1:0"]));
        let mut page = opened(&run);
        run.wait_for_burst();
        let at = now_ns();
        page.send(Message::text(r#"{"stop":true}"#)).unwrap();
        let said = assert_ended(bench, run);
        bench.assert_off_within(OFF_MS, at);
        assert_eq!(said.status, Some(4), "{said:?}");
        assert_ne!(bench.latched(), "", "{said:?}");
    });
}

/// A stopped terminal (Ctrl-S) takes nothing, as this pipe.
#[test]
fn a_terminal_that_takes_nothing_keeps_no_motor_on() {
    for signal in [Signal::SIGINT, Signal::SIGKILL] {
        on_motors(|bench| {
            let _feed = bench.feed();
            let (mut reader, writer) = full_pipe();
            let scene = scene(bench, 30.0);
            let run = bench.start_with(hil(), &words(&scene, &[]), Some(writer.into()));
            run.wait_for_burst();
            let at = now_ns();
            run.signal(signal);
            assert!(is_soon(NEXT_WRITE, || !bench.is_on()));
            bench.assert_off_within(OFF_MS, at);
            let reading = std::thread::spawn(move || reader.read_to_end(&mut Vec::new()));
            assert_ended(bench, run);
            reading.join().unwrap().unwrap();
        });
    }
}

#[test]
fn a_disk_that_is_full_ends_a_run_on_motors_at_rest() {
    on_motors(|bench| {
        let _feed = bench.feed();
        let scene = scene(bench, 30.0);
        // A file may have 300 kB: a record of frames grows by 70 kB per second.
        let line = "trap '' XFSZ; ulimit -f 600; exec \"$0\" \"$@\"";
        let own = words(&scene, &["--quiet", "--record", "full.log"]);
        let all = [&["-c", line, hil().to_str().unwrap()], &own[..]].concat();
        let run = bench.start_with(Path::new("/bin/sh"), &all, None);
        run.wait_for_burst();
        assert!(run.ends_within(NEXT_WRITE), "{}", run.told());
        let said = assert_ended(bench, run);
        assert_eq!(said.status, Some(3), "{said:?}");
        assert!(said.err.contains("File too large"), "{said:?}");
        assert!(fs::metadata(bench.path("full.log")).is_ok_and(|file| file.len() <= 600 * 512));
    });
}

#[test]
fn a_reader_of_the_record_that_goes_away_leaves_no_motor_on() {
    on_motors(|bench| {
        let pipe = bench.path("frames.log");
        nix::unistd::mkfifo(&pipe, Mode::S_IRWXU).unwrap();
        let reading = std::thread::spawn(move || {
            let mut reader = fs::File::open(pipe).unwrap();
            reader.read_exact(&mut [0; 100_000]).unwrap();
        });
        let _feed = bench.feed();
        let scene = scene(bench, 30.0);
        let run = bench.start(&words(&scene, &["--quiet", "--record", "frames.log"]));
        run.wait_until_on();
        assert!(run.ends_within(NEXT_WRITE), "{}", run.told());
        reading.join().unwrap();
        let said = assert_ended(bench, run);
        assert_eq!(said.status, Some(3), "{said:?}");
        assert!(said.err.contains("frames.log"), "{said:?}");
    });
}
