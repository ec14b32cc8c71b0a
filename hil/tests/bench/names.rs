//! A stop and a lock are of hardware: another name, number, user, folder or version of it gets past neither.

use std::fs;
use std::io::Write;
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt, symlink};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::Duration;

use nix::libc;
use nix::sys::signal::Signal;
use nix::sys::socket::{AddressFamily, SockFlag, SockType, socketpair};
use palpate_tests::fake_bench::GUARDIAN;

use crate::rig::{Bench, on_bench};
use crate::run::Said;

/// What a program is given to end.
const END: Duration = Duration::from_secs(20);
/// How `setpriv` becomes a user who owns nothing.
pub const NOBODY: [&str; 3] = ["--reuid=65534", "--regid=65534", "--clear-groups"];

/// Leaves a stop: a run was killed in a burst.
fn stop(bench: &Bench) {
    let _feed = bench.feed();
    let run = bench.run(30.0);
    run.wait_for_burst();
    run.kill();
    let said = run.finish(END);
    assert!(bench.latched().contains("cause=the run died"), "{said:?}");
}

/// A run on an adapter by another name.
fn run_on(bench: &Bench, node: &Path) -> Said {
    let text = bench.text_on(&[node.to_owned()]);
    fs::write(bench.path("renamed.toml"), text).unwrap();
    let scene = bench.scene(1.0);
    let words = ["run", &scene, "--bench", "renamed.toml", "--quiet"];
    bench.start(&words).finish(END)
}

/// A run is refused for the stop that is latched.
#[track_caller]
fn assert_stopped(said: &Said) {
    assert_eq!(said.status, Some(4), "{said:?}");
    let words = "stopped earlier: the run died without a word";
    assert!(said.err.contains(words), "{said:?}");
}

/// Other names of a bench's first adapter.
fn names(bench: &Bench) -> [PathBuf; 3] {
    names_of(bench, 0)
}

/// Other names of an adapter: a dot in its path, a link to it, a link to its folder.
pub fn names_of(bench: &Bench, adapter: usize) -> [PathBuf; 3] {
    let name = format!("i2c-{adapter}");
    let [link, folder] = ["link", "folder"].map(|own| bench.path(&format!("{own}-to-{name}")));
    for (to, link) in [(bench.node(adapter), &link), (bench.path(""), &folder)] {
        if !link.is_symlink() {
            symlink(to, link).unwrap();
        }
    }
    [bench.path(".").join(&name), link, folder.join(&name)]
}

#[test]
fn a_stop_holds_by_every_name_of_an_adapter() {
    on_bench(1, |bench| {
        stop(bench);
        let names = names(bench);
        for name in &names {
            assert_stopped(&run_on(bench, name));
        }
        let link = names[1].display().to_string();
        let cleared = bench.off(&["--unlatch", "--i2c", &link]);
        assert_eq!(cleared.status, Some(0), "{cleared:?}");
        assert!(cleared.out.contains("the stop is cleared"), "{cleared:?}");
        let _feed = bench.feed();
        let said = bench.run(1.0).finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
    });
}

#[test]
fn a_stop_holds_for_an_adapter_that_comes_back_under_another_number() {
    on_bench(1, |bench| {
        stop(bench);
        bench.unplug(0);
        bench.plug(3, "port-0");
        assert_stopped(&run_on(bench, &bench.node(3)));
        // What is plugged in elsewhere is other hardware, also under the old number.
        bench.plug(0, "port-9");
        let said = run_on(bench, &bench.node(0));
        assert_ne!(said.status, Some(4), "{said:?}");
    });
}

#[test]
fn a_bus_has_one_program_by_every_name() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(120.0);
        run.wait_until_on();
        for name in names(bench) {
            let said = run_on(bench, &name);
            assert_eq!(said.status, Some(3), "{said:?}");
            assert!(said.err.contains("in use by"), "{said:?}");
        }
        run.signal(Signal::SIGINT);
        // It was undisturbed: a person ends it, with the status that docs/files.md says.
        let said = run.finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
    });
}

/// Whether a program may be another user's here; says why not.
pub fn has_other_user() -> bool {
    let hil = env!("CARGO_BIN_EXE_hil");
    let mut probe = Command::new("/usr/bin/setpriv");
    probe.args(NOBODY).args([hil, "--version"]);
    let probed = probe.stdout(Stdio::null()).stderr(Stdio::null()).status();
    let has = probed.is_ok_and(|status| status.success());
    if !has {
        eprintln!("SKIPPED: only root becomes another user, who has to reach {hil}");
    }
    has
}

#[test]
fn a_stop_holds_for_every_user() {
    on_bench(1, |bench| {
        if !has_other_user() {
            return;
        }
        let hil = env!("CARGO_BIN_EXE_hil");
        stop(bench);
        // Its skin is a socket of that folder.
        fs::set_permissions(bench.path(""), fs::Permissions::from_mode(0o777)).unwrap();
        let scene = bench.scene(1.0);
        let words = [&NOBODY[..], &[hil], &Bench::run_words(&scene)].concat();
        let other = bench.start_with(Path::new("/usr/bin/setpriv"), &words, None);
        assert_stopped(&other.finish(END));
    });
}

