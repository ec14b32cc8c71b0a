//! `hil texture`.

use std::io;
use std::path::Path;
use std::sync::Arc;

use palpate_core::texture::{Ends, Stream};
use palpate_core::units::Duration;
use palpate_files::{Format, Rows, Take, TextureModel};
use palpate_records::table::as_csv;
use palpate_run::Failure;
use palpate_texture::onnx;
use serde_json::json;

use super::{texture_panel, texture_response, texture_train};
use crate::cli::{EncodeArgs, ExportArgs, TextureAction};
use palpate_live::output::{Outputs, note, print};
use palpate_live::progress::Progress;

/// Runs the action of `hil texture`.
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
        TextureAction::Response(args) => texture_response::response(args),
        TextureAction::Materials(args) => texture_response::materials(args),
        TextureAction::Panel(args) => texture_panel::panel(args),
    }
}

/// The row a window ended with, and its latent vector.
type Latent = (usize, Vec<f32>);

fn micros(us: f64) -> Duration {
    Duration::from_micros(us.round() as u64)
}

/// Latent vectors that are printed together: what is wrong in the first rows is said before anything is printed.
const BATCH: usize = 1024;

fn encode(args: &EncodeArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    if let Some(hz) = args.rate {
        model.check_rate(hz)?;
    }
    let ends = match (args.soa_ms, args.rate) {
        (Some(soa_ms), Some(hz)) => Ends::Onsets {
            sample: micros(1e6 / hz),
            every: micros(soa_ms * 1e3),
        },
        _ => Ends::Every,
    };
    let take = match args.columns.as_deref() {
        Some(prefix) => Take::Counted(prefix, model.features()),
        None => features(&model),
    };
    let _shown = Progress::reading(&args.file);
    let mut windows = Windows::open(&model, &args.file, take, ends)?;
    let mut batch = Vec::new();
    let mut is_first = true;
    loop {
        let found = windows.advance()?;
        let is_last = found.is_none();
        batch.extend(found);
        if batch.len() < BATCH && !is_last {
            continue;
        }
        print(|out| match args.json {
            true => write_json(&batch, (is_first, is_last), out),
            false => write_csv(&batch, model.latents(), is_first, out),
        })?;
        is_first = false;
        batch.clear();
        if is_last {
            windows.rows.notes().iter().for_each(|text| note(text));
            return Ok(());
        }
    }
}

fn features(model: &TextureModel) -> Take<'_> {
    Take::Features {
        names: model.feature_names(),
        count: model.features(),
    }
}

/// The windows of a recording, one after another.
struct Windows<'a> {
    rows: Rows<std::fs::File>,
    stream: Stream,
    file: &'a Path,
    ends: Ends,
    window: usize,
    values: Vec<f32>,
}

impl<'a> Windows<'a> {
    fn open(
        model: &TextureModel,
        file: &'a Path,
        take: Take<'_>,
        ends: Ends,
    ) -> Result<Self, Failure> {
        Ok(Self {
            rows: Rows::open(file, take, None)?,
            stream: Stream::new(Arc::new(model.encoder()?), 1),
            file,
            ends,
            window: model.window(),
            values: Vec::new(),
        })
    }

    /// The next latent vector; none at the end.
    fn advance(&mut self) -> Result<Option<Latent>, Failure> {
        while let Some(at) = self.rows.advance(&mut self.values)? {
            let row = self.rows.count() - 1;
            let begin = self.ends.begins(row as u64, self.window);
            let latents = self.stream.push(&self.values, begin).map_err(|e| {
                let (line, file) = (at.line, self.file.display());
                Failure::Input(format!("{file}:{line}: {e}"))
            })?;
            if let Some(latents) = latents {
                return Ok(Some((row, latents.to_vec())));
            }
        }
        let (count, window) = (self.rows.count(), self.window);
        if count < window {
            return Err(Failure::Input(format!(
                "{}: expected at least {window} rows, one window, found {count} rows",
                self.file.display()
            )));
        }
        Ok(None)
    }
}

/// Six decimals: what differs between machines, if anything, lies below.
fn write_csv(
    found: &[Latent],
    latents: usize,
    begins: bool,
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let mut text = String::new();
    if begins {
        let names: Vec<String> = (1..=latents).map(|i| format!("z{i}")).collect();
        text = as_csv([("frame", names)]);
    }
    let figure = |z: &f32| format!("{:.6}", if z.abs() < 5e-7 { 0.0 } else { *z });
    let row = |(frame, z): &Latent| (*frame, z.iter().map(figure).collect::<Vec<_>>());
    text += &as_csv(found.iter().map(row));
    out.write_all(text.as_bytes())
}

/// A part of one array, with its ends where it has them.
fn write_json(
    found: &[Latent],
    (begins, ends): (bool, bool),
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let rounded = |z: &f32| (f64::from(*z) * 1e6).round() / 1e6 + 0.0;
    for (n, (frame, z)) in found.iter().enumerate() {
        out.write_all(if begins && n == 0 { b"[" } else { b"," })?;
        let z: Vec<f64> = z.iter().map(rounded).collect();
        serde_json::to_writer(&mut *out, &json!({"frame": frame, "z": z}))?;
    }
    match (begins && found.is_empty(), ends) {
        (true, true) => writeln!(out, "[]"),
        (false, true) => writeln!(out, "]"),
        _ => Ok(()),
    }
}

fn export(args: &ExportArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let bytes = onnx::encoder(&model);
    let outputs = Outputs::of(args.force);
    outputs.write(&args.out, Format::Onnx, |out| out.write_all(&bytes))?;
    note(&format!(
        "{}: input `raw` [{}, N, {}], output `latent` [N, {}]",
        args.out.display(),
        model.window(),
        model.features(),
        model.latents()
    ));
    Ok(())
}
