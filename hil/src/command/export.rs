//! `hil export`: what a scene makes, for other programs and for `hil run --replay`.

use std::path::{Path, PathBuf};

use palpate_files::{Columns, Format, Overrides, Setup, load_scene};
use palpate_fixtures::VIEWS;
use palpate_run::{Failure, taxels};

use super::devices::bench_with;
use crate::cli::{ExportKind, ExportTaxels, ExportViews};
use palpate_live::output::{Outputs, make_folder, note, print};
use palpate_live::progress::Progress;
use palpate_live::recording::write_taxel_csv;

/// Writes what was asked for.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn export(kind: &ExportKind) -> Result<(), Failure> {
    match kind {
        ExportKind::Taxels(args) => export_taxels(args),
        ExportKind::Views(args) => export_views(args),
    }
}

fn export_views(args: &ExportViews) -> Result<(), Failure> {
    let outputs = Outputs::new(args.force);
    let named = |name: &str| {
        let json = name.ends_with(".json");
        let format = if json { Format::Json } else { Format::Xml };
        (args.out.join(name), format)
    };
    for (name, _) in VIEWS {
        let (path, format) = named(name);
        outputs.check(&path, format)?;
    }
    make_folder(&args.out)?;
    for (name, text) in VIEWS {
        let (path, format) = named(name);
        outputs.write(&path, format, |out| out.write_all(text.as_bytes()))?;
    }
    print(|out| {
        for (name, _) in VIEWS {
            writeln!(out, "wrote {}", args.out.join(name).display())?;
        }
        writeln!(
            out,
            "next: hil run --record run.mcap, and open it with one of them"
        )
    })
}

fn export_taxels(args: &ExportTaxels) -> Result<(), Failure> {
    let mut overrides = Overrides::default();
    for text in &args.set {
        overrides.set("--set", text)?;
    }
    let scene = load_scene(&args.scene)?.with(&overrides)?;
    let bench = bench_with(Some(scene.value.own_bench()), &overrides, &[], &[])?;
    let setup = Setup::join(scene, bench)?;
    let sensor = &setup.sensor.value;
    let paths = paths(&args.out, sensor.modules.len());
    let outputs = Outputs::new(args.force);
    for path in &paths {
        outputs.check_csv(Some(path), "time_us,txl1_")?;
    }
    let shown = Progress::of_part("emulating the skin");
    let tables = taxels(&setup, args.seed, |part| shown.part(part))?;
    drop(shown);
    if !setup.scene.value.faults.is_empty() {
        note("the scene's faults are not in its readings");
    }
    for (module, (table, path)) in tables.iter().zip(&paths).enumerate() {
        let columns = Columns::of_module(sensor, module);
        let columns = columns.ok_or_else(|| {
            Failure::Input(format!("layout `{}` has no module {module}", sensor.name))
        })?;
        // Joints are the hand's: the first file has them.
        let joints = match module {
            0 => setup.scene.value.joints.as_slice(),
            _ => &[],
        };
        outputs.write(path, Format::Csv, |out| {
            write_taxel_csv(table, &columns, joints, out)
        })?;
    }
    print(|out| {
        for (table, path) in tables.iter().zip(&paths) {
            writeln!(out, "wrote {}, {} rows", path.display(), table.frames())?;
        }
        let replays = paths
            .iter()
            .map(|path| format!(" --replay {}", path.display()));
        let replays: String = replays.collect();
        writeln!(out, "next: hil run {}{replays}", args.scene)
    })
}

/// One file per module: the name itself for one, numbered for several.
fn paths(out: &Path, modules: usize) -> Vec<PathBuf> {
    if modules == 1 {
        return vec![out.to_path_buf()];
    }
    let part = |part: Option<&std::ffi::OsStr>| part.map(|p| p.to_string_lossy().into_owned());
    let stem = part(out.file_stem()).unwrap_or_default();
    let ending = part(out.extension()).map_or_else(String::new, |e| format!(".{e}"));
    let name = |module| out.with_file_name(format!("{stem}-{module}{ending}"));
    (0..modules).map(name).collect()
}
