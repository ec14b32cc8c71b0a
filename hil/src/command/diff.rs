//! `hil diff`: two goldens, schedules or recorded contact paths, told in words; a schedule and a capture of its
//! pins go to `pins`.

use std::path::{Path, PathBuf};
use std::{fs, io};

use palpate_records::diff::{Tolerance, compare, tell};
use palpate_records::story::Story;
use palpate_records::verdict::Verdict;

use super::long_schedules::{Told, long};
use super::pins::{is_capture, pins};
use super::schedules::{MOST, read_log, wires};
use crate::cli::{Color, DiffArgs};
use palpate_files::{FileError, Format, LONGEST_LINE, Lines, Text, format_of};
use palpate_live::output::{note, print, print_json};
use palpate_live::recording::compare_recordings;
use palpate_run::{Failure, damaged};

/// Files of a run's folder that `diff` compares.
const IN_FOLDERS: [&str; 2] = ["schedule.jsonl", "contacts.csv"];

/// Compares two files, or those of two folders.
///
/// # Errors
/// [`Failure::Input`] for a file that is none of ours, [`Failure::Check`] where a difference means something.
pub fn diff(args: &DiffArgs, color: Color) -> Result<(), Failure> {
    let pairs = pairs(&args.a, &args.b)?;
    if let [(a, b)] = pairs.as_slice()
        && is_capture(a, b)
    {
        let (a, b) = (a.clone(), b.clone());
        return pins(
            &DiffArgs {
                a,
                b,
                ..args.clone()
            },
            color,
        );
    }
    if args.window.is_some() {
        return Err(Failure::Input(
            "--window: expected a schedule (.jsonl) and a capture (.vcd, .fst, .ghw, .csv) to compare, found other files".into(),
        ));
    }
    let all = pairs.iter().map(|(a, b)| found(args, a, b));
    told(args, color, &all.collect::<Result<Vec<_>, _>>()?)
}

/// Pairs of files at two paths: of two folders of `hil run --out` the
/// files that both have, of one folder the file of the other's kind.
fn pairs(a: &Path, b: &Path) -> Result<Vec<(PathBuf, PathBuf)>, FileError> {
    let inside = |folder: &Path, other: &Path| {
        let is_table = format_of(other) == Some(Format::Contacts);
        folder.join(IN_FOLDERS[usize::from(is_table)])
    };
    let none = |folder: &Path| {
        let expected = format!(
            "a folder of `hil run --out`, with {}",
            IN_FOLDERS.join(" or ")
        );
        FileError::whole(folder.display().to_string(), expected, "none of them")
    };
    let one = match (a.is_dir(), b.is_dir()) {
        (false, false) => (a.to_path_buf(), b.to_path_buf()),
        (true, false) => (inside(a, b), b.to_path_buf()),
        (false, true) => (a.to_path_buf(), inside(b, a)),
        (true, true) => {
            let both = IN_FOLDERS.map(|name| (a.join(name), b.join(name)));
            let both = both.into_iter().filter(|(a, b)| a.is_file() && b.is_file());
            let both: Vec<_> = both.collect();
            let lacking = [a, b]
                .into_iter()
                .find(|folder| !IN_FOLDERS.iter().any(|name| folder.join(name).is_file()));
            return match both.is_empty() {
                true => Err(none(lacking.unwrap_or(b))),
                false => Ok(both),
            };
        }
    };
    for (path, given) in [(&one.0, a), (&one.1, b)] {
        if given.is_dir() && !path.is_file() {
            return Err(none(given));
        }
    }
    Ok(vec![one])
}

