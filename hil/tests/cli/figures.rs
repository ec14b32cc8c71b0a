//! Figures on the pages: a `console` block holds a command and what it prints, and is compared with what it prints today.
//!
//! `...` alone on a line leaves lines out. `PALPATE_WRITE_FIGURES=1` writes today's lines into the pages. A block that
//! begins with `$ palpate-bench`, or whose fence says `console slow`, takes minutes: `PALPATE_FIGURES=all` compares it too.

use super::docs::{pages, shell};
use super::*;

/// A block of a page: its command, and the lines that the page shows of its output.
struct Block {
    command: String,
    /// Index of the first line under the command.
    first: usize,
    lines: Vec<String>,
    is_slow: bool,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut fence = None;
    for (index, line) in page.lines().enumerate() {
        match (line.strip_prefix("```"), fence) {
            (Some(tag), None) => fence = Some(tag),
            (Some(_), Some(_)) => fence = None,
            (None, Some("console" | "console slow")) => match line.strip_prefix("$ ") {
                Some(command) => blocks.push(Block {
                    command: command.to_owned(),
                    first: index + 1,
                    lines: Vec::new(),
                    is_slow: fence == Some("console slow") || command.starts_with("palpate-bench"),
                }),
                None => {
                    let block = blocks.last_mut().expect("a block begins with `$ `");
                    block.lines.push(line.to_owned());
                }
            },
            _ => {}
        }
    }
    blocks
}

/// A line with `#` for each number, and one blank for several: the shape that it keeps when its figures change.
fn shape(line: &str) -> String {
    let mut shape = String::new();
    for c in line.chars() {
        let c = match c {
            '0'..='9' | '.' | '-' | '+' => '#',
            c => c,
        };
        if !((c == '#' || c == ' ') && shape.ends_with(c)) {
            shape.push(c);
        }
    }
    shape.replace(" #", "#").replace("# ", "#")
}

/// A line without the time that the computer took.
fn timeless(line: &str) -> String {
    match line.split_once(" emulated in ") {
        Some((head, _)) => head.to_owned(),
        None => line.trim_end().to_owned(),
    }
}

/// Lines of a block with today's figures: each stretch between two `...` is found in the output, in its order, by `key`.
fn found(block: &Block, output: &[String], key: fn(&str) -> String) -> Option<Vec<String>> {
    let keys: Vec<String> = output.iter().map(|line| key(line)).collect();
    let (mut lines, mut from) = (Vec::new(), 0);
    for (number, stretch) in block.lines.split(|line| line == "...").enumerate() {
        if number > 0 {
            lines.push("...".to_owned());
        }
        if stretch.is_empty() {
            continue;
        }
        let wanted: Vec<String> = stretch.iter().map(|line| key(line)).collect();
        let windows = keys.windows(wanted.len()).enumerate().skip(from);
        let at = windows
            .filter(|(at, _)| number > 0 || *at == 0)
            .find(|(_, window)| *window == wanted.as_slice())
            .map(|(at, _)| at)?;
        from = at + stretch.len();
        lines.extend_from_slice(&output[at..from]);
    }
    let is_whole = block.lines.last().is_some_and(|line| line == "...") || from == output.len();
    is_whole.then_some(lines)
}

/// What a block's command prints.
fn printed(command: &str, folder: &Folder) -> Vec<String> {
    let whole = match command.strip_prefix("palpate-bench ") {
        Some(words) => {
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
            format!(
                "cd {} && cargo run --quiet --release --locked -p palpate-bench -- {words}",
                root.display()
            )
        }
        None => command.replace("cargo run --release", "hil"),
    };
    let said = shell(&whole, folder);
    let lines = said.out.lines().map(|line| line.trim_end().to_owned());
    lines.collect()
}

#[test]
fn a_page_shows_what_its_commands_print() {
    let (writes, all) = (
        std::env::var_os("PALPATE_WRITE_FIGURES").is_some(),
        std::env::var_os("PALPATE_FIGURES").is_some(),
    );
    let (mut stale, mut compared) = (Vec::new(), 0);
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let name = page.file_stem().unwrap().to_string_lossy().into_owned();
        let folder = Folder::new(&format!("figures-{name}"));
        for block in blocks(&text).iter().filter(|block| all || !block.is_slow) {
            let output = printed(&block.command, &folder);
            let at = format!("{}:{}: {}", page.display(), block.first, block.command);
            compared += 1;
            if found(block, &output, timeless).is_some() {
                continue;
            }
            let today = found(block, &output, shape);
            match today {
                Some(today) if writes => {
                    lines.splice(block.first..block.first + block.lines.len(), today);
                }
                _ => stale.push(format!("{at}\n{}", output.join("\n"))),
            }
        }
        if writes {
            fs::write(&page, lines.join("\n") + "\n").unwrap();
        }
    }
    assert!(
        stale.is_empty(),
        "expected what the commands print; `PALPATE_WRITE_FIGURES=1 cargo test -p palpate-hil --test cli figures` writes figures, other words are yours:\n{}",
        stale.join("\n\n")
    );
    assert!(compared >= 8, "only {compared} blocks were compared");
}
