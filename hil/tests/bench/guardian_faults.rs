//! The guardian acts whatever else fails beside it: a terminal that takes nothing, a disk that hangs, no thread, no memory.

use std::io::{Read, Write};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use nix::fcntl::{FcntlArg, OFlag, fcntl};
use nix::libc;
use nix::sys::signal::Signal;
use palpate_tests::fake_bench::{GUARDIAN, Mode};

use crate::rig::{Bench, OFF_MS, is_soon, now_ns, on_bench};
use crate::run::{Run, signal};

/// What a guardian is given to end once nothing holds it up.
const END: Duration = Duration::from_secs(6);
/// How long a bus fails.
const FAILS: Duration = Duration::from_millis(300);

/// The run is killed in a burst while its bus fails for a moment. The guardian is held up meanwhile by something that has
/// nothing to do with the bus: outputs are off once the bus answers.
fn killed_while_the_bus_fails(bench: &Bench, run: &Run<'_>, hold_up: impl FnOnce()) {
    run.wait_for_burst();
    hold_up();
    bench.set_mode(Mode::Fails(libc::ENXIO as u16));
    let failed = Instant::now();
    let at = run.kill();
    std::thread::sleep(FAILS);
    bench.set_mode(Mode::Works);
    let unreachable_ms = failed.elapsed().as_secs_f64() * 1e3;
    is_soon(Duration::from_secs(1), || !bench.is_on());
    bench.assert_off_within(unreachable_ms + OFF_MS, at);
}

/// The writing end of a pipe that takes nothing more, and its other end.
pub fn full_pipe() -> (std::io::PipeReader, std::io::PipeWriter) {
    let (reader, mut writer) = std::io::pipe().unwrap();
    fcntl(&writer, FcntlArg::F_SETFL(OFlag::O_NONBLOCK)).unwrap();
    for size in [4096, 1] {
        while writer.write(&vec![b'x'; size]).is_ok() {}
    }
    fcntl(&writer, FcntlArg::F_SETFL(OFlag::empty())).unwrap();
    (reader, writer)
}

/// Without a guardian the run itself stays until its bus answers.
#[test]
fn a_run_without_guardian_and_bus_stays_until_all_is_off() {
    for adapters in [1, 2] {
        on_bench(adapters, |bench| {
            let _feed = bench.feed();
            let run = bench.run(30.0);
            let adapter = run.wait_for_burst();
            bench.adapters[adapter].set_mode(Mode::Hangs);
            signal(run.guardian(), Signal::SIGKILL);
            std::thread::sleep(Duration::from_millis(700));
            bench.set_mode(Mode::Works);
            let at = now_ns();
            let said = run.finish(END);
            bench.assert_off_within(OFF_MS, at);
            assert_eq!(said.status, Some(1), "{said:?}");
            assert!(said.err.contains("LIMIT EXCEEDED"), "{said:?}");
            // What the guardian had armed refuses the next run.
            let next = bench.run(1.0).finish(END);
            assert_eq!(next.status, Some(4), "{next:?}");
        });
    }
}

#[test]
fn a_standard_error_that_takes_nothing_keeps_no_wire_on() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let (mut reader, writer) = full_pipe();
        let program = std::path::Path::new(env!("CARGO_BIN_EXE_hil"));
        let scene = bench.scene(30.0);
        let run = bench.start_with(program, &Bench::run_words(&scene), Some(writer.into()));
        killed_while_the_bus_fails(bench, &run, || {});
        // Whoever reads at last learns what happened.
        let reading = std::thread::spawn(move || reader.read_to_end(&mut Vec::new()));
        let said = run.finish(END);
        assert!(bench.latched().contains("cause=the run died"), "{said:?}");
        reading.join().unwrap().unwrap();
    });
}

#[test]
fn a_disk_that_hangs_keeps_no_wire_on() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        killed_while_the_bus_fails(bench, &run, || {
            bench.scarce.disk_hangs.store(GUARDIAN, Ordering::Release);
        });
        bench.scarce.disk_hangs.store(0, Ordering::Release);
        let said = run.finish(END);
        assert!(bench.latched().contains("cause=the run died"), "{said:?}");
    });
}

#[test]
fn a_folder_of_stops_that_cannot_be_opened_keeps_no_wire_on() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        killed_while_the_bus_fails(bench, &run, || {
            bench.scarce.open_hangs.store(GUARDIAN, Ordering::Release);
        });
        bench.scarce.open_hangs.store(0, Ordering::Release);
        let said = run.finish(END);
        assert!(bench.latched().contains("cause=the run died"), "{said:?}");
    });
}

#[test]
fn two_adapters_are_off_where_no_thread_is_to_be_had() {
    on_bench(2, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        bench.scarce.threads.store(GUARDIAN, Ordering::Release);
        let at = run.kill();
        let said = run.finish(END);
        bench.assert_off_within(OFF_MS, at);
        assert!(bench.latched().contains("cause=the run died"), "{said:?}");
    });
}

#[test]
fn two_adapters_are_off_where_no_memory_is_to_be_had() {
    on_bench(2, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        bench.scarce.memory.store(GUARDIAN, Ordering::Release);
        let at = run.kill();
        is_soon(Duration::from_secs(1), || !bench.is_on());
        bench.assert_off_within(OFF_MS, at);
        bench.scarce.memory.store(0, Ordering::Release);
        let said = run.finish(END);
        assert!(bench.latched().contains("cause=the run died"), "{said:?}");
    });
}
