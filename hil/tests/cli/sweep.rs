//! `hil sweep`: the table is the same bytes, whichever processes computed its rows and however often they were interrupted.

use std::io::Read;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::*;

/// Twelve short runs.
const GRID: [&str; 8] = [
    "sweep",
    "sphere-along",
    "--set",
    "length_s=2",
    "--set",
    "illusion.soa_ms=100,117,130",
    "--seeds",
    "1..4",
];

/// The grid with more options, in a folder.
fn sweep(folder: &Folder, more: &[&str]) -> Said {
    hil_in(&folder.0, &[&GRID[..], more].concat())
}

fn rows(text: &str) -> usize {
    text.lines()
        .filter(|line| !line.starts_with("scene,"))
        .count()
}

#[test]
fn the_table_is_the_same_bytes_however_it_was_computed() {
    let folder = Folder::new("sweep");
    for form in ["csv", "jsonl"] {
        let name = |stem: &str| format!("{stem}.{form}");
        let one = sweep(&folder, &["--out", &name("one"), "--jobs", "1"]);
        assert_eq!((one.status, one.err.as_str()), (Some(0), ""), "{}", one.out);
        assert!(
            one.out.starts_with(
                "OK\nsphere-along on emulated (emulated): 12 runs; least to most, and where\n"
            ),
            "{}",
            one.out
        );
        let whole = folder.text(&name("one"));
        assert_eq!(rows(&whole), 12);
        assert_eq!(
            sweep(&folder, &["--out", &name("four"), "--jobs", "4", "--quiet"]).status,
            Some(0)
        );
        assert_eq!(folder.text(&name("four")), whole);

        // Cut amid a line, as a power cut leaves it: five rows stay.
        let lines: Vec<&str> = whole.split_inclusive('\n').collect();
        let kept = lines.len() - 7;
        let torn = lines[..kept].concat() + &lines[kept][..20];
        folder.write(&name("torn"), &torn);
        let again = sweep(&folder, &["--out", &name("torn")]);
        assert!(
            again.out.contains("12 runs, 5 of them in the table before"),
            "{}",
            again.out
        );
        assert_eq!(folder.text(&name("torn")), whole);

        // Parts, joined in the wrong order with a heading in the midst.
        let mut joined = String::new();
        for part in ["3/3", "1/3", "2/3"] {
            let file = name(&part.replace('/', "of"));
            let said = sweep(&folder, &["--out", &file, "--part", part, "--json"]);
            let said: Value = serde_json::from_str(&said.out).unwrap();
            assert_eq!(
                (&said["verdict"], &said["rows"]),
                (&"ok".into(), &4.into()),
                "{said}"
            );
            joined += &folder.text(&file);
        }
        folder.write(&name("joined"), &joined);
        let all = sweep(&folder, &["--out", &name("joined"), "--json"]);
        let all: Value = serde_json::from_str(&all.out).unwrap();
        assert_eq!(all["there_before"], 12, "{all}");
        assert_eq!(folder.text(&name("joined")), whole);
    }
}

