//! `hil texture`.

use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use palpate_core::texture::{Ends, Stream};
use palpate_core::units::Duration;
use palpate_files::TextureModel;
use palpate_run::Failure;
use palpate_texture::onnx;
use palpate_texture::rows::{Rows, Take};
use serde_json::json;

use super::{texture_panel, texture_train};
use crate::cli::{EncodeArgs, ExportArgs, TextureAction};
use crate::output::{note, print, write_file};

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
        TextureAction::Panel(args) => texture_panel::panel(args),
    }
}

/// The row a window ended with, and its latent vector.
type Latent = (usize, Vec<f32>);

fn micros(us: f64) -> Duration {
    Duration::from_micros(us.round() as u64)
}

fn encode(args: &EncodeArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let ends = match (args.soa_ms, args.rate) {
        (Some(soa_ms), Some(hz)) => Ends::Onsets {
            sample: micros(1e6 / hz),
            every: micros(soa_ms * 1e3),
        },
        _ => Ends::Every,
    };
    let found = latents(&model, &args.file, ends)?;
    print(|out| {
        if args.json {
            write_json(&found, out)
        } else {
            write_csv(&found, out)
        }
    })
}

/// Latent vectors of a recording's windows.
fn latents(model: &TextureModel, file: &Path, ends: Ends) -> Result<Vec<Latent>, Failure> {
    let take = Take::Features {
        names: model.feature_names(),
        count: model.features(),
    };
    let rows = Rows::read(file, take)?;
    let window = model.window();
    if rows.count() < window {
        return Err(Failure::Input(format!(
            "{}: expected at least {window} rows, one window, found {} rows",
            file.display(),
            rows.count()
        )));
    }
    let mut stream = Stream::new(Arc::new(model.encoder()?), 1);
    let mut found: Vec<Latent> = Vec::new();
    for (row, values) in rows.iter().enumerate() {
        let begin = ends.begins(row as u64, window);
        let latents = stream.push(values, begin).map_err(|e| {
            let (line, file) = (rows.line(row), file.display());
            Failure::Input(format!("{file}:{line}: {e}"))
        })?;
        if let Some(latents) = latents {
            found.push((row, latents.to_vec()));
        }
    }
    Ok(found)
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
