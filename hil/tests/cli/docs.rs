//! Every `hil` command in the documents: its options exist, and what needs no hardware is run, page by page in an
//! empty folder, from top to bottom. What a page shows of its output is what it prints.
//!
//! A page shows output in a `console` block, under `$ ` and the command, or in a `text` block after the command's `sh` block.
//! A table between `<!-- $ COMMAND -->` and `<!-- end -->` is what a command prints as Markdown.
//! `PALPATE_WRITE_FIGURES=1` writes today's figures into the pages. Such a table and a `console slow` block have commands
//! that take minutes: `PALPATE_FIGURES=all` runs them too.

use clap::Parser;
use palpate_hil::cli::Cli;

use super::figures::Shown;
use super::*;

/// One thing a page asks a reader to do, or shows.
enum Step {
    /// A file with this name and text.
    File(String, String),
    /// A command, its line in the page, and the exit status it announces (`# exits 1`): any in a `console` block.
    Command(String, usize, Option<i32>),
    /// Lines that a command prints.
    Shown(Shown),
    /// A heading: output under it is that of commands under it.
    Section,
}

/// A command of a page: its comment tells its status.
fn command(line: &str, number: usize) -> Option<Step> {
    let line = line.trim().replace("cargo run --release -- ", "hil ");
    if !["hil ", "palpate-bench ", "for "]
        .iter()
        .any(|program| line.starts_with(program))
    {
        return None;
    }
    let (command, comment) = line.split_once(" #").unwrap_or((&line, ""));
    let status = comment.split("exits ").nth(1).and_then(|n| n.get(..1));
    let status = status.map_or(0, |n| n.parse().unwrap());
    Some(Step::Command(
        command.trim().to_owned(),
        number,
        Some(status),
    ))
}

/// The steps of a fenced block; `before` is the line above it, and `is_after` tells that the section has a command above.
fn block(
    tag: &str,
    (first, indent, lines): (usize, usize, &[&str]),
    before: &str,
    is_after: bool,
) -> Vec<Step> {
    let shown = |from: usize, lines: &[&str]| {
        let lines = lines.iter().map(|line| (*line).to_owned()).collect();
        Step::Shown(Shown {
            first: first + from,
            lines,
            indent,
            is_part: tag == "text",
        })
    };
    let all_slow = std::env::var_os("PALPATE_FIGURES").is_some();
    match tag {
        "sh" => {
            let numbered = (first + 1..).zip(lines);
            numbered
                .filter_map(|(number, line)| command(line, number))
                .collect()
        }
        "toml" => {
            let name = before.strip_suffix("`:").and_then(|l| l.rsplit('`').next());
            let text = || lines.iter().map(|line| format!("{line}\n")).collect();
            name.map(|name| Step::File(name.to_owned(), text()))
                .into_iter()
                .collect()
        }
        "text" if is_after => vec![shown(0, lines)],
        "console" | "console slow" if all_slow || tag == "console" => {
            let begins = |index: &usize| lines[*index].starts_with("$ ");
            let starts: Vec<usize> = (0..lines.len()).filter(begins).collect();
            let mut steps = Vec::new();
            for (index, start) in starts.iter().enumerate() {
                let end = starts.get(index + 1).copied().unwrap_or(lines.len());
                let line =
                    lines[*start][2..].replace("cargo run --release", "hil run sphere-along");
                steps.extend(command(&line, first + start + 1).map(|step| match step {
                    Step::Command(command, number, _) => Step::Command(command, number, None),
                    step => step,
                }));
                steps.push(shown(start + 1, &lines[start + 1..end]));
            }
            steps
        }
        _ => Vec::new(),
    }
}

