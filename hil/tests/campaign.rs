//! A campaign of bad input: every reader with every kind of bad file, every option with every kind of bad value, and
//! hostile surroundings. Each try states what it expects. None may crash, hang for ten seconds, take 256 MB, or pass in
//! silence.
//!
//! `PALPATE_CAMPAIGN=N` (`ci/soak`) adds N files with damage at random places per reader.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic)]
// It times another program, and waits for it.
#![allow(clippy::disallowed_methods)]

#[path = "campaign/files.rs"]
mod files;
#[path = "campaign/options.rs"]
mod options;
#[path = "campaign/surroundings.rs"]
mod surroundings;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// What a try may end in, as the table of exit statuses in `docs/files.md` has it.
#[derive(Clone, Debug, PartialEq)]
enum Expect {
    /// Status 2, one message that has this in it and says what was expected.
    Refused(String),
    /// Another status, with this on standard error or in the verdict.
    Ends(i32, &'static str),
    /// Status 0: what looks bad is good.
    Good,
    /// Any status of the table but that of a bug.
    Survived,
}

/// One call of the program.
#[derive(Clone, Debug)]
struct Try {
    args: Vec<String>,
    /// What a shell does around it: redirections.
    around: &'static str,
    expect: Expect,
}

impl Try {
    fn new(args: &[&str], expect: Expect) -> Self {
        Self {
            args: args.iter().map(|a| (*a).to_owned()).collect(),
            around: "",
            expect,
        }
    }

    fn around(self, around: &'static str) -> Self {
        Self { around, ..self }
    }

    fn refused(args: &[&str], by: &str) -> Self {
        Self::new(args, Expect::Refused(by.to_owned()))
    }
}

/// Most time and address space of a try; what is resident is less.
const LONGEST: Duration = Duration::from_secs(10);
const MOST_KIB: u64 = 256 << 10;

/// What is wrong with how a try ended; nothing where nothing is.
fn wrong(this: &Try, folder: &Path, number: usize) -> Option<String> {
    let stream = |name: &str| folder.join(format!(".{number}.{name}"));
    let (out, err) = (stream("out"), stream("err"));
    let line = format!("ulimit -v {MOST_KIB}; exec \"$0\" \"$@\" {}", this.around);
    let begun = Instant::now();
    let mut child = Command::new("sh")
        .args(["-c", &line, env!("CARGO_BIN_EXE_hil")])
        .args(&this.args)
        .current_dir(folder)
        .env("MALLOC_ARENA_MAX", "1")
        .env("RAYON_NUM_THREADS", "2")
        .env_remove("RUST_BACKTRACE")
        .stdin(Stdio::null())
        .stdout(File::create(&out).unwrap())
        .stderr(File::create(&err).unwrap())
        .spawn()
        .unwrap();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status.code();
        }
        if begun.elapsed() > LONGEST {
            child.kill().unwrap();
            child.wait().unwrap();
            return Some("it hangs".into());
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let read = |path: &PathBuf| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
    let (said, told) = (read(&out), read(&err));
    let _ = (fs::remove_file(out), fs::remove_file(err));
    let first = |text: &str| text.lines().take(3).collect::<Vec<_>>().join(" | ");
    let seen = format!("status {status:?}: {} {}", first(&told), first(&said));
    let crashed = status.is_none_or(|s| s == 101 || s > 128)
        || ["panicked", "overflowed its stack", "memory allocation"]
            .iter()
            .any(|word| told.contains(word));
    if crashed {
        return Some(format!("it crashes: {seen}"));
    }
    let good = match &this.expect {
        Expect::Refused(by) => {
            let tells = [
                "expected",
                "invalid",
                "cannot",
                "required",
                "unexpected",
                "unrecognized",
            ];
            status == Some(2)
                && told.contains(by.as_str())
                && told.contains("error: ")
                && tells.iter().any(|word| told.contains(word))
                && told.lines().all(|line| line.len() < 2000)
        }
        Expect::Ends(code, word) => {
            status == Some(*code) && (told.contains(word) || said.contains(word))
        }
        Expect::Good => status == Some(0),
        Expect::Survived => status.is_some_and(|s| s <= 4),
    };
    (!good).then_some(seen)
}

/// Makes tries on all cores; what went wrong, in their order.
fn make(tries: &[Try], folder: &Path) -> Vec<String> {
    let next = AtomicUsize::new(0);
    let workers = std::thread::available_parallelism().map_or(2, usize::from);
    let worker = || {
        let mut found = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(this) = tries.get(number) else {
                return found;
            };
            if let Some(what) = wrong(this, folder, number) {
                let call = format!("hil {} {}", this.args.join(" "), this.around);
                found.push((
                    number,
                    format!("{call}\n    wants {:?}\n    {what}", this.expect),
                ));
            }
        }
    };
    let mut found = std::thread::scope(|scope| {
        let started: Vec<_> = (0..workers).map(|_| scope.spawn(worker)).collect();
        let ended = started.into_iter().map(|w| w.join().unwrap());
        ended.flatten().collect::<Vec<_>>()
    });
    found.sort_unstable_by_key(|f| f.0);
    found.into_iter().map(|f| f.1).collect()
}

#[test]
fn no_bad_input_crashes_hangs_or_passes_in_silence() {
    let folder = std::env::temp_dir().join(format!("hil-campaign-{}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    files::prepare(&folder);
    let mut tries = files::tries(&folder);
    tries.extend(options::tries());
    tries.extend(surroundings::tries());
    assert!(tries.len() >= 600, "only {} tries", tries.len());
    let more = std::env::var("PALPATE_CAMPAIGN").ok();
    let more = more.map_or(0, |n| n.parse().unwrap());
    tries.extend(files::damaged(&folder, more));
    let wrong = make(&tries, &folder);
    let (count, bad) = (tries.len(), wrong.len());
    eprintln!("{count} tries, {bad} of them wrong");
    fs::remove_dir_all(&folder).unwrap();
    assert!(
        wrong.is_empty(),
        "{bad} of {count} tries:\n{}",
        wrong.join("\n")
    );
}
