//! `hil texture strokes`, `train` and `map`: from surfaces to a model, and a look at what it has learnt.

use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::cli::{MapArgs, StrokesArgs, TrainArgs};
use crate::failure::Failure;
use crate::output::{make_folder, note, print, write_file};
use crate::texture::{TextureModel, draw, explore, map};
use palpate_files::load_textures;

/// The training program: a workspace member that only those build who train.
const PROGRAM: &str = "palpate-train";

/// Writes strokes over emulated textures as recordings.
///
/// # Errors
/// A table that cannot be read, a folder that cannot be written.
pub fn strokes(args: &StrokesArgs) -> Result<(), Failure> {
    let table = load_textures(&args.textures)?.value;
    let all = explore::explore(&table, args.strokes, args.seed);
    make_folder(&args.out)?;
    explore::write(&args.out, &table, &all)?;
    note(&format!(
        "{}: {} emulated recordings and ratings.csv",
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
            "{name} is not beside hil and not on the PATH: build it with `cargo build --release -p {PROGRAM}`"
        ))),
    }
}

/// Draws the latent map and says how it goes with the surfaces.
///
/// # Errors
/// A model or table that cannot be read, a file that cannot be written.
pub fn map(args: &MapArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let table = load_textures(&args.textures)?.value;
    let strokes = explore::explore(&table, args.strokes, args.seed);
    let encoded = explore::encode(&model, &strokes)?;
    let view = map::View::of(&model);
    let figures = map::figures(&encoded, view);
    if let Some(path) = &args.svg {
        let title = format!("Where {} puts {} textures", args.model, table.texture.len());
        write_file(path, |out| {
            out.write_all(draw::draw(&encoded, view, &title).as_bytes())
        })?;
    }
    print(|out| {
        if args.json {
            return writeln!(out, "{figures}");
        }
        writeln!(out, "x: {}, y: {}", view.x.label(), view.y.label())?;
        writeln!(
            out,
            "{:<14} {:>8} {:>8} {:>8} {:>8}",
            "emulated", "x", "y", "long", "short"
        )?;
        for t in figures["textures"].as_array().into_iter().flatten() {
            let unseen = if t["trained"] == false {
                "  unseen"
            } else {
                ""
            };
            let name = t["name"].as_str().unwrap_or_default();
            let number = |v: &Value| format!("{:.3}", v.as_f64().unwrap_or(f64::NAN));
            let (long, short) = (number(&t["half_axes"][0]), number(&t["half_axes"][1]));
            let (x, y) = (number(&t["x"]), number(&t["y"]));
            writeln!(out, "{name:<14} {x:>8} {y:>8} {long:>8} {short:>8}{unseen}")?;
        }
        writeln!(
            out,
            "\n{:<38} {:>8} {:>8}",
            "rank correlation", "all", "unseen"
        )?;
        for row in figures["spearman"].as_array().into_iter().flatten() {
            let number = |key: &str| format!("{:.2}", row[key].as_f64().unwrap_or(f64::NAN));
            let what = row["what"].as_str().unwrap_or_default();
            writeln!(
                out,
                "{what:<38} {:>8} {:>8}",
                number("all"),
                number("unseen")
            )?;
        }
        Ok(())
    })
}
