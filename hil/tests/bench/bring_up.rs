//! The page that brings up a bench of one's own, run on the fake bench from top to bottom: each command in turn, and what
//! the page shows under it.

use std::process::Command;
use std::time::Duration;

use crate::feed::Feed;
use crate::rig::{Bench, on_bench};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/howto/my-bench.md");
/// Time that a command of the page is given: a run of ten seconds, and its hot pass.
const END: Duration = Duration::from_secs(40);
/// Commands of the page that touch the bench: one that finds none is no test.
const LEAST: usize = 8;

/// A block of the page: commands, or lines that the last command prints.
enum Block<'a> {
    Commands(Vec<&'a str>),
    Shown(Vec<&'a str>),
}

/// The blocks under the heading that writes the bench's file, and after.
fn blocks(page: &str) -> Vec<Block<'_>> {
    let start = page
        .find("\n## 3.")
        .expect("the page writes the bench down");
    let mut lines = page[start..].lines();
    let mut blocks = Vec::new();
    while let Some(line) = lines.next() {
        let kind = line.strip_prefix("```");
        let mut inner = || lines.by_ref().take_while(|l| *l != "```").collect();
        match kind {
            Some("sh") => blocks.push(Block::Commands(inner())),
            Some("text") => blocks.push(Block::Shown(inner())),
            _ => {}
        }
    }
    blocks
}

/// Output of a command of the page on this bench; it has to succeed.
#[track_caller]
fn printed(bench: &Bench, line: &str) -> String {
    let line = here(bench, line);
    let (command, _) = line.split_once(" #").unwrap_or((&line, ""));
    let mut words: Vec<&str> = command.split_whitespace().collect();
    if words[0] != "hil" {
        let mut shell = Command::new("sh");
        let shell = shell.args(["-c", command]).current_dir(bench.path("."));
        assert!(shell.status().unwrap().success(), "{command}");
        return String::new();
    }
    if words[1] == "pulse" {
        // Nobody is at a terminal to agree.
        words.push("--yes");
    }
    // The socket of an earlier command may still have its name.
    for name in ["lo.rx", "lo-1.rx"] {
        let _ = std::fs::remove_file(bench.path(name));
    }
    let _feeds = ["lo.rx", "lo-1.rx"].map(|name| Feed::at_rest(bench.path(name), 4));
    let said = bench.start(&words[1..]).finish(END);
    assert_eq!(said.status, Some(0), "{command}: {said:?}");
    said.out + &said.err
}

/// A line of the page with the devices of this bench.
fn here(bench: &Bench, line: &str) -> String {
    let node = bench.node(0).display().to_string();
    line.replace("can0", "lo").replace("/dev/i2c-1", &node)
}

#[test]
fn the_page_brings_a_bench_up() {
    let page = std::fs::read_to_string(PAGE).unwrap();
    on_bench(1, |bench| {
        let _ = std::fs::remove_file(bench.path("my-bench.toml"));
        let (mut last, mut count) = (String::new(), 0);
        for block in blocks(&page) {
            match block {
                Block::Commands(lines) => {
                    last.clear();
                    for line in lines {
                        last += &printed(bench, line);
                        count += 1;
                    }
                }
                Block::Shown(lines) => {
                    for line in lines {
                        let line = here(bench, line);
                        assert!(last.contains(line.trim()), "{line:?} is not in {last}");
                    }
                }
            }
        }
        assert!(count >= LEAST, "{count} commands");
        assert!(bench.longest_on() > 1.0, "no wire was driven");
        assert!(!bench.is_on());
        assert_eq!(bench.latched(), "");
    });
}