#[test]
fn a_folder_of_stops_that_cannot_be_had_refuses_with_the_line_that_makes_it() {
    on_bench(1, |bench| {
        let scene = bench.scene(1.0);
        let hil = Path::new(env!("CARGO_BIN_EXE_hil"));
        let mut command = bench.program(hil, &Bench::run_words(&scene));
        let said = command.env("PALPATE_STATE", "/proc/nope").output().unwrap();
        let err = String::from_utf8_lossy(&said.stderr);
        assert_eq!(said.status.code(), Some(3), "{err}");
        assert!(
            err.contains("`sudo install -d -m 1777 /proc/nope`"),
            "{err}"
        );
        assert!(bench.longest_on() <= 0.0, "it drove");
    });
}

#[test]
fn a_full_disk_refuses_a_run_and_leaves_no_stop() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let (errno, fails) = (&bench.scarce.disk_errno, &bench.scarce.disk_fails);
        errno.store(libc::ENOSPC as u32, Ordering::Release);
        for _ in 0..2 {
            fails.store(GUARDIAN, Ordering::Release);
            let on = bench.longest_on();
            let said = bench.run(1.0).finish(END);
            assert_eq!(said.status, Some(3), "{said:?}");
            assert!(said.err.contains("No space left"), "{said:?}");
            assert!(bench.longest_on() <= on, "it drove");
            // The second time the record is there already.
            fails.store(0, Ordering::Release);
            let said = bench.run(1.0).finish(END);
            assert_eq!(said.status, Some(0), "{said:?}");
        }
    });
}

#[test]
fn a_newer_version_s_record_and_lock_are_refused_and_left_alone() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let said = bench.run(1.0).finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
        let (record, own) = bench.records().pop().unwrap();
        let newer = own.replace("palpate-stop 1\n", "palpate-stop 2\n");
        assert_ne!(own, newer);
        fs::write(&record, &newer).unwrap();
        let said = bench.run(1.0).finish(END);
        assert_eq!(said.status, Some(4), "{said:?}");
        assert!(said.err.contains("newer version"), "{said:?}");
        let off = bench.off(&["--unlatch", "--bench", "bench.toml"]);
        assert_eq!(off.status, Some(3), "{off:?}");
        assert_eq!(fs::read_to_string(&record).unwrap(), newer);
        fs::write(&record, own).unwrap();
        let lock = bench.locks().pop().unwrap();
        let held = fs::read_to_string(&lock).unwrap();
        let newer = held.replace("palpate-lock 1\n", "palpate-lock 2\n");
        assert_ne!(held, newer);
        fs::write(&lock, &newer).unwrap();
        let said = bench.run(1.0).finish(END);
        assert_eq!(said.status, Some(3), "{said:?}");
        assert!(said.err.contains("newer version"), "{said:?}");
        assert_eq!(fs::read_to_string(&lock).unwrap(), newer);
    });
}

#[test]
fn a_disk_that_hangs_holds_up_no_run_that_is_over() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_until_on();
        bench.scarce.disk_hangs.store(GUARDIAN, Ordering::Release);
        run.signal(Signal::SIGINT);
        assert!(run.ends_within(END), "it waits for its guardian's disk");
        bench.scarce.disk_hangs.store(0, Ordering::Release);
        let said = run.finish(END);
        assert_eq!(bench.latched(), "", "{said:?}");
    });
}

#[test]
fn a_record_that_nobody_reads_ends_with_the_run() {
    on_bench(1, |bench| {
        let pipe = bench.path("skin.log");
        nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).unwrap();
        let mut options = fs::OpenOptions::new();
        let options = options.read(true).custom_flags(libc::O_NONBLOCK);
        let reader = options.open(&pipe).unwrap();
        let _feed = bench.feed();
        let scene = bench.scene(3.0);
        let words = Bench::run_words(&scene);
        let words = [&words[..], &["--record", "skin.log"]].concat();
        let said = bench.start(&words).finish(END);
        assert_eq!(said.status, Some(3), "{said:?}");
        assert!(said.err.contains("nobody has read it"), "{said:?}");
        assert_eq!(bench.latched(), "");
        drop(reader);
    });
}

/// A guardian whose standard input is this, in a shell; what the shell says after it.
fn typed(stdin: Stdio) -> String {
    let hil = env!("CARGO_BIN_EXE_hil");
    let line = format!("{hil} guardian --heartbeat-ms 30 --transfer-ms 30; echo $?, alive");
    let mut shell = Command::new("sh");
    shell.args(["-c", &line]).stdin(stdin).process_group(0);
    let said = shell.output().unwrap();
    String::from_utf8_lossy(&said.stdout).into_owned()
}

#[test]
fn a_guardian_that_is_typed_kills_no_shell() {
    assert_eq!(typed(Stdio::null()), "3, alive\n");
    // Nor one whose input is another program's socket.
    let (kind, flags) = (SockType::SeqPacket, SockFlag::SOCK_CLOEXEC);
    let (ours, theirs) = socketpair(AddressFamily::Unix, kind, None, flags).unwrap();
    let mut ours = fs::File::from(ours);
    let _ = ours.write(b".");
    drop(ours);
    assert_eq!(typed(Stdio::from(theirs)), "3, alive\n");
}
