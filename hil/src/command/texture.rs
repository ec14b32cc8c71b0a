//! `hil texture`.

use std::io::{self, Write};
use std::sync::Arc;

use palpate_core::texture::{Ends, Stream, Weights};
use palpate_core::units::Duration;
use serde_json::json;

use super::texture_train;
use crate::cli::{EncodeArgs, ExportArgs, TextureAction, WeightsArg};
use crate::failure::Failure;
use crate::output::{note, print, write_file};
use crate::texture::{Rows, TextureModel, onnx};

/// Does what was asked with the texture model.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn texture(action: &TextureAction) -> Result<(), Failure> {
    match action {
        TextureAction::Strokes(args) => texture_train::strokes(args),
        TextureAction::Train(args) => texture_train::train(args),
        TextureAction::Encode(args) => encode(args),
        TextureAction::Export(args) => export(args),
        TextureAction::Map(args) => texture_train::map(args),
    }
}

/// The row a window ended with, and its latent vector.
type Latent = (usize, Vec<f32>);

fn encode(args: &EncodeArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let rows = Rows::read(&args.file, model.features(), model.feature_names())?;
    let weights = match args.weights {
        WeightsArg::Exact => Weights::Exact,
        WeightsArg::Half => Weights::Half,
    };
    let window = model.window();
    if rows.count() < window {
        let found = format!("{} rows", rows.count());
        return Err(Failure::Input(format!(
            "{}: expected at least {window} rows, one window, found {found}",
            args.file.display()
        )));
    }
    let encoder = model.encoder(weights)?;
    let encoder = match args.steps {
        Some(steps) if steps > window => {
            return Err(Failure::Input(format!(
                "--steps: expected at most {window}, the model's window, found {steps}"
            )));
        }
        Some(steps) => encoder.with_steps(steps),
        None => encoder,
    };
    let micros = |us: f64| Duration::from_micros(us.round() as u64);
    let ends = match (args.soa_ms, args.rate) {
        (Some(soa), Some(hz)) => Ends::Onsets {
            sample: micros(1e6 / hz),
            every: micros(soa * 1e3),
        },
        _ => Ends::Every,
    };
    let mut stream = Stream::new(Arc::new(encoder), 1);
    let mut found: Vec<Latent> = Vec::new();
    for (row, values) in rows.iter().enumerate() {
        let begin = ends.begins(row as u64, window);
        let latents = stream.push(values, begin).map_err(|e| {
            let (line, file) = (rows.line(row), args.file.display());
            Failure::Input(format!("{file}:{line}: {e}"))
        })?;
        if let Some(latents) = latents {
            found.push((row, latents.to_vec()));
        }
    }
    print(|out| {
        if args.json {
            write_json(&found, out)
        } else {
            write_csv(&found, out)
        }
    })
}

/// Six decimals: what differs between machines, if anything, lies below.
fn write_csv(found: &[Latent], out: &mut dyn Write) -> io::Result<()> {
    let latents = found.first().map_or(0, |(_, z)| z.len());
    write!(out, "frame")?;
    for i in 1..=latents {
        write!(out, ",z{i}")?;
    }
    writeln!(out)?;
    for (frame, latent) in found {
        write!(out, "{frame}")?;
        for z in latent {
            write!(out, ",{:.6}", if z.abs() < 5e-7 { 0.0 } else { *z })?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn write_json(found: &[Latent], out: &mut dyn Write) -> io::Result<()> {
    let rounded = |z: &f32| (f64::from(*z) * 1e6).round() / 1e6 + 0.0;
    let objects = found
        .iter()
        .map(|(frame, z)| json!({"frame": frame, "z": z.iter().map(rounded).collect::<Vec<_>>()}));
    serde_json::to_writer(&mut *out, &objects.collect::<Vec<_>>())?;
    writeln!(out)
}

fn export(args: &ExportArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let bytes = onnx::encoder(&model);
    write_file(&args.out, |out| out.write_all(&bytes))?;
    note(&format!(
        "{}: input `raw` [{}, N, {}], output `latent` [N, {}]",
        args.out.display(),
        model.window(),
        model.features(),
        model.latents()
    ));
    Ok(())
}
