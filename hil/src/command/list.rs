//! `hil list`: what there is, a line each.

use std::io::{self, Write};
use std::path::Path;

use clap::ValueEnum;
use palpate_files::{FileError, FileKind, Listed, built_in, illusions, of_folder, said};
use palpate_run::Failure;

use crate::cli::{ListArgs, Shelf};
use palpate_live::output::{print, print_json};

/// Depth to which a named folder is searched.
const DEPTH: usize = 8;

/// Lists built-in files, and those of the current folder or of those that are named.
///
/// # Errors
/// [`Failure::Input`] for a folder that cannot be read, [`Failure::Write`] where standard output takes nothing.
pub fn list(args: &ListArgs) -> Result<(), Failure> {
    let shelves = match args.shelves.as_slice() {
        [] => Shelf::value_variants(),
        some => some,
    };
    let mut here = Vec::new();
    for folder in &args.dir {
        std::fs::read_dir(folder).map_err(|e| {
            let label = folder.display().to_string();
            FileError::whole(label, "a readable folder (--dir)", said(&e))
        })?;
        here.extend(of_folder(folder, DEPTH));
    }
    if args.dir.is_empty() {
        here = of_folder(Path::new("."), 0);
    }
    let lists = shelves.iter().map(|shelf| (*shelf, lines(*shelf, &here)));
    let lists: Vec<(Shelf, Vec<Listed>)> = lists.collect();
    if args.json {
        let all: Vec<&Listed> = lists.iter().flat_map(|(_, lines)| lines).collect();
        return print_json(&all);
    }
    print(|out| {
        for (number, (shelf, lines)) in lists.iter().enumerate() {
            if number > 0 {
                writeln!(out)?;
            }
            tell(*shelf, lines, lists.len() > 1, out)?;
        }
        Ok(())
    })
}

fn tell(shelf: Shelf, lines: &[Listed], titled: bool, out: &mut dyn Write) -> io::Result<()> {
    let indent = if titled { "  " } else { "" };
    if let (true, Some(value)) = (titled, shelf.to_possible_value()) {
        writeln!(out, "{}", value.get_name())?;
    }
    let width = lines.iter().map(|line| line.name.chars().count()).max();
    let width = width.unwrap_or(0);
    for line in lines {
        let here = match &line.file {
            Some(_) if line.name.contains('/') => " (a file)",
            Some(_) => " (in this folder)",
            None => "",
        };
        let (name, description) = (&line.name, &line.description);
        writeln!(out, "{indent}{name:<width$}  {description}{here}")?;
    }
    Ok(())
}

fn lines(shelf: Shelf, here: &[Listed]) -> Vec<Listed> {
    let Some(kind) = kind(shelf) else {
        return illusions();
    };
    let own = here.iter().filter(|listed| listed.kind == kind.name());
    built_in(kind).into_iter().chain(own.cloned()).collect()
}

/// The files of a shelf; none for laws, which are no files.
const fn kind(shelf: Shelf) -> Option<FileKind> {
    Some(match shelf {
        Shelf::Scenes => FileKind::Scene,
        Shelf::Benches => FileKind::Bench,
        Shelf::Layouts => FileKind::Layout,
        Shelf::Limits => FileKind::Limits,
        Shelf::Persons => FileKind::Person,
        Shelf::Wearers => FileKind::Wearer,
        Shelf::Wires => FileKind::Wire,
        Shelf::Alloys => FileKind::Alloy,
        Shelf::Activations => FileKind::Activation,
        Shelf::Priors => FileKind::Priors,
        Shelf::Evidence => FileKind::Evidence,
        Shelf::Bands => FileKind::Band,
        Shelf::Textures => FileKind::Textures,
        Shelf::Protocols => FileKind::Protocol,
        Shelf::Illusions => return None,
    })
}
