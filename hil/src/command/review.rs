//! `hil review`: changed goldens one after another, with words and charts; accept, reject or skip.

use std::io::{self, BufRead};

use palpate_files::did_you_mean;
use palpate_records::diff::{Grade, LINES};
use palpate_records::story::GoldenKind;

use crate::cli::{Color, ReviewAction, ReviewArgs};
use crate::review::{BLOCKS, Pending, Scene, folder, page, pending, scenes, stacked};
use palpate_files::Format;
use palpate_live::output::{Outputs, print};
use palpate_live::progress::Progress;
use palpate_run::Failure;

/// The code of text without a colour.
const PLAIN: &str = "0";

/// Shows what waits and asks, or decides by name.
///
/// # Errors
/// [`Failure::Input`] for a golden that cannot be read or a name that nothing waits under; [`Failure::Check`] when
/// something still waits at the end.
pub fn review(args: &ReviewArgs, color: Color) -> Result<(), Failure> {
    let folder = folder(args.goldens.as_deref())?;
    if args.html.is_some() && args.action.is_some() {
        return Err(Failure::Input(
            "--html: expected no decision beside it; write the page first, then decide".into(),
        ));
    }
    let waiting = pending(&folder)?;
    match &args.action {
        Some(ReviewAction::Accept { names, why }) => {
            decide(&waiting, names, "accepted", |p| p.accept(why.as_deref()))
        }
        Some(ReviewAction::Reject { names }) => {
            decide(&waiting, names, "rejected", Pending::reject)
        }
        None => {
            let shown = Progress::endless("reading goldens");
            let all = scenes(waiting)?;
            drop(shown);
            if let Some(path) = &args.html {
                let outputs = Outputs::new(args.force);
                outputs.write_some(Some(path), Format::Html, || page(&all))?;
                return print(|out| {
                    writeln!(out, "wrote {}: {}", path.display(), count(all.len()))
                });
            }
            if all.is_empty() {
                return print(|out| {
                    writeln!(
                        out,
                        "no golden waits; `hil test` and `cargo test` leave those that change"
                    )
                });
            }
            ask(&all, color.on(&io::stdout()))
        }
    }
}

fn count(scenes: usize) -> String {
    match scenes {
        1 => "1 scene waits".to_owned(),
        n => format!("{n} scenes wait"),
    }
}

/// Accepts or rejects everything, or what is named: a scene, or one of its goldens.
fn decide(
    waiting: &[Pending],
    names: &[String],
    done: &str,
    act: impl Fn(&Pending) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let is = |p: &Pending, name: &String| p.name == *name || p.subject() == name;
    if let Some(name) = names.iter().find(|n| !waiting.iter().any(|p| is(p, n))) {
        let there: Vec<&str> = waiting.iter().map(|p| p.name.as_str()).collect();
        let meant = did_you_mean(name, there.iter().copied());
        let there = if there.is_empty() {
            "nothing waits".to_owned()
        } else {
            there.join(", ")
        };
        return Err(Failure::Input(format!(
            "{name}: expected a golden that waits, found {there}{meant}"
        )));
    }
    let meant = |p: &&Pending| names.is_empty() || names.iter().any(|n| is(p, n));
    for one in waiting.iter().filter(meant) {
        act(one)?;
        print(|out| writeln!(out, "{done} {}", one.name))?;
    }
    Ok(())
}

/// Answer of the reviewer.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Answer {
    Accept(Option<String>),
    Reject,
    Skip,
    Charts,
    Quit,
    Unclear,
}

impl Answer {
    /// `a`, `a because the burst is longer`, `r`, `s`, `c`, `q`, or the words themselves.
    fn parse(line: &str) -> Self {
        let (word, rest) = line.trim().split_once(' ').unwrap_or((line.trim(), ""));
        let why = (!rest.trim().is_empty()).then(|| rest.trim().to_owned());
        match (word, why) {
            ("a" | "accept", why) => Self::Accept(why),
            ("r" | "reject", None) => Self::Reject,
            ("s" | "skip", None) => Self::Skip,
            ("c" | "charts", None) => Self::Charts,
            ("q" | "quit", None) => Self::Quit,
            _ => Self::Unclear,
        }
    }
}

/// Asks about one scene after another, until the answers end.
fn ask(all: &[Scene], coloured: bool) -> Result<(), Failure> {
    let mut answers = io::stdin().lock().lines();
    let mut left = 0;
    let mut ended = false;
    for (index, scene) in all.iter().enumerate() {
        show(scene, (index + 1, all.len()), BLOCKS, coloured)?;
        loop {
            if ended {
                left += 1;
                break;
            }
            print(|out| {
                let keys = "accept (a, or a WHY), reject (r), skip (s), all charts (c), quit (q)? ";
                write!(out, "{keys}")
            })?;
            let answer = match answers.next() {
                Some(Ok(line)) => Answer::parse(&line),
                Some(Err(_)) | None => Answer::Quit,
            };
            let (word, result) = match answer {
                Answer::Accept(why) => {
                    let act = |p: &Pending| p.accept(why.as_deref());
                    (
                        "accepted",
                        scene.changes.iter().try_for_each(|c| act(&c.pending)),
                    )
                }
                Answer::Reject => (
                    "rejected",
                    scene.changes.iter().try_for_each(|c| c.pending.reject()),
                ),
                Answer::Skip => {
                    left += 1;
                    ("skipped", Ok(()))
                }
                Answer::Charts => {
                    show(scene, (index + 1, all.len()), usize::MAX, coloured)?;
                    continue;
                }
                Answer::Quit => {
                    ended = true;
                    left += 1;
                    ("left", Ok(()))
                }
                Answer::Unclear => continue,
            };
            result?;
            print(|out| writeln!(out, "{word} {}\n", scene.name))?;
            break;
        }
    }
    if left > 0 {
        return Err(Failure::Check(format!("{} for a decision", count(left))));
    }
    Ok(())
}

/// A scene's words, then both charts.
fn show(
    scene: &Scene,
    (number, of): (usize, usize),
    most: usize,
    coloured: bool,
) -> Result<(), Failure> {
    let kinds: Vec<&str> = scene.changes.iter().map(|c| c.what()).collect();
    let paint = |code: &str, text: &str| {
        if coloured && code != PLAIN {
            format!("\x1b[{code}m{text}\x1b[0m")
        } else {
            text.to_owned()
        }
    };
    let words = scene.words();
    print(|out| {
        let title = paint("1", &scene.name);
        writeln!(
            out,
            "{number} of {of}  {title}: {} changed",
            kinds.join(", ")
        )?;
        for d in words.iter().take(LINES) {
            let code = match d.grade {
                Grade::Margin | Grade::Limiter | Grade::Stop => "31",
                Grade::Cosmetic => "2",
                _ => PLAIN,
            };
            writeln!(out, "  {}", paint(code, &d.text))?;
        }
        if words.len() > LINES {
            writeln!(out, "  .. and {} more", words.len() - LINES)?;
        }
        let chart = [GoldenKind::Schedule, GoldenKind::Contacts]
            .into_iter()
            .find_map(|kind| scene.golden(kind));
        if let Some((old, new)) = chart {
            let lines = stacked(old, new, most);
            if !lines.is_empty() {
                writeln!(out)?;
            }
            for line in lines {
                let code = match line.as_bytes().first() {
                    Some(b'-') => "31",
                    Some(b'+') => "32",
                    _ => PLAIN,
                };
                writeln!(out, "{}", paint(code, &line))?;
            }
        }
        writeln!(out)
    })
}

#[cfg(test)]
#[path = "review_tests.rs"]
mod tests;