/// Differences of two files.
fn found(args: &DiffArgs, path_a: &Path, path_b: &Path) -> Result<Told, Failure> {
    let thousandths = |value: f64| (value * 1e3).round() as u64;
    let edge_us = args.tolerance_ms.map(thousandths);
    let place_um = args.tolerance_mm.map(thousandths);
    if is_long_schedule(path_a) && is_long_schedule(path_b) {
        return Ok(long([path_a, path_b], edge_us)?);
    }
    let (mut a, mut b) = (open(path_a)?, open(path_b)?);
    match (&mut a, &mut b) {
        (File::Contacts(a), File::Contacts(b)) => {
            let bands = Tolerance {
                place_um: place_um.unwrap_or(0),
                ..Tolerance::HARDWARE
            };
            let tolerance = match bands.place_um {
                0 => Tolerance::default(),
                _ => bands,
            };
            let found = compare_recordings(a, b, tolerance)?;
            for lines in [a, b] {
                lines.note().iter().for_each(|text| note(text));
            }
            Ok(("contacts".to_owned(), found, None))
        }
        (File::Story(a), File::Story(b)) if a.kind == b.kind => {
            let mut tolerance = Tolerance::between(a, b);
            tolerance.edge_us = edge_us.unwrap_or(tolerance.edge_us);
            tolerance.place_um = place_um.unwrap_or(tolerance.place_um);
            Ok((b.scene.clone(), compare(a, b, tolerance), None))
        }
        (a, b) => Err(Failure::Input(format!(
            "{}: expected a {} like {}, found a {}",
            path_b.display(),
            a.what(),
            path_a.display(),
            b.what()
        ))),
    }
}

/// Prints what was found; a difference that means something fails.
fn told(args: &DiffArgs, color: Color, all: &[Told]) -> Result<(), Failure> {
    if args.json {
        let each = all.iter().flat_map(|(_, found, _)| found);
        print_json(&each.collect::<Vec<_>>())?;
    } else if !args.quiet {
        print(|out| {
            let colored = color.on(&io::stdout());
            all.iter().try_for_each(|told| tell_one(told, colored, out))
        })?;
    }
    let mut each = all.iter().flat_map(|(_, found, _)| found);
    match each.any(|d| d.meaning) {
        true => Err(Failure::Check(String::new())),
        false => Ok(()),
    }
}

fn tell_one((name, found, until): &Told, colored: bool, out: &mut dyn io::Write) -> io::Result<()> {
    let means = found.iter().any(|d| d.meaning);
    let cosmetic = if means || found.is_empty() {
        ""
    } else {
        ", nothing that could be felt or measured"
    };
    let verdict = match (until, means) {
        (Some(_), _) => Verdict::Incomplete,
        (None, true) => Verdict::Failed,
        (None, false) => Verdict::Ok,
    };
    let word = verdict.paint(verdict.word(), colored);
    match found.len() {
        0 => writeln!(out, "{word}: {name}: no difference")?,
        1 => writeln!(out, "{word}: {name}: 1 difference{cosmetic}")?,
        n => writeln!(out, "{word}: {name}: {n} differences{cosmetic}")?,
    }
    let lines = tell(found);
    lines.iter().try_for_each(|line| writeln!(out, "  {line}"))
}

/// Tells whether a schedule is too long to be held.
fn is_long_schedule(path: &Path) -> bool {
    let long = fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() > MOST);
    long && format_of(path) == Some(Format::Schedule)
}

/// An opened file: a story is read as a whole, contacts are read while they are compared.
enum File {
    Story(Box<Story>),
    Contacts(Lines<fs::File>),
}

impl File {
    fn what(&self) -> &'static str {
        match self {
            Self::Story(story) => story.kind.title(),
            Self::Contacts(_) => "contact recording",
        }
    }
}

/// Opens a golden, or by its first characters a schedule or recorded contacts.
fn open(path: &Path) -> Result<File, Failure> {
    let label = path.display().to_string();
    let expected = "a golden (.snap), a schedule (.jsonl) or contacts (.csv)";
    let mut lines = Lines::over(Text::open(path, expected, LONGEST_LINE)?.waiting());
    let known = [
        Format::Golden,
        Format::Schedule,
        Format::Contacts,
        Format::Json,
    ];
    match lines.format()? {
        Some(Format::Contacts) => return Ok(File::Contacts(lines)),
        Some(format) if !known.contains(&format) => {
            return Err(FileError::whole(label, expected, format.noun()).into());
        }
        _ => {}
    }
    let text = read_log(lines)?;
    let read = if text.starts_with('{') {
        Story::of_schedule_file(&text, wires)
    } else {
        Story::read(&text)
    };
    let story = read.map_err(|damage| damaged(label, damage))?;
    Ok(File::Story(Box::new(story)))
}
