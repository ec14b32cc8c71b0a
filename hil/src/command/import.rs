//! `hil import`: a recipe proposed from a recording, with what was understood and assumed, and pictures of the skin.

use std::io::{self, Write};
use std::path::Path;

use palpate_files::{
    FileKind, Loaded, Proposal, Recipe, SensorLayout, Source, Timing, is_stream, plan_of, propose,
    said,
};
use palpate_live::output::{note, print, write_text};
use palpate_live::recording::Survey;
use palpate_run::Failure;

use super::new::{expect_new, write_schema};
use super::rate::rate_of;
use super::skin_picture::{Picture, strip};
use crate::cli::ImportArgs;

/// Proposes a recipe and shows what it makes of the recording.
///
/// # Errors
/// [`Failure`] for a file that holds no table, and for one that its recipe cannot read.
pub fn import(args: &ImportArgs) -> Result<(), Failure> {
    let typed = Timing {
        column: args.time.clone(),
        rate_hz: match args.time {
            Some(_) => None,
            None => rate_of(args.rate, std::slice::from_ref(&args.file))?.hz,
        },
        gain: args.gain,
        topic: args.topic.clone(),
        ..Timing::default()
    };
    // Before anything is read.
    if let Some(out) = args.out.as_ref().filter(|out| !is_stream(out)) {
        expect_new(out, args.force)?;
    }
    let layout =
        args.layout
            .as_deref()
            .map(|name| match FileKind::Layout.names().contains(&name) {
                true => Ok(name.to_owned()),
                false => whole(Path::new(name)),
            });
    let layout = layout.transpose()?;
    let recording = recording(args)?;
    let proposal = propose(&args.file, &recording, layout.as_deref(), &typed)?;
    let recipe: Loaded<Recipe> = Loaded::read(Source::new("the proposed recipe", &*proposal.text))?;
    let (plan, sensor) = plan_of(&recipe)?;
    let timing = Timing {
        column: recipe.value.clock(),
        rate_hz: recipe.value.rate_hz,
        topic: recipe.value.topic.clone(),
        ..Timing::default()
    };
    let survey = Survey::read(&args.file, &plan, &timing, &sensor)?;
    print(|out| {
        tell(&proposal, &survey, out)?;
        pictures(&survey, &sensor, out)
    })?;
    match &args.out {
        Some(path) => {
            write_schema(path, FileKind::Recording)?;
            write_text(path, &proposal.text)?;
            note(&format!(
                "wrote {}; `hil contacts {0}` reads the recording by it",
                path.display()
            ));
            Ok(())
        }
        None => print(|out| {
            write!(
                out,
                "\nThe recipe (--out FILE writes it):\n\n{}",
                proposal.text
            )
        }),
    }
}

/// The recording as its recipe names it: by its name, where they lie in one folder.
fn recording(args: &ImportArgs) -> Result<String, Failure> {
    let folder = |path: &Path| path.parent().map(Path::to_path_buf);
    let is_beside = args
        .out
        .as_ref()
        .is_none_or(|out| folder(out) == folder(&args.file));
    match args.file.file_name().filter(|_| is_beside) {
        Some(name) => Ok(name.to_string_lossy().into_owned()),
        None => whole(&args.file),
    }
}

/// A path that holds from any folder.
fn whole(path: &Path) -> Result<String, Failure> {
    let there = std::fs::canonicalize(path);
    let there = there.map_err(|e| Failure::Input(format!("{}: {}", path.display(), said(&e))))?;
    Ok(there.display().to_string())
}

fn tell(proposal: &Proposal, survey: &Survey, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "Understood")?;
    for (word, text) in &proposal.understood {
        entry(out, word, text)?;
    }
    let s = survey.span_us as f64 * 1e-6;
    let rate = match survey.rows {
        0 | 1 => 0.0,
        rows => (rows - 1) as f64 / s.max(1e-9),
    };
    entry(
        out,
        "rate",
        &format!(
            "{rate:.1} rows per second: {} rows in {s:.3} s",
            survey.rows
        ),
    )?;
    entry(
        out,
        "counts",
        &format!("from {} to {}", survey.least, survey.most),
    )?;
    let rest = match survey.at_rest {
        0 => "none of the first rows: contacts need some at rest (--reference-frames)".to_owned(),
        rows => format!("the first {rows} rows (hil contacts takes --reference-frames of them)"),
    };
    entry(out, "at rest", &rest)?;
    survey
        .notes
        .iter()
        .try_for_each(|text| entry(out, "note", text))?;
    writeln!(out, "\nAssumed")?;
    for assumed in &proposal.assumed {
        entry(out, "", &format!("{} ({})", assumed.what, assumed.option))?;
    }
    Ok(())
}

/// A word and a text, the text broken at column 80.
fn entry(out: &mut dyn Write, word: &str, text: &str) -> io::Result<()> {
    let mut line = format!("  {word:<9}");
    let mut length = line.len();
    for part in text.split(' ') {
        let part_length = part.chars().count() + 1;
        if length + part_length > 80 && length > 11 {
            writeln!(out, "{}", line.trim_end())?;
            line = " ".repeat(11);
            length = 11;
        }
        line.push(' ');
        line.push_str(part);
        length += part_length;
    }
    writeln!(out, "{}", line.trim_end())
}

/// The modules that changed most, each with its largest change and some frames.
fn pictures(survey: &Survey, sensor: &SensorLayout, out: &mut dyn Write) -> io::Result<()> {
    let mut begin = 0;
    let mut parts = Vec::new();
    for file in &sensor.modules {
        let own = begin..begin + file.readings();
        begin = own.end;
        let points: Vec<[f64; 2]> = file
            .taxels()
            .iter()
            .filter(|taxel| taxel.active)
            .map(|taxel| [taxel.x_mm, taxel.y_mm])
            .collect();
        let most = survey.largest[own.clone()]
            .iter()
            .copied()
            .fold(0.0, f64::max);
        parts.push((most, file.name.as_str(), own, points));
    }
    let all = parts.len();
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    parts.truncate(SHOWN);
    writeln!(
        out,
        "\nSkin, by the largest change of each taxel ({} of {all} modules)",
        parts.len()
    )?;
    for (most, name, own, points) in &parts {
        let picture = Picture::new(points);
        writeln!(out, "  {name}: `@` is {most:.0} counts from rest")?;
        for line in picture.lines(&survey.largest[own.clone()], *most) {
            writeln!(out, "    {line}")?;
        }
    }
    let Some((most, name, own, points)) = parts.first() else {
        return Ok(());
    };
    writeln!(out, "\nFrames of {name}, seconds from the first row")?;
    let frames: Vec<(u64, &[f64])> = survey
        .frames
        .iter()
        .map(|(t, change)| (*t, &change[own.clone()]))
        .collect();
    strip(&Picture::new(points), &frames, *most)
        .iter()
        .try_for_each(|line| writeln!(out, "  {line}"))
}

/// Modules whose pictures are shown, at most.
const SHOWN: usize = 4;
