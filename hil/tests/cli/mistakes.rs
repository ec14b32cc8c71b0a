//! Mistakes at the shell, each with what a colleague would say to it.

use super::*;

/// A line as it is typed behind `hil`, and parts of the answer.
type Mistake = (&'static str, &'static [&'static str]);

const COMMANDS: [Mistake; 11] = [
    ("rnu", &["a similar subcommand exists: 'run'"]),
    ("help rnu", &["a similar subcommand exists: 'run'"]),
    (
        "sphere-along",
        &["a scene is run by `hil run sphere-along`"],
    ),
    ("mine.toml", &["a scene is run by `hil run mine.toml`"]),
    ("simulate wearer", &["`hil study simulate` is a command"]),
    ("unlatch", &["`hil off --unlatch` is an option"]),
    ("--json", &["`hil run --json`"]),
    ("list scene", &["'scenes'"]),
    ("completions bsh", &["'bash'"]),
    ("man study rnu", &["a command (", "did you mean `run`?"]),
    ("off", &["--bench"]),
];

const OPTIONS: [Mistake; 18] = [
    ("run --soa-ms 120", &["there is `--set illusion.soa_ms=MS`"]),
    ("run -seed 5", &["long options have two hyphens: `--seed`"]),
    ("run --seed five", &["--seed", "expected a whole number"]),
    ("run --seeds 1..5", &["`hil sweep` has `--seeds`"]),
    (
        "run --report a.html",
        &["in place of `--report` there is `--html FILE`"],
    ),
    (
        "run --felt dull",
        &["in place of `--felt` there is `--person NAME`"],
    ),
    (
        "design --csv a.csv",
        &["in place of `--csv` there is `--out FILE`"],
    ),
    (
        "unit --listen 0.0.0.0",
        &["in place of `--listen` there is `--at ADDRESS`"],
    ),
    (
        "texture strokes folder",
        &["in place of `folder` there is `--out DIR`"],
    ),
    (
        "run --serve=99999",
        &["--serve", "expected a port from 0 to 65535, found 99999"],
    ),
    (
        "serve --at 127.0.0.1:99999",
        &["--at", "whose port is none from 0 to 65535"],
    ),
    (
        "run --can can0",
        &[
            "--can",
            "kind \"real\"",
            "hil new bench my-bench --can can0",
        ],
    ),
    ("run --bench emulatd", &["did you mean `emulated`?"]),
    (
        "run --illusion phantm",
        &["--illusion", "did you mean `phantom`?"],
    ),
    (
        "run sphere-along sphere-across",
        &["one scene at a time", "hil test"],
    ),
    ("run --record run.xyz", &["run.xyz", ".mcap (everything)"]),
    (
        "sweep sphere-along --seeds 5..1 --out r.csv",
        &["--seeds", "1..5"],
    ),
    (
        "sweep sphere-along --out r.txt",
        &["r.txt", ".csv or .jsonl"],
    ),
];

const KEYS: [Mistake; 7] = [
    ("run --set soa_ms=120", &["did you mean `illusion.soa_ms`?"]),
    ("run --set illusion.soa=120", &["did you mean `soa_ms`?"]),
    (
        "run --set drive.current_ma=900",
        &["did you mean `bench.drive`?"],
    ),
    (
        "run --set current_ma=900",
        &["did you mean `bench.drive.current_ma`?"],
    ),
    (
        "run --set bench.illusion.soa_ms=9",
        &["did you mean `illusion`?"],
    ),
    ("run --set length_s", &["--set", "expected KEY=VALUE"]),
    (
        "run --set length_s=1..5",
        &["one value", "hil sweep SCENE --set length_s=1..5"],
    ),
];

const PATHS: [Mistake; 14] = [
    ("run nope.toml", &["nope.toml", "no such file"]),
    ("run sphere-alng", &["did you mean `sphere-along`?"]),
    (
        "run taxels.csv",
        &["found CSV", "`hil run --replay taxels.csv`"],
    ),
    (
        "run --replay nope.csv",
        &["nope.csv", "no such file or folder"],
    ),
    (
        "run idle --out taxels.csv",
        &["taxels.csv", "expected a folder to write into"],
    ),
    ("test nowhere/", &["nowhere/", "no such file or folder"]),
    (
        "test two-finger-presss",
        &["did you mean `two-finger-press`?"],
    ),
    (
        "compare a.json nope.json",
        &["nope.json", "no such file or folder"],
    ),
    ("compare a.json", &["a second result"]),
    (
        "compare a.json empty",
        &["empty", "with summary.json in it"],
    ),
    ("diff empty a.json", &["empty", "schedule.jsonl"]),
    (
        "check sphere-along",
        &["a name of what is built in, which needs no check"],
    ),
    ("serve empty", &["empty", "--record empty/run.mcap"]),
    (
        "study analyse nowhere",
        &["nowhere", "found no such folder"],
    ),
];

/// Longest answer: half a screen of 80 columns.
const LONGEST: usize = 900;

#[test]
fn plausible_mistakes_get_the_answer_of_a_colleague() {
    let folder = Folder::new("mistakes");
    folder.write("taxels.csv", "txl1_x,txl1_y,txl1_z\n1,2,3\n");
    folder.write("a.json", "{\"verdict\": \"ok\", \"margins\": []}\n");
    fs::create_dir(folder.path("empty")).unwrap();
    let before = folder.names();
    let all = [&COMMANDS[..], &OPTIONS, &KEYS, &PATHS].concat();
    assert!(all.len() >= 30);
    for (line, answers) in all {
        let words: Vec<&str> = line.split(' ').collect();
        let said = hil_in(&folder.0, &words);
        assert_eq!(said.status, Some(2), "hil {line}: {}", said.err);
        assert_eq!(said.out, "", "hil {line}");
        for answer in answers {
            assert!(
                said.err.contains(answer),
                "hil {line}: {answer}: {}",
                said.err
            );
        }
        assert!(!said.err.contains("os error"), "hil {line}: {}", said.err);
        assert!(said.err.len() < LONGEST, "hil {line}: {}", said.err);
    }
    assert_eq!(folder.names(), before, "a mistake writes nothing");
}

/// What the system says comes without its numbers, whichever command quotes it.
#[test]
fn no_answer_has_a_number_of_the_system() {
    let folder = Folder::new("mistakes-system");
    for (line, answer) in [
        ("record a.log --can nocan0", "nocan0"),
        (
            "run idle --quiet --record no/such/folder.csv",
            "its folder is not there",
        ),
        (
            "run idle --quiet --record /dev/full/a.csv",
            "/dev/full/a.csv",
        ),
        ("emulate --can nocan0", "nocan0"),
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        let said = hil_in(&folder.0, &words);
        assert!(
            matches!(said.status, Some(2 | 3)),
            "hil {line}: {}",
            said.err
        );
        assert!(said.err.contains(answer), "hil {line}: {}", said.err);
        assert!(!said.err.contains("os error"), "hil {line}: {}", said.err);
    }
}
