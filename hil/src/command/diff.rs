//! `hil diff`: two goldens, schedules or recorded contact paths, told in words; a schedule and a capture of its
//! pins go to `pins`.

use std::io;
use std::path::Path;

use palpate_records::diff::{Recording, Tolerance, compare, compare_recordings, tell};
use palpate_records::story::Story;
use palpate_records::verdict::Verdict;
use serde::Serialize;

use super::pins::{is_capture, pins};
use super::schedules::{damaged, read_log, wires};
use crate::cli::{Color, DiffArgs};
use crate::output::print;
use palpate_files::{FileError, Format};
use palpate_run::Failure;

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
    let (name, found) = match (read(&args.a)?, read(&args.b)?) {
        (File::Story(a), File::Story(b)) if a.kind == b.kind => {
            let mut tolerance = Tolerance::between(&a, &b);
            if let Some(ms) = args.tolerance_ms {
                tolerance.edge_us = (ms * 1e3).round() as u64;
            }
            (b.scene.clone(), compare(&a, &b, tolerance))
        }
        (File::Contacts(a), File::Contacts(b)) => {
            let tolerance = Tolerance {
                place_um: args.tolerance_mm.map_or(0, |mm| (mm * 1e3).round() as u64),
                ..Tolerance::default()
            };
            ("contacts".to_owned(), compare_recordings(&a, &b, tolerance))
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
    let means = found.iter().any(|d| d.meaning);
    if args.json {
        #[derive(Serialize)]
        struct Line<'a> {
            text: &'a str,
            meaning: bool,
        }
        let lines: Vec<Line<'_>> = found
            .iter()
            .map(|d| Line {
                text: &d.text,
                meaning: d.meaning,
            })
            .collect();
        print(|out| {
            serde_json::to_writer(&mut *out, &lines)?;
            writeln!(out)
        })?;
    } else if !args.quiet {
        let cosmetic = if means || found.is_empty() {
            ""
        } else {
            ", nothing that could be felt or measured"
        };
        let verdict = if means { Verdict::Failed } else { Verdict::Ok };
        print(|out| {
            let word = verdict.paint(verdict.word(), color.on(&io::stdout()));
            match found.len() {
                0 => writeln!(out, "{word}: {name}: no difference")?,
                1 => writeln!(out, "{word}: {name}: 1 difference{cosmetic}")?,
                n => writeln!(out, "{word}: {name}: {n} differences{cosmetic}")?,
            }
            let lines = tell(&found);
            lines.iter().try_for_each(|line| writeln!(out, "  {line}"))
        })?;
    }
    if means {
        Err(Failure::Check(String::new()))
    } else {
        Ok(())
    }
}

/// What was read.
enum File {
    Story(Box<Story>),
    Contacts(Recording),
}

impl File {
    fn what(&self) -> &'static str {
        match self {
            Self::Story(story) => story.kind.title(),
            Self::Contacts(_) => "contact recording",
        }
    }
}

/// Reads a golden, or by its first characters a schedule or recorded contacts.
fn read(path: &Path) -> Result<File, Failure> {
    let label = path.display().to_string();
    let expected = "a golden (.snap), a schedule (.jsonl) or contacts (.csv)";
    let text = read_log(path, expected)?;
    let known = [
        Format::Golden,
        Format::Schedule,
        Format::Contacts,
        Format::Json,
    ];
    if let Some(format) = Format::of(text.as_bytes()).filter(|f| !known.contains(f)) {
        return Err(FileError::whole(label, expected, format.noun()).into());
    }
    let read = if text.starts_with('{') {
        Story::of_schedule_file(&text, wires).map(|s| File::Story(Box::new(s)))
    } else if Recording::is_one(&text) {
        Recording::read(&text).map(File::Contacts)
    } else {
        Story::read(&text).map(|s| File::Story(Box::new(s)))
    };
    Ok(read.map_err(|damage| damaged(&label, damage))?)
}
