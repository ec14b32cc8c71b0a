//! A signal at any time leaves whole files or none, and long work shows itself on a terminal alone.

use super::sweep::interrupted;
use super::*;

fn started(args: &[&str], folder: &Folder) -> std::process::Child {
    let mut command = command(args, &folder.0);
    command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Whether something is half-written.
fn half(folder: &Path) -> bool {
    let mut names = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|e| e.file_name());
    names.any(|name| name.to_string_lossy().ends_with(".partial"))
}

#[test]
fn a_run_that_is_interrupted_while_it_writes_leaves_nothing() {
    let folder = Folder::new("int-run");
    let args = [
        "run",
        "sphere-along",
        "--set",
        "length_s=300",
        "--record",
        "a.mcap",
        "--record",
        "b.vcd",
    ];
    let said = interrupted(started(&args, &folder), || half(&folder.0));
    assert_eq!(said.status, Some(130), "{}{}", said.out, said.err);
    assert!(
        folder.names().iter().all(|name| name == "a.mcap"),
        "{:?}",
        folder.names()
    );
    // What was there before stays.
    let folder = Folder::new("int-run-before");
    good(&[
        "run",
        "idle",
        "--record",
        &folder.path("a.mcap").display().to_string(),
    ]);
    let before = fs::read(folder.path("a.mcap")).unwrap();
    let said = interrupted(started(&args, &folder), || half(&folder.0));
    assert_eq!(said.status, Some(130));
    if folder.names() == ["a.mcap"] {
        let now = fs::read(folder.path("a.mcap")).unwrap();
        assert!(now == before || now.len() > 10 * before.len());
    }
    assert!(!half(&folder.0));
}

#[test]
fn contacts_that_are_interrupted_while_they_are_written_leave_nothing() {
    let folder = Folder::new("int-contacts");
    // More than are held: the recording is read again while the table is written.
    let file = contacts::recording(&folder, 90_000);
    let args = [
        "contacts",
        &file,
        "--layout",
        "uskin-4x4",
        "--rate",
        "40",
        "--out",
        "out",
    ];
    let said = interrupted(started(&args, &folder), || half(&folder.path("out")));
    assert_eq!(said.status, Some(130), "{}", said.err);
    let left: Vec<_> = fs::read_dir(folder.path("out")).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn long_work_shows_itself_on_a_terminal_and_nowhere_else() {
    let folder = Folder::new("progress");
    let sweep = "sweep sphere-along --set length_s=60 --seeds 1..400 --jobs 1 --out";
    // `script` gives a program a terminal; without it there is nothing to see here.
    if Command::new("script").arg("--version").output().is_err() {
        return;
    }
    let on_terminal = |name: &str, before: &str| {
        let hil = env!("CARGO_BIN_EXE_hil");
        let line =
            format!("{before} TERM=xterm timeout --foreground -s INT 8 {hil} {sweep} {name}.csv");
        let mut script = Command::new("script");
        let script = script
            .args(["-qec", &line, "/dev/null"])
            .current_dir(&folder.0)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut script = script.spawn().unwrap();
        // It may end with its input, so that stays open.
        let input = script.stdin.take();
        let shown = script.wait_with_output().unwrap().stdout;
        drop(input);
        String::from_utf8_lossy(&shown).into_owned()
    };
    let shown = on_terminal("shown", "env -u CI");
    assert!(
        shown.contains("sweep [") && shown.contains("of 400 runs, "),
        "{shown}"
    );
    assert!(shown.contains("STOPPED: by SIGINT"), "{shown}");
    let logged = on_terminal("logged", "env CI=true");
    assert!(!logged.contains("sweep ["), "{logged}");
    // In the foreground `timeout` sends one signal, else two, and a second one is obeyed at once, without a word.
    let mut piped = Command::new("timeout");
    piped
        .args(["--foreground", "-s", "INT", "8"])
        .arg(env!("CARGO_BIN_EXE_hil"))
        .args(sweep.split(' '))
        .arg("piped.csv");
    let piped = piped.current_dir(&folder.0).output().unwrap();
    let said = String::from_utf8_lossy(&piped.stderr).into_owned();
    assert!(
        said.starts_with("error: STOPPED: by SIGINT") && said.lines().count() == 1,
        "{said}"
    );
}
