//! `hil diff`: two goldens, schedules or recorded contact paths, told in words; a schedule and a capture of its
//! pins go to `pins`.

use std::path::Path;
use std::{fs, io};

use palpate_records::diff::{Contacts, Difference, Tolerance, compare, compare_contacts, tell};
use palpate_records::story::Story;
use palpate_records::verdict::Verdict;

use super::long_schedules::long;
use super::pins::{is_capture, pins};
use super::schedules::{MOST, read_log, wires};
use crate::cli::{Color, DiffArgs};
use palpate_files::{FileError, Format, LONGEST_LINE, Lines, format_of};
use palpate_live::output::{note, print, print_json};
use palpate_run::{Failure, damaged};

/// Compares two files.
///
/// # Errors
/// [`Failure::Input`] for a file that is none of ours, [`Failure::Check`] where a difference means something.
pub fn diff(args: &DiffArgs, color: Color) -> Result<(), Failure> {
    if is_capture(&args.a, &args.b) {
        return pins(args, color);
    }
    if args.window.is_some() {
        return Err(Failure::Input(
            "--window: expected a schedule (.jsonl) and a capture (.vcd, .csv) to compare, found other files".into(),
        ));
    }
    let thousandths = |value: f64| (value * 1e3).round() as u64;
    let edge_us = args.tolerance_ms.map(thousandths);
    let place_um = args.tolerance_mm.map(thousandths);
    if is_long_schedule(&args.a) && is_long_schedule(&args.b) {
        let (name, found, until) = long([&args.a, &args.b], edge_us)?;
        return told(args, color, (&name, &found), until);
    }
    let (mut a, mut b) = (open(&args.a)?, open(&args.b)?);
    let (name, found) = match (&mut a, &mut b) {
        (File::Contacts(a), File::Contacts(b)) => {
            let bands = Tolerance {
                place_um: place_um.unwrap_or(0),
                ..Tolerance::HARDWARE
            };
            let tolerance = match bands.place_um {
                0 => Tolerance::default(),
                _ => bands,
            };
            ("contacts".to_owned(), contacts((args, a, b), tolerance)?)
        }
        (File::Story(a), File::Story(b)) if a.kind == b.kind => {
            let mut tolerance = Tolerance::between(a, b);
            tolerance.edge_us = edge_us.unwrap_or(tolerance.edge_us);
            tolerance.place_um = place_um.unwrap_or(tolerance.place_um);
            (b.scene.clone(), compare(a, b, tolerance))
        }
        (a, b) => {
            return Err(Failure::Input(format!(
                "{}: expected a {} like {}, found a {}",
                args.b.display(),
                a.what(),
                args.a.display(),
                b.what()
            )));
        }
    };
    told(args, color, (&name, &found), None)
}

/// Prints what was found; a difference that means something fails. `until` is where two schedules were told to,
/// seconds, where that was not their end.
fn told(
    args: &DiffArgs,
    color: Color,
    (name, found): (&str, &[Difference]),
    until: Option<f64>,
) -> Result<(), Failure> {
    let means = found.iter().any(|d| d.meaning);
    if args.json {
        print_json(found)?;
    } else if !args.quiet {
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
        print(|out| {
            let word = verdict.paint(verdict.word(), color.on(&io::stdout()));
            match found.len() {
                0 => writeln!(out, "{word}: {name}: no difference")?,
                1 => writeln!(out, "{word}: {name}: 1 difference{cosmetic}")?,
                n => writeln!(out, "{word}: {name}: {n} differences{cosmetic}")?,
            }
            let lines = tell(found);
            lines.iter().try_for_each(|line| writeln!(out, "  {line}"))
        })?;
    }
    if means {
        Err(Failure::Check(String::new()))
    } else {
        Ok(())
    }
}

/// Whether a schedule is too long to be held.
fn is_long_schedule(path: &Path) -> bool {
    let long = fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() > MOST);
    long && format_of(path) == Some(Format::Schedule)
}

/// What was opened: a story is read as a whole, contacts are read while they are compared.
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

/// Two recordings, side by side.
fn contacts(
    (args, a, b): (&DiffArgs, &mut Lines<fs::File>, &mut Lines<fs::File>),
    tolerance: Tolerance,
) -> Result<Vec<Difference>, FileError> {
    let found = {
        let mut a = reader(&args.a, a)?;
        let mut b = reader(&args.b, b)?;
        compare_contacts(&mut a, &mut b, tolerance)?
    };
    for lines in [a, b] {
        lines.note().iter().for_each(|text| note(text));
    }
    Ok(found)
}

fn reader<'a>(
    path: &Path,
    lines: &'a mut Lines<fs::File>,
) -> Result<Contacts<'a, FileError>, FileError> {
    let label = path.display().to_string();
    let next = || Ok(lines.advance()?.map(|(_, line)| line.to_owned()));
    Contacts::new(next, move |damage| damaged(&label, damage))
}

/// Opens a golden, or by its first characters a schedule or recorded contacts.
fn open(path: &Path) -> Result<File, Failure> {
    let label = path.display().to_string();
    let expected = "a golden (.snap), a schedule (.jsonl) or contacts (.csv)";
    let mut lines = Lines::open(path, expected, LONGEST_LINE)?;
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
