//! `hil texture strokes`, `train` and `map`: from surfaces to a model, and a look at what it has learnt.

use std::path::PathBuf;
use std::process::Command;

use palpate_emulators::sensor::surface::{Explorer, Habits};
use palpate_files::{Format, TextureModel, load_textures};
use palpate_run::Failure;
use palpate_run::plan::surface;
use palpate_texture::{draw, explore, map, round};

use crate::cli::{MapArgs, StrokesArgs, TrainArgs};
use palpate_live::output::{Outputs, make_folder, note, print};
use palpate_live::progress::Progress;

/// The training program: a workspace member that only those build who train.
const PROGRAM: &str = "palpate-train";

/// Writes strokes over emulated textures as recordings.
///
/// # Errors
/// A table that cannot be read, a folder that cannot be written.
pub fn strokes(args: &StrokesArgs) -> Result<(), Failure> {
    let table = load_textures(&args.of.textures)?.value;
    let shown = Progress::of_part("strokes");
    let habits = if args.varied {
        Habits::varied()
    } else {
        Habits::default()
    };
    let mut explorer = Explorer::new(habits, table.dead_taxel, args.seed).with_rate(args.rate);
    if args.accelerometer {
        explorer = explorer.with_accelerometer();
    }
    let of = (&table, surface as fn(&_) -> _);
    let all = explore::explore_as(of, args.of.strokes, &mut explorer, |part| shown.part(part));
    drop(shown);
    make_folder(&args.out)?;
    let shaken = args.out.join("accelerometer");
    if args.accelerometer {
        make_folder(&shaken)?;
    }
    let outputs = Outputs::new(args.force);
    for (entry, recording) in &all {
        let name = format!("{}_{:02}.csv", entry.name, recording.number);
        let path = args.out.join(&name);
        outputs.check_csv(Some(&path), "txl1_x,")?;
        outputs.write(&path, Format::Csv, |out| {
            explore::write_rows(recording, out)
        })?;
        if args.accelerometer {
            let path = shaken.join(&name);
            outputs.check_csv(Some(&path), "x_mg,")?;
            outputs.write(&path, Format::Csv, |out| {
                explore::write_acceleration(recording, out)
            })?;
        }
    }
    outputs.write(&args.out.join("materials.csv"), Format::Csv, |out| {
        explore::write_materials(&table, out)
    })?;
    let is_rated = table.texture.iter().any(|t| t.rated.is_some());
    if is_rated {
        outputs.write(&args.out.join("ratings.csv"), Format::Csv, |out| {
            explore::write_ratings(&table, out)
        })?;
    }
    let ratings = if is_rated { ", ratings.csv" } else { "" };
    let fast = if args.accelerometer {
        ", accelerometer/"
    } else {
        ""
    };
    note(&format!(
        "{}: {} emulated recordings, materials.csv{ratings}{fast}",
        args.out.display(),
        all.len()
    ));
    Ok(())
}

/// Runs the training program with the rest of the command line.
///
/// # Errors
/// The line that builds it, where it is not there; its own failure.
pub fn train(args: &TrainArgs) -> Result<(), Failure> {
    let name = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe()
        .ok()
        .and_then(|hil| Some(hil.parent()?.join(&name)));
    let program = beside
        .filter(|p| p.is_file())
        .unwrap_or_else(|| PathBuf::from(&name));
    match Command::new(&program).args(&args.arguments).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(match status.code() {
            Some(2) => Failure::Input(String::new()),
            _ => Failure::Check(String::new()),
        }),
        Err(_) => Err(Failure::Input(format!(
            "{name} is not beside hil and not on the PATH: no archive has it. In the sources ({}) `cargo build --release -p {PROGRAM}` builds it",
            env!("CARGO_PKG_REPOSITORY")
        ))),
    }
}

/// Draws the latent map and says how it goes with the surfaces.
///
/// # Errors
/// A model or table that cannot be read, a file that cannot be written.
pub fn map(args: &MapArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let table = load_textures(&args.of.textures)?.value;
    let shown = Progress::of_part("strokes");
    let strokes = explore::explore(&table, args.of.strokes, args.seed, |part| shown.part(part));
    drop(shown);
    let shown = Progress::of_part("latent vectors");
    let encoded = explore::encode(&model, &strokes, |part| shown.part(part))?;
    drop(shown);
    let view = map::View::new(&model);
    let placed = map::place(&encoded, &model, view);
    let outputs = Outputs::new(args.force);
    outputs.write_some(args.svg.as_deref(), Format::Svg, || {
        let title = format!("Where {} puts {} textures", args.model, table.texture.len());
        draw::draw(&placed, view, &title)
    })?;
    print(|out| {
        writeln!(out, "x: {}, y: {}", view.x.label(), view.y.label())?;
        writeln!(out, "emulated              x        y     long    short")?;
        for texture in &placed {
            let (name, spot) = (&texture.entry.name, texture.spot);
            write!(out, "{name:<14}")?;
            for figure in [spot.mean.0, spot.mean.1, spot.half.0, spot.half.1] {
                write!(out, " {:>8.3}", round(figure))?;
            }
            let unseen = if texture.is_trained { "" } else { "  unseen" };
            writeln!(out, "{unseen}")?;
        }
        writeln!(
            out,
            "\nrank correlation                            all   unseen"
        )?;
        for rank in map::ranks(&placed) {
            let (what, all, unseen) = (rank.what, rank.all, rank.unseen);
            writeln!(out, "{what:<38} {all:>8.2} {unseen:>8.2}")?;
        }
        let outside = table.texture.iter().map(|t| (t, model.extrapolated(t)));
        let outside = outside.filter(|(_, all)| !all.is_empty());
        for (n, (entry, all)) in outside.enumerate() {
            let apart = if n == 0 { "\n" } else { "" };
            writeln!(
                out,
                "{apart}{}: EXTRAPOLATED: {}",
                entry.name,
                all.join(", ")
            )?;
        }
        Ok(())
    })
}