/// Commands, files and shown output of a page: fenced blocks, and commands of indented lines. A TOML block under a line
/// that names a file in backquotes and ends with a colon is that file.
fn steps(page: &str) -> Vec<Step> {
    let lines: Vec<&str> = page.lines().collect();
    let (mut steps, mut before, mut is_after) = (Vec::new(), "", false);
    let mut index = 0;
    while index < lines.len() {
        let line = lines[index];
        let indent = line.len() - line.trim_start().len();
        index += 1;
        if let Some(tag) = line.trim_start().strip_prefix("```") {
            let rest = &lines[index..];
            let length = rest
                .iter()
                .position(|line| line.trim_start().starts_with("```"));
            let length = length.unwrap_or(rest.len());
            let inner: Vec<&str> = rest[..length]
                .iter()
                .map(|l| l.get(indent..).unwrap_or(""))
                .collect();
            let found = block(tag, (index, indent, &inner), before, is_after);
            is_after |= found.iter().any(|step| matches!(step, Step::Command(..)));
            steps.extend(found);
            index += length + 1;
            continue;
        }
        if let Some(program) = line.strip_prefix("<!-- $ ") {
            let length = lines[index..]
                .iter()
                .position(|line| *line == "<!-- end -->");
            let length = length.expect("a table of a command ends with `<!-- end -->`");
            let program = format!("$ {}", program.trim_end_matches(" -->"));
            let inner = [&[program.as_str()], &lines[index..index + length]].concat();
            let found = block("console slow", (index - 1, 0, &inner), before, false);
            steps.extend(found.into_iter().map(|step| match step {
                Step::Shown(shown) => Step::Shown(Shown {
                    is_part: true,
                    ..shown
                }),
                step => step,
            }));
            index += length;
            continue;
        }
        if let Some(found) = line
            .strip_prefix("    ")
            .and_then(|line| command(line, index))
        {
            steps.push(found);
        }
        if line.starts_with('#') {
            is_after = false;
            steps.push(Step::Section);
        }
        if !line.is_empty() {
            before = line;
        }
    }
    steps
}

/// Why a command is not run: what it needs.
fn needs(command: &str) -> Option<&'static str> {
    let words: Vec<&str> = command.split_whitespace().collect();
    let has = |w: &str| words.contains(&w);
    let is_long = command.starts_with("palpate-bench") || command.starts_with("for ");
    if is_long && std::env::var_os("PALPATE_FIGURES").is_none() {
        Some("minutes")
    } else if has("--can") || has("--i2c") || command.contains("/dev/") {
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
    } else if has("--foxglove") {
        Some("Foxglove")
    } else if command.starts_with("hil study run") && !has("--simulated") && !has("--dose") {
        Some("a participant")
    } else if has("doctor") {
        Some("the reader's machine")
    } else if has("--watch") {
        Some("a terminal")
    } else {
        None
    }
}

/// Output of a command line in a folder, with `hil` on its path.
pub fn shell(command: &str, folder: &Folder) -> Said {
    let (program, path) = (env!("CARGO_BIN_EXE_hil"), std::env::var("PATH").unwrap());
    let bin = Path::new(program).parent().unwrap().display();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let bench = format!(
        "cargo run --quiet --release --locked --manifest-path {}/Cargo.toml -p palpate-bench --",
        root.display()
    );
    let command = command.replace("palpate-bench", &bench);
    let command = command.replace("ci/peers/", &format!("{}/ci/peers/", root.display()));
    let mut shell = Command::new("sh");
    shell.args(["-c", &command]).current_dir(&folder.0);
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

/// Most lines of an output in a failure's message.
const PRINTED: usize = 40;

/// A page while its steps are taken.
struct Walk<'a> {
    page: &'a Path,
    folder: Folder,
    /// Lines of the page, with today's figures.
    lines: Vec<String>,
    /// Lines that each command of the section printed; `None` where it was not run.
    outputs: Vec<Option<Vec<String>>>,
    ran: usize,
    /// Blocks that show something else than what is printed.
    stale: Vec<String>,
}

impl<'a> Walk<'a> {
    fn new(page: &'a Path, text: &str) -> Self {
        let name = page.file_stem().unwrap().to_string_lossy().into_owned();
        let folder = Folder::new(&format!("docs-{name}"));
        // Stand-ins for what a reader has: a recording, a trace, a scene of the playground, and where goldens lie.
        let recording = contacts::recording(&folder, 200);
        folder.write("taxels.csv", &fs::read_to_string(&recording).unwrap());
        folder.write("meta_data.csv", "frequency_hz\n41.3\n");
        let trace = include_str!("../../../fixtures/traces/hidden.csv");
        folder.write("hidden.csv", trace);
        let by_hand = palpate_fixtures::scene("by-hand").unwrap();
        folder.write("touched.toml", by_hand);
        fs::create_dir_all(folder.path("fixtures/goldens")).unwrap();
        let lines = text.lines().map(str::to_owned).collect();
        Self {
            page,
            folder,
            lines,
            outputs: Vec::new(),
            ran: 0,
            stale: Vec::new(),
        }
    }

