//! `hil texture`.

use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use palpate_core::illusion::Display;
use palpate_core::texture::{Draw, Ends, Pulses, Stream, along};
use palpate_core::units::{Board, Channel, Duration, Instant, Point, Prescale};
use palpate_files::{LayoutFile, TextureModel, load_activation, load_layout};
use palpate_run::Failure;
use palpate_run::plan;
use palpate_texture::onnx;
use palpate_texture::rows::{Rows, Take};
use serde_json::json;

use super::{texture_panel, texture_train};
use crate::cli::{DrawArg, EncodeArgs, ExportArgs, PulsesArgs, TextureAction};
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
        TextureAction::Pulses(args) => pulses(args),
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

/// The windows that are newest at each onset.
fn onsets(rate_hz: f64, soa_ms: f64) -> Ends {
    Ends::Onsets {
        sample: micros(1e6 / rate_hz),
        every: micros(soa_ms * 1e3),
    }
}

fn encode(args: &EncodeArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let ends = match (args.soa_ms, args.rate) {
        (Some(soa_ms), Some(hz)) => onsets(hz, soa_ms),
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

/// Nominal carrier: PRE_SCALE 30, 196.89 Hz.
const CARRIER: Prescale = Prescale::new(30);

fn pulses(args: &PulsesArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let loaded = load_activation(&args.activation)?;
    let bad = |what: String| Failure::File(loaded.source.bad("beta", what));
    let activation = loaded
        .value
        .activation()
        .ok_or_else(|| bad("a sum below 1".into()))?;
    let map = loaded
        .value
        .map(model.driver()?)
        .map_err(|e| Failure::Input(format!("{}: metadata.latent: expected {e}", args.model)))?;
    let display = display(&args.display)?;
    let places: Vec<Point> = display.wires().iter().map(|w| w.place).collect();
    let draw = match args.draw {
        DrawArg::Bernoulli => Draw::Bernoulli,
        DrawArg::Diffusion => Draw::Diffusion,
    };
    let gaps = along(&places, display.gap());
    let mut pulses = Pulses::new(activation, draw, CARRIER, &gaps, args.seed);
    let ends = onsets(args.rate, args.soa_ms);
    let found = latents(&model, &args.file, ends)?;
    let at = |(row, _): &Latent| Instant::ZERO + micros(*row as f64 * 1e6 / args.rate);
    print(|out| {
        writeln!(out, "period,time_us,wire")?;
        let Some(first) = found.first().map(at) else {
            return Ok(());
        };
        let mut period = 0_u64;
        for (n, latent) in found.iter().enumerate() {
            let control = map.control(&latent.1);
            // The last one stands for one onset.
            let soa = micros(args.soa_ms * 1e3);
            let until = found.get(n + 1).map_or(at(latent) + soa, at).since(first);
            while pulses.at().since(Instant::ZERO) < until {
                let time = first + pulses.at().since(Instant::ZERO);
                for (wire, _) in pulses
                    .next(&control)
                    .iter()
                    .enumerate()
                    .filter(|(_, fired)| **fired)
                {
                    writeln!(out, "{period},{},{wire}", time.as_micros())?;
                }
                period += 1;
            }
        }
        Ok(())
    })
}

/// A display by itself, its wires on the outputs of as many boards as it takes.
fn display(name: &str) -> Result<Display, Failure> {
    match load_layout(name)?.value {
        LayoutFile::Display(file) => plan::display_of(&file, |wire| {
            (Board((wire / 16) as u8), Channel((wire % 16) as u8))
        }),
        LayoutFile::Sensor(_) => Err(Failure::Input(format!(
            "--display: {name}: expected a layout of kind \"display\", found a skin"
        ))),
    }
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
