//! Pages that bring up a bench of one's own, run on the fake bench from top to bottom: each command in turn, and what a page
//! shows under it.

use std::process::Command;
use std::time::Duration;

use palpate_tests::fake_bench::Switch;

use crate::feed::Feed;
use crate::rig::{Bench, on_bench};

const PAGES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs");
/// Time that a command of the page is given: a run of ten seconds, and its hot pass.
const END: Duration = Duration::from_secs(40);

/// A block of the page: the bench's file, commands, or lines that the last command prints.
enum Block<'a> {
    File(Vec<&'a str>),
    Commands(Vec<&'a str>),
    Shown(Vec<&'a str>),
}

/// The blocks from the heading that writes the bench's file to another.
fn blocks<'a>(page: &'a str, (from, to): (&str, &str)) -> Vec<Block<'a>> {
    let (_, part) = page
        .split_once(from)
        .expect("the page writes the bench down");
    let (part, _) = part.split_once(to).expect("the page goes on");
    let mut lines = part.lines();
    let mut blocks = Vec::new();
    while let Some(line) = lines.next() {
        let kind = line.strip_prefix("```");
        let mut inner = || lines.by_ref().take_while(|l| *l != "```").collect();
        match kind {
            Some("toml") => blocks.push(Block::File(inner())),
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
    // The doctor complains of the machine as well.
    assert!(
        said.status == Some(0) || words[1] == "doctor",
        "{command}: {said:?}"
    );
    said.out + &said.err
}

/// A line of the page with the devices of this bench.
fn here(bench: &Bench, line: &str) -> String {
    let node = bench.node(0).display().to_string();
    line.replace("can0", "lo").replace("/dev/i2c-1", &node)
}

/// Runs a part of a page on a bench, whose commands are this many at least: one that finds none is no test.
#[track_caller]
fn bring_up(bench: &Bench, page: &str, part: (&str, &str), least: usize) {
    let page = std::fs::read_to_string(format!("{PAGES}/{page}")).unwrap();
    let _ = std::fs::remove_file(bench.path("my-bench.toml"));
    let (mut last, mut count) = (String::new(), 0);
    for block in blocks(&page, part) {
        match block {
            Block::File(lines) => {
                let text = here(bench, &lines.join("\n"));
                std::fs::write(bench.path("my-bench.toml"), text).unwrap();
            }
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
    assert!(count >= least, "{count} commands");
    assert!(bench.longest_on() > 1.0, "nothing was driven");
    assert!(!bench.is_on());
    assert_eq!(bench.latched(), "");
}

#[test]
fn the_page_brings_a_bench_up() {
    on_bench(1, |bench| {
        bring_up(bench, "howto/my-bench.md", ("\n## 3.", "\n## Next"), 8)
    });
}

#[test]
fn the_page_of_motors_brings_them_up() {
    on_bench(1, |bench| {
        bench.adapters[0].put_motors(Switch::new(0x70, 8));
        let part = ("\n## On hardware", "\n## Voice coils");
        bring_up(bench, "vibration.md", part, 5);
    });
}