    fn take(&mut self, step: Step) {
        match step {
            Step::File(name, text) => {
                let path = self.folder.write(&name, &text).display().to_string();
                if name.contains("bench") {
                    let read = palpate_files::load_bench(&path);
                    assert!(
                        read.is_ok(),
                        "{}: {}",
                        self.page.display(),
                        read.unwrap_err()
                    );
                }
            }
            Step::Command(command, line, status) => self.run(&command, line, status),
            Step::Shown(shown) => self.compare(&shown),
            Step::Section => self.outputs.clear(),
        }
    }

    fn run(&mut self, command: &str, line: usize, status: Option<i32>) {
        let at = format!("{}:{line}: {command}", self.page.display());
        let plain = command.split(['|', '>', '&', ';']).next().unwrap();
        let words = plain
            .split_whitespace()
            .filter(|w| !["[FAMILY]"].contains(w));
        let is_hil = command.starts_with("hil ");
        if is_hil
            && let Err(e) = Cli::try_parse_from(words)
            && e.use_stderr()
        // help is no error
        {
            panic!("{at}: {e}");
        }
        self.outputs.push(None);
        if needs(command).is_none() {
            let said = shell(command, &self.folder);
            let is_status = status.is_none_or(|status| said.status == Some(status));
            assert!(
                is_status,
                "{at}: {:?}\n{}{}",
                said.status, said.out, said.err
            );
            let printed = if said.out.is_empty() {
                said.err
            } else {
                said.out
            };
            let printed = printed.lines().map(|line| line.trim_end().to_owned());
            self.outputs.pop();
            self.outputs.push(Some(printed.collect()));
            self.ran += 1;
        }
    }

    fn compare(&mut self, shown: &Shown) {
        let from = if shown.is_part {
            0
        } else {
            self.outputs.len().saturating_sub(1)
        };
        let outputs = &self.outputs[from..];
        if outputs
            .iter()
            .any(|output| output.as_ref().is_none_or(|output| shown.is_true(output)))
        {
            return;
        }
        let writes = std::env::var_os("PALPATE_WRITE_FIGURES").is_some();
        let today = outputs
            .iter()
            .flatten()
            .find_map(|output| shown.today(output));
        match today {
            Some(today) if writes => {
                let indent = " ".repeat(shown.indent);
                for (line, today) in self.lines[shown.first..].iter_mut().zip(today) {
                    *line = format!("{indent}{today}").trim_end().to_owned();
                }
            }
            _ => {
                let at = format!("{}:{}", self.page.display(), shown.first + 1);
                let printed = outputs.iter().flatten().map(|lines| {
                    let first = &lines[..lines.len().min(PRINTED)];
                    first.join("\n")
                });
                let printed: Vec<String> = printed.collect();
                self.stale.push(format!("{at}\n{}", printed.join("\n--\n")));
            }
        }
    }
}

#[test]
fn every_command_parses_and_runs_and_prints_what_the_page_shows() {
    let (mut ran, mut stale) = (0, Vec::new());
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        let mut walk = Walk::new(&page, &text);
        for step in steps(&text) {
            walk.take(step);
        }
        let today = walk.lines.join("\n") + "\n";
        if today != text {
            fs::write(&page, today).unwrap();
        }
        ran += walk.ran;
        stale.extend(walk.stale);
    }
    assert!(
        stale.is_empty(),
        "expected what the commands print; `PALPATE_WRITE_FIGURES=1 cargo test -p palpate-hil --test cli docs` writes figures, other words are yours:\n{}",
        stale.join("\n\n")
    );
    assert!(ran >= 40, "only {ran} commands ran");
}
