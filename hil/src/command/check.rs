//! `hil check`: every error of settings files at once.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use palpate_files::{
    Checked, FileError, FileKind, Setup, Source, WireState, check as check_file, load_bench,
    load_scene, migrated, said,
};
use palpate_run::Failure;
use serde_json::json;

use crate::cli::{CheckArgs, SagState};
use palpate_live::output::{note, print, print_json, write_text};

/// A file and its errors.
struct Told {
    path: String,
    checked: Checked,
    /// Errors with which a run of the file would be refused, where the file itself is right.
    refused: Vec<String>,
}

impl Told {
    fn errors(&self) -> usize {
        self.checked.errors.len() + self.refused.len()
    }

    fn is_good(&self, kind: FileKind) -> bool {
        self.checked.kind == Some(kind) && self.errors() == 0
    }
}

/// Checks files, and every scene on every bench among them.
///
/// # Errors
/// [`Failure::Check`] where something is wrong; [`Failure::File`] for a file that is not there.
pub fn check(args: &CheckArgs) -> Result<(), Failure> {
    for path in &args.files {
        std::fs::metadata(path).map_err(|error| {
            let label = path.display().to_string();
            let is_built_in = FileKind::ALL.iter().any(|k| k.names().contains(&&*label));
            let found = match is_built_in {
                true => "a name of what is built in, which needs no check".into(),
                false => said(&error),
            };
            FileError::whole(label, "a settings file", found)
        })?;
    }
    let migrated = match args.migrate {
        true => migrate(args)?,
        false => args.files.clone(),
    };
    let told = |path: &PathBuf| Told {
        path: path.display().to_string(),
        checked: check_file(path),
        refused: Vec::new(),
    };
    let mut files: Vec<Told> = migrated.iter().map(told).collect();
    together(&mut files);
    if args.json {
        json(&files)?;
    } else {
        print(|out| {
            files
                .iter()
                .try_for_each(|file| tell(file, args.quiet, out))
        })?;
    }
    let errors: usize = files.iter().map(Told::errors).sum();
    if errors == 0 {
        return Ok(());
    }
    let wrong = files.iter().filter(|file| file.errors() > 0).count();
    let s = |n: usize| if n == 1 { "" } else { "s" };
    let all = files.len();
    let text = format!(
        "{errors} error{} in {wrong} of {all} file{}",
        s(errors),
        s(all)
    );
    Err(Failure::Check(text))
}

/// Brings files up to this version; returns the files to check.
fn migrate(args: &CheckArgs) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for path in &args.files {
        let state = args.sag_state.map(|state| match state {
            SagState::Cold => WireState::Cold,
            SagState::Passed => WireState::Passed,
        });
        let found = migrated(&Source::open(path)?, state)?;
        let Some(found) = found else {
            files.push(path.clone());
            continue;
        };
        let beside = path.with_extension("migrated.toml");
        let target = if args.force {
            let old = PathBuf::from(format!("{}.old", path.display()));
            expect_new(&old)?;
            write_text(&old, Source::open(path)?.text())?;
            path.clone()
        } else {
            expect_new(&beside)?;
            beside
        };
        write_text(&target, &found.text)?;
        found.changes.iter().for_each(|text| note(text));
        note(&format!("wrote {}", target.display()));
        files.push(target);
    }
    Ok(files)
}

fn expect_new(path: &Path) -> Result<(), Failure> {
    match path.exists() {
        false => Ok(()),
        true => Err(Failure::Input(format!(
            "{}: expected no such file, --migrate writes it; move it away",
            path.display()
        ))),
    }
}

/// Holds scenes against benches: those among the files, else each against the one that `hil run` takes.
fn together(files: &mut [Told]) {
    let good = files.iter().filter(|file| file.is_good(FileKind::Bench));
    let given = good.map(|file| Some(file.path.clone()));
    let mut benches: Vec<Option<String>> = given.collect();
    if benches.is_empty() {
        benches.push(None);
    }
    for file in files.iter_mut().filter(|f| f.is_good(FileKind::Scene)) {
        for bench in &benches {
            if let Err(refused) = fits(&file.path, bench.as_deref()) {
                let text = refused.to_string();
                if !file.refused.contains(&text) {
                    file.refused.push(text);
                }
            }
        }
    }
}

/// Tells whether a scene can be begun on a `given` bench, or without one on the bench that ships with the display it
/// wants. Without a given bench, a scene for another display waits for its bench.
fn fits(scene: &str, given: Option<&str>) -> Result<(), Failure> {
    let scene = load_scene(scene)?;
    let bench = load_bench(given.unwrap_or(scene.value.own_bench()))?;
    let display = scene.value.map.display.as_ref();
    if given.is_none() && display.is_some_and(|display| *display != bench.value.display) {
        return Ok(());
    }
    let setup = Setup::join(scene, bench)?;
    palpate_run::fits(&setup)
}

fn tell(file: &Told, quiet: bool, out: &mut dyn Write) -> io::Result<()> {
    for error in &file.checked.errors {
        writeln!(out, "{error}")?;
    }
    for text in &file.refused {
        writeln!(out, "{text}")?;
    }
    let path = &file.path;
    if file.errors() == 0 {
        let what = file.checked.kind.map_or("a file", FileKind::noun);
        return match quiet {
            true => Ok(()),
            false => writeln!(out, "{path}: {what}, nothing wrong"),
        };
    }
    if !file.checked.complete {
        writeln!(
            out,
            "{path}: there may be more; these errors hide what is behind them"
        )?;
    }
    Ok(())
}

fn json(files: &[Told]) -> Result<(), Failure> {
    let error = |error: &FileError| {
        let mut told = json!(error);
        told["text"] = error.to_string().into();
        told
    };
    let file = |file: &Told| {
        let mut errors: Vec<_> = file.checked.errors.iter().map(error).collect();
        errors.extend(
            file.refused
                .iter()
                .map(|text| json!({"file": file.path, "text": text})),
        );
        json!({
            "file": Path::new(&file.path), "kind": file.checked.kind.map(FileKind::name),
            "complete": file.checked.complete, "errors": errors,
        })
    };
    let all: Vec<_> = files.iter().map(file).collect();
    print_json(&all)
}
