//! Stages of `hil test`: scenes with the values of the command line, by the bench that they are tried on.

use std::path::PathBuf;

use crate::cli::TestArgs;
use crate::trial::{Member, Suite, TrialEnd};
use palpate_files::{Bench, BenchKind, DEFAULT_BENCH, Loaded, Overrides, load_bench};
use palpate_live::output::{print, print_json};
use palpate_run::Failure;
use serde::Serialize;

use super::devices::bench_with;
use super::test::{goldens_of, why_not};

/// A bench, and the scenes that are tried on it.
pub(super) type Stage<'a> = (Loaded<Bench>, Vec<&'a Member>);
/// Files that cannot be read, and why.
pub(super) type Broken = Vec<(PathBuf, String)>;

/// Tells whether the command line leaves the choice of a bench to the folder.
pub(super) fn chooses_none(args: &TestArgs) -> bool {
    args.on.bench.is_none() && args.on.can.is_empty() && args.on.i2c.is_empty()
}

/// Puts the values of the command line into every scene. One that they break is no reason not to try the others.
///
/// # Errors
/// An option that no scene takes.
pub(super) fn change(suite: &mut Suite, overrides: &Overrides) -> Result<(), Failure> {
    let members = std::mem::take(&mut suite.members);
    let alone = members.len() == 1;
    for member in members {
        match member.scene.clone().with(overrides) {
            Ok(scene) => suite.members.push(Member { scene, ..member }),
            // The option itself is wrong, whatever the scene.
            Err(error) if alone || error.path.starts_with("--") => return Err(error.into()),
            Err(error) => {
                let name = member.scene.value.name.into();
                let name = member.file.unwrap_or(name);
                suite.broken.push((name, error.to_string()));
            }
        }
    }
    Ok(())
}

/// The benches that are meant, with their scenes: the one named, else the emulated ones in the folders, else for each scene
/// the one that ships with what it wants. Benches of the folders that cannot be read join the broken files.
///
/// # Errors
/// A bench that cannot be read, where no other one is meant.
pub(super) fn stages<'a>(
    args: &TestArgs,
    suite: &'a Suite,
    overrides: &Overrides,
    broken: &mut Broken,
) -> Result<Vec<Stage<'a>>, Failure> {
    let on = &args.on;
    let all: Vec<&Member> = suite.members.iter().collect();
    if chooses_none(args) {
        let (mut found, mut wrong) = (Vec::new(), Vec::new());
        for path in &suite.benches {
            let read = load_bench(&path.display().to_string()).and_then(|b| b.with(overrides));
            match read {
                Ok(bench) if bench.value.kind == BenchKind::Emulated => {
                    found.push((bench, all.clone()));
                }
                Ok(_) => {}
                Err(error) => wrong.push((path.clone(), error)),
            }
        }
        // Never on another bench than those of the folder because they are wrong.
        if found.is_empty()
            && let Some((_, error)) = wrong.pop()
        {
            return Err(error.into());
        }
        let told = wrong.into_iter().map(|(path, e)| (path, e.to_string()));
        broken.extend(told);
        if !found.is_empty() {
            return Ok(found);
        }
        return own_stages(suite, overrides);
    }
    // A bench of the folders may be meant by the name of its file.
    let named = on.bench.as_deref().map(|name| {
        let same = |p: &&PathBuf| p.file_stem().is_some_and(|stem| stem == name);
        let path = suite.benches.iter().find(same);
        path.map_or_else(|| name.to_owned(), |p| p.display().to_string())
    });
    let bench = bench_with(named.as_deref(), overrides, &on.can, &on.i2c)?;
    Ok(vec![(bench, all)])
}

/// Every scene on the bench that ships for it: the default bench first, then the others as scenes want them.
fn own_stages<'a>(suite: &'a Suite, overrides: &Overrides) -> Result<Vec<Stage<'a>>, Failure> {
    let mut names = vec![DEFAULT_BENCH];
    for member in &suite.members {
        let own = member.scene.value.own_bench();
        if !names.contains(&own) {
            names.push(own);
        }
    }
    let mut stages = Vec::new();
    for name in names {
        let of = |member: &&Member| member.scene.value.own_bench() == name;
        let members: Vec<&Member> = suite.members.iter().filter(of).collect();
        if !members.is_empty() || suite.members.is_empty() {
            stages.push((load_bench(name)?.with(overrides)?, members));
        }
    }
    Ok(stages)
}

/// Prints what would be tried, a line each: scene, bench, and the goldens that hold it or why it would not be tried.
///
/// # Errors
/// Settings of a scene that cannot be read, and an output that takes nothing.
pub(super) fn list(args: &TestArgs, stages: &[Stage], broken: &Broken) -> Result<(), Failure> {
    #[derive(Serialize)]
    struct Listed {
        trial: String,
        bench: String,
        file: Option<PathBuf>,
        goldens: Vec<&'static str>,
        refused: Option<String>,
        skipped: Option<String>,
    }
    let mut all = Vec::new();
    for (bench, members) in stages {
        for member in members {
            let goldens = goldens_of(member, bench);
            let (refused, skipped) = match why_not(member, bench, args)? {
                Some(TrialEnd::Refused(why)) => (Some(why), None),
                Some(end) => (None, Some(end.why().join("; "))),
                None => (None, None),
            };
            all.push(Listed {
                trial: member.scene.value.name.clone(),
                bench: bench.value.name.clone(),
                file: member.file.clone(),
                goldens: goldens.map_or_else(Vec::new, |g| g.kinds()),
                refused,
                skipped,
            });
        }
    }
    if args.voice.json {
        return print_json(&all);
    }
    print(|out| {
        for one in &all {
            let more = match (&one.refused, &one.skipped, one.goldens.is_empty()) {
                (Some(why), _, _) => format!("refused: {why}"),
                (_, Some(why), _) => format!("skipped: {why}"),
                (_, _, false) => format!("golden {}", one.goldens.join(" and ")),
                (_, _, true) => String::new(),
            };
            let line = format!("{:<26} on {:<16} {more}", one.trial, one.bench);
            writeln!(out, "{}", line.trim_end())?;
        }
        for (path, why) in broken {
            writeln!(out, "{}: {why}", path.display())?;
        }
        Ok(())
    })
}
