//! Every `hil` command in the documents: its options exist, and what needs no hardware is run, page by page in an
//! empty folder, from top to bottom.

use clap::Parser;
use palpate_hil::cli::Cli;

use super::*;

/// One thing a page asks a reader to do.
#[derive(Debug)]
enum Step {
    /// A file with this name and text.
    File(String, String),
    /// A command, its line in the page, and the exit status it announces (`# exits 1`).
    Command(String, usize, i32),
}

/// Commands and files of a page: fenced blocks of `sh` and `text`-free indented ones; a TOML block under a line that
/// names a file in backquotes and ends with a colon is that file.
fn steps(page: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut before = "";
    let mut fence: Option<(&str, String)> = None;
    for (index, line) in page.lines().enumerate() {
        if let Some(tag) = line.strip_prefix("```") {
            fence = match fence.take() {
                None => Some((tag, String::new())),
                Some((tag, text)) => {
                    let name = before.strip_suffix("`:").and_then(|l| l.rsplit('`').next());
                    if let ("toml", Some(name)) = (tag, name) {
                        steps.push(Step::File(name.to_owned(), text));
                    }
                    None
                }
            };
            continue;
        }
        let command = match &mut fence {
            Some((tag, text)) => {
                text.push_str(line);
                text.push('\n');
                if *tag == "sh" { Some(line) } else { None }
            }
            None => line.strip_prefix("    "),
        };
        if fence.is_none() && !line.is_empty() {
            before = line;
        }
        let Some(command) = command else { continue };
        let command = command.trim().replace("cargo run --release -- ", "hil ");
        if !command.starts_with("hil ") {
            continue;
        }
        let (command, comment) = command.split_once(" #").unwrap_or((&command, ""));
        let status = comment.split("exits ").nth(1).and_then(|n| n.get(..1));
        let status = status.map_or(0, |n| n.parse().unwrap());
        // The `hil` itself is no argument.
        steps.push(Step::Command(command.trim().to_owned(), index + 1, status));
    }
    steps
}

/// Why a command is not run: what it needs.
fn needs(command: &str) -> Option<&'static str> {
    let words: Vec<&str> = command.split_whitespace().collect();
    let has = |w: &str| words.contains(&w);
    if has("--can") || has("--i2c") || command.contains("/dev/") {
        Some("devices")
    } else if command.contains("my-bench.toml") || has("FILE") {
        Some("a bench of one's own")
    } else if has("--recordings") || command.contains(".npy") {
        Some("recordings of real sensors")
    } else if command.contains(" both/") {
        Some("what two machines recorded")
    } else if has("--stream") || has("--unit") {
        Some("another machine")
    } else if command.starts_with("hil unit --key") {
        Some("an end by a person")
    } else if has("emulate") || has("off") || has("record") || has("replay") {
        Some("device nodes")
    } else if has("--serve") || has("serve") {
        Some("a browser, and an end by a person")
    } else if command.starts_with("hil study run") && !has("--simulated") && !has("--dose") {
        Some("a participant")
    } else if has("--watch") {
        Some("a terminal")
    } else {
        None
    }
}

/// What a command line says in a folder, with `hil` on its path.
pub fn shell(command: &str, folder: &Folder) -> Said {
    let (program, path) = (env!("CARGO_BIN_EXE_hil"), std::env::var("PATH").unwrap());
    let bin = Path::new(program).parent().unwrap().display();
    let mut shell = Command::new("sh");
    shell.args(["-c", command]).current_dir(&folder.0);
    shell
        .env("PATH", format!("{bin}:{path}"))
        .stdin(Stdio::null());
    Said::from(shell.output().unwrap())
}

/// Pages that a reader finds, in a fixed order.
pub fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut pages = vec![root.join("README.md")];
    for folder in ["docs", "docs/files", "docs/howto", "docs/start"] {
        let entries = fs::read_dir(root.join(folder)).unwrap();
        let paths = entries.map(|e| e.unwrap().path());
        pages.extend(paths.filter(|p| p.extension().is_some_and(|e| e == "md")));
    }
    pages.sort();
    pages
}

#[test]
fn every_command_parses_and_every_one_that_can_runs() {
    let mut ran = 0;
    for page in pages() {
        let name = page.file_stem().unwrap().to_string_lossy().into_owned();
        let folder = Folder::new(&format!("docs-{name}"));
        // Stand-ins for what a reader has: a recording, a scene of the playground, and where goldens lie.
        let recording = contacts::recording(&folder, 200);
        let text = fs::read_to_string(&recording).unwrap();
        folder.write("taxels.csv", &text);
        folder.write("meta_data.csv", "frequency_hz\n41.3\n");
        let by_hand = palpate_fixtures::scene("by-hand").unwrap();
        folder.write("touched.toml", by_hand);
        fs::create_dir_all(folder.path("fixtures/goldens")).unwrap();
        for step in steps(&fs::read_to_string(&page).unwrap()) {
            let (command, line, status) = match step {
                Step::File(name, text) => {
                    let path = folder.write(&name, &text).display().to_string();
                    if name.contains("bench") {
                        let read = palpate_files::load_bench(&path);
                        assert!(read.is_ok(), "{}: {}", page.display(), read.unwrap_err());
                    }
                    continue;
                }
                Step::Command(command, line, status) => (command, line, status),
            };
            let at = format!("{}:{line}: {command}", page.display());
            let plain = command.split(['|', '>', '&', ';']).next().unwrap();
            let words = plain
                .split_whitespace()
                .filter(|w| !["[FAMILY]"].contains(w));
            if needs(&command) != Some("the feature `bench`")
                && let Err(e) = Cli::try_parse_from(words)
                && e.use_stderr()
            // help is no error
            {
                panic!("{at}: {e}");
            }
            if needs(&command).is_some() {
                continue;
            }
            let said = shell(&command, &folder);
            assert_eq!(said.status, Some(status), "{at}\n{}{}", said.out, said.err);
            ran += 1;
        }
    }
    assert!(ran >= 15, "only {ran} commands ran");
}
