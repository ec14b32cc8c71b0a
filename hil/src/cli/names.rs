//! Candidates for a shell's completion: built-in names, files of their kind in this folder, laws, keys and commands.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::{Arg, Command};
use clap_complete::env::CompleteEnv;
use clap_complete::{ArgValueCompleter, CompletionCandidate, PathCompleter};
use palpate_files::{FileKind, Listed, built_in, illusions, keys, of_folder};

use super::shown;

/// The variable by which a shell's script asks this program for candidates.
pub const VARIABLE: &str = "HIL_COMPLETE";

/// Candidates for an argument beside a path.
#[derive(Clone, Copy)]
enum Names {
    /// Built-in files of a kind, and those of the folder.
    Shelf(FileKind),
    /// Laws of illusion.
    Laws,
    /// Keys of scenes, and of benches behind `bench.`.
    Keys,
    /// Commands of this program.
    Commands,
}

/// Arguments by name, and what stands for them wherever they occur.
const ARGUMENTS: [(&str, Names); 16] = [
    ("scene", Names::Shelf(FileKind::Scene)),
    ("what", Names::Shelf(FileKind::Scene)),
    ("targets", Names::Shelf(FileKind::Scene)),
    ("bench", Names::Shelf(FileKind::Bench)),
    ("layout", Names::Shelf(FileKind::Layout)),
    ("display", Names::Shelf(FileKind::Layout)),
    ("person", Names::Shelf(FileKind::Person)),
    ("wearer", Names::Shelf(FileKind::Wearer)),
    ("wire", Names::Shelf(FileKind::Wire)),
    ("alloy", Names::Shelf(FileKind::Alloy)),
    ("textures", Names::Shelf(FileKind::Textures)),
    ("protocol", Names::Shelf(FileKind::Protocol)),
    ("like", Names::Shelf(FileKind::Protocol)),
    ("illusion", Names::Laws),
    ("set", Names::Keys),
    ("command", Names::Commands),
];

/// Answers a shell that asks for candidates; whether one did.
#[must_use]
pub fn complete(line: &[OsString]) -> bool {
    let asked = std::env::var_os(VARIABLE).is_some_and(|shell| !shell.is_empty());
    if !asked || line.is_empty() {
        return false;
    }
    let here = std::env::current_dir().ok();
    let answer = CompleteEnv::with_factory(completed).var(VARIABLE);
    // A shell that is not known gets no candidates.
    let _ = answer.try_complete(line.iter().cloned(), here.as_deref());
    true
}

/// The command line with what each argument may be.
fn completed() -> Command {
    of_command(shown())
}

fn of_command(command: Command) -> Command {
    let command = command.mut_args(|arg| {
        let found = ARGUMENTS.iter().find(|(name, _)| arg.get_id() == *name);
        match found {
            Some((_, names)) => with_names(arg, *names),
            None => arg,
        }
    });
    command.mut_subcommands(of_command)
}

fn with_names(arg: Arg, names: Names) -> Arg {
    arg.add(ArgValueCompleter::new(move |begun: &OsStr| {
        candidates(names, begun)
    }))
}

fn candidates(names: Names, begun: &OsStr) -> Vec<CompletionCandidate> {
    use clap_complete::engine::ValueCompleter;
    let text = begun.to_string_lossy();
    let listed = |all: Vec<Listed>| {
        let begins = all.into_iter().filter(|l| l.name.starts_with(&*text));
        begins
            .map(|l| CompletionCandidate::new(l.name).help(Some(l.description.into())))
            .collect::<Vec<_>>()
    };
    match names {
        Names::Shelf(kind) => {
            let own = of_folder(Path::new("."), 0).into_iter();
            let own = own.filter(|listed| listed.kind == kind.name());
            let mut found = listed(built_in(kind).into_iter().chain(own).collect());
            found.extend(PathCompleter::any().complete(begun));
            found.sort();
            found.dedup_by(|a, b| a.get_value() == b.get_value());
            found
        }
        Names::Laws => listed(illusions()),
        Names::Keys => {
            let of_bench = keys(FileKind::Bench).into_iter();
            let of_bench = of_bench.map(|key| format!("bench.{key}"));
            let all = keys(FileKind::Scene).into_iter().chain(of_bench);
            let begins = all.filter(|key| key.starts_with(&*text));
            begins
                .map(|key| CompletionCandidate::new(format!("{key}=")))
                .collect()
        }
        Names::Commands => {
            let all = shown();
            let names = all.get_subcommands().map(|c| c.get_name().to_owned());
            let begins = names.filter(|name| name.starts_with(&*text));
            begins.map(CompletionCandidate::new).collect()
        }
    }
}