#[test]
fn a_row_is_the_run_that_hil_run_shows() {
    let folder = Folder::new("sweep-row");
    assert_eq!(sweep(&folder, &["--out", "t.jsonl"]).status, Some(0));
    let text = folder.text("t.jsonl");
    let row: Value = serde_json::from_str(text.lines().nth(6).unwrap()).unwrap();
    assert_eq!(
        (&row["set"]["illusion.soa_ms"], &row["seed"]),
        (&"117".into(), &3.into()),
        "{row}"
    );
    let run = good(&[
        "run",
        "sphere-along",
        "--set",
        "length_s=2",
        "--set",
        "illusion.soa_ms=117",
        "--seed",
        "3",
        "--json",
    ]);
    let run: Value = serde_json::from_str(&run).unwrap();
    for (of_row, of_run) in [
        (&row["path_error_rmse_mm"], &run["path_error_mm"]["rmse"]),
        (&row["felt_error_max_mm"], &run["felt_error_mm"]["max"]),
        (&row["hottest_skin_c"], &run["hottest_skin_c"]),
        (&row["stimuli"], &run["stimuli"]),
    ] {
        let (a, b) = (of_row.as_f64().unwrap(), of_run.as_f64().unwrap());
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn what_cannot_be_is_said_before_anything_runs() {
    let folder = Folder::new("sweep-bad");
    let table = folder.path("t.csv").display().to_string();
    let scene = |more: &[&str]| {
        let args = ["sweep", "idle", "--out", &table]
            .into_iter()
            .chain(more.iter().copied());
        args.map(str::to_owned).collect::<Vec<_>>()
    };
    for (more, words) in [
        (
            &["--set", "illusion.shap=1,2"][..],
            &["illusion.shap", "did you mean `shape`"][..],
        ),
        (
            &["--set", "bench.drive.curent_ma=1"],
            &["did you mean `current_ma`"],
        ),
        (
            &["--set", "length_s=1,0"],
            &["--set: length_s: expected a number from"],
        ),
        (
            &["--set", "length_s=2", "--set", "length_s=2"],
            &["each once", "length_s"],
        ),
        (
            &["--set", "illusion.soa_ms=117,117.0"],
            &["each once", "117 as 117.0"],
        ),
        (&["--set", "length_s"], &["KEY=VALUE,VALUE"]),
        (&["--seeds", "4..1"], &["--seeds", "1..4"]),
        (&["--seeds", "1..4,2"], &["each once", "2 again"]),
        (&["--part", "3/2"], &["--part", "K/N"]),
        (&["--set", "bench.kind=real"], &["real"]),
    ] {
        refused_with(&scene(more), words);
    }
    refused_with(
        &["sweep", "idle", "--out", "t.txt"],
        &["t.txt", ".csv or .jsonl"],
    );
    assert_eq!(folder.names(), [""; 0]);

    // Another program's table stays, and so do rows of another sweep.
    folder.write("t.csv", "a,b\n1,2\n");
    refused_with(&scene(&[]), &["t.csv", "another program's", "--force"]);
    good(&scene(&["--force", "--set", "length_s=1,2"]));
    let before = folder.text("t.csv");
    refused_with(
        &scene(&["--set", "length_s=2"]),
        &["1 of 2 rows of another", "--force"],
    );
    assert_eq!(folder.text("t.csv"), before);
    good(&scene(&["--set", "length_s=1,2", "--seeds", "1,2"]));
    assert_eq!(rows(&folder.text("t.csv")), 4);
    // Two rows of one key that contradict one another name both lines.
    let text = folder.text("t.csv");
    let row = text.lines().nth(2).unwrap();
    let (rest, rate) = row.rsplit_once(',').unwrap();
    folder.write("t.csv", &format!("{text}{rest},1{rate}\n"));
    refused_with(
        &scene(&["--set", "length_s=1,2", "--seeds", "1,2"]),
        &["t.csv:6: expected what line 3 says at length_s=1, seed 2"],
    );
    folder.write("t.csv", &text);
    good(&scene(&["--force", "--set", "length_s=2"]));
    assert_eq!(rows(&folder.text("t.csv")), 1);
}

#[test]
fn a_run_beyond_a_limit_is_a_row_and_the_verdict() {
    let folder = Folder::new("sweep-limit");
    let out = folder.path("t.csv").display().to_string();
    let said = hil(&[
        "sweep",
        "stuck-amplifier",
        "--set",
        "faults=[],[{ kind = \"amplifier-stuck-on\", wire = 0, at_s = 1.0 }]",
        "--out",
        &out,
    ]);
    assert_eq!(said.status, Some(1), "{}{}", said.out, said.err);
    assert!(
        said.out
            .starts_with("BEYOND THE MODEL: 1 of 2 runs, first at faults=[{ kind"),
        "{}",
        said.out
    );
    assert_eq!(rows(&folder.text("t.csv")), 2);
}

/// Interrupts a program once `ready` says so, and waits for it.
#[allow(clippy::disallowed_methods)] // another process: it says by what it does how far it is
pub fn interrupted(mut child: std::process::Child, ready: impl Fn() -> bool) -> Said {
    let begun = Instant::now();
    while !ready() {
        assert!(begun.elapsed() < Duration::from_secs(60), "it never began");
        assert!(child.try_wait().unwrap().is_none(), "it ended too early");
        std::thread::sleep(Duration::from_millis(2));
    }
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
    let (mut out, mut err) = (String::new(), String::new());
    child
        .stdout
        .take()
        .unwrap()
        .read_to_string(&mut out)
        .unwrap();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut err)
        .unwrap();
    Said {
        status: child.wait().unwrap().code(),
        out,
        err,
    }
}

#[test]
fn an_interrupted_sweep_keeps_its_rows_and_goes_on() {
    let folder = Folder::new("sweep-int");
    let args = [
        "sweep",
        "sphere-along",
        "--set",
        "length_s=20",
        "--seeds",
        "1..300",
        "--jobs",
        "1",
        "--out",
        "t.csv",
    ];
    let child = command(&args, &folder.0)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let said = interrupted(child, || {
        fs::read_to_string(folder.path("t.csv")).is_ok_and(|t| rows(&t) > 3)
    });
    assert_eq!(said.status, Some(130), "{}{}", said.out, said.err);
    assert!(said.out.starts_with("STOPPED: by SIGINT: "), "{}", said.out);
    assert_eq!(folder.names(), ["t.csv"]);
    let kept = folder.text("t.csv");
    assert!((4..300).contains(&rows(&kept)) && kept.ends_with('\n'));
    // The same grid goes on with them; a part that is there already has nothing to do.
    let again = hil_in(&folder.0, &[&args[..], &["--part", "1/300"]].concat());
    assert_eq!(again.status, Some(0), "{}", again.err);
    assert!(
        again.out.contains("1 run, 1 of them in the table before"),
        "{}",
        again.out
    );
    assert_eq!(folder.text("t.csv"), kept);
}

#[test]
fn seeds_and_values_take_ranges_alike() {
    let folder = Folder::new("sweep-ranges");
    let table = |set: &str, seeds: &str, out: &str| {
        let args = [
            "sweep", "idle", "-q", "-s", set, "--seeds", seeds, "-o", out,
        ];
        let said = hil_in(&folder.0, &args);
        assert_eq!(said.status, Some(0), "{}", said.err);
        folder.text(out)
    };
    let ranges = table("length_s=2..3:0.5", "1..5:2", "a.csv");
    let lists = table("length_s=2,2.5,3", "1,3,5", "b.csv");
    assert_eq!(ranges, lists);
    assert_eq!(ranges.lines().count(), 1 + 9);
}
