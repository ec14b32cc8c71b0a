//! `hil texture`.

use std::io;
use std::sync::Arc;

use palpate_core::statistics::quantile;
use palpate_core::texture::{Ends, Stream};
use palpate_core::units::Duration;
use palpate_files::{Format, Input, RecipePlan, Rows, Take, TextureDecoder, TextureModel, Timing};
use palpate_records::table::as_csv;
use palpate_run::Failure;
use palpate_texture::onnx;
use palpate_texture::rebuild::Rebuilder;
use serde_json::json;

use super::{texture_panel, texture_rebuild, texture_response, texture_train};
use crate::cli::{EncodeArgs, ExportArgs, TextureAction};
use palpate_live::output::{Outputs, note, print};
use palpate_live::progress::Progress;
use palpate_live::recording::Recorded;

/// Runs the action of `hil texture`.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn texture(action: &TextureAction) -> Result<(), Failure> {
    match action {
        TextureAction::Strokes(args) => texture_train::strokes(args),
        TextureAction::Train(args) => texture_train::train(args),
        TextureAction::Encode(args) => encode(args),
        TextureAction::Rebuild(args) => texture_rebuild::rebuild(args),
        TextureAction::Export(args) => export(args),
        TextureAction::Map(args) => texture_train::map(args),
        TextureAction::Response(args) => texture_response::response(args),
        TextureAction::Materials(args) => texture_response::materials(args),
        TextureAction::Panel(args) => texture_panel::panel(args),
    }
}

/// A window that was encoded.
struct Latent {
    /// The row that it ended with.
    frame: usize,
    z: Vec<f32>,
    /// Error of the window that the decoder makes of z.
    error: Option<f64>,
}

fn micros(us: f64) -> Duration {
    Duration::from_micros(us.round() as u64)
}

/// Share of a feature's range by which a value may lie beyond it and still be known.
const MARGIN: f32 = 0.05;

/// Latent vectors that are printed together: what is wrong in the first rows is said before anything is printed.
const BATCH: usize = 1024;

fn encode(args: &EncodeArgs) -> Result<(), Failure> {
    let (args, plan) = &by_recipe(args)?;
    let model = TextureModel::open(&args.model)?;
    if let (Some(hz), false) = (args.rate, args.any_rate) {
        model.check_rate(hz)?;
    }
    let ends = match (args.soa_ms, args.rate) {
        (Some(soa_ms), Some(hz)) => Ends::Onsets {
            sample: micros(1e6 / hz),
            every: micros(soa_ms * 1e3),
        },
        _ => Ends::Every,
    };
    let take = match (plan, args.columns.as_deref()) {
        (Some(plan), _) => {
            check_count(args, plan, &model)?;
            Take::Recipe(plan)
        }
        (None, Some(prefix)) => Take::Counted(prefix, model.features()),
        (None, None) => features(&model),
    };
    let decoder = args
        .error
        .then(|| TextureDecoder::open(&args.model, &model));
    let decoder = decoder.transpose()?;
    let rebuilder = decoder.as_ref().map(|d| Rebuilder::new(&model, d));
    let _shown = Progress::reading(&args.file);
    let mut windows = Windows::open(&model, args, take, ends)?;
    windows.rebuilder = rebuilder.transpose()?;
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
            false => write_csv(&batch, (model.latents(), args), is_first, out),
        })?;
        is_first = false;
        batch.clear();
        if is_last {
            windows.notes().iter().for_each(|text| note(text));
            return Ok(());
        }
    }
}

/// The command line with what the recipe says in place of what was left out, and the recipe.
fn by_recipe(args: &EncodeArgs) -> Result<(EncodeArgs, Option<RecipePlan>), Failure> {
    let mut args = args.clone();
    if args.columns.is_some() {
        return Ok((args, None));
    }
    let recorded = Recorded::find(args.recipe.as_deref(), &args.file)?;
    recorded.note().iter().for_each(|text| note(text));
    args.time = args.time.or_else(|| recorded.time(args.rate));
    if args.time.is_none() {
        args.rate = args.rate.or_else(|| recorded.rate_hz());
    }
    let plan = recorded.own_plan()?;
    args.file = recorded.file;
    Ok((args, plan))
}

/// Refuses a recipe for another number of readings than the model has.
fn check_count(args: &EncodeArgs, plan: &RecipePlan, model: &TextureModel) -> Result<(), Failure> {
    let (wanted, found) = (model.features(), plan.count());
    match wanted == found {
        true => Ok(()),
        false => Err(Failure::Input(format!(
            "{}: expected a recipe of {wanted} readings, as many as the model has features, found {found} (--columns PREFIX reads without it)",
            args.file.display()
        ))),
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
    model: &'a TextureModel,
    args: &'a EncodeArgs,
    /// Times of the first rows, until the first window is full.
    times: Vec<u64>,
    /// The rate, where it is another than the model's and was asked for.
    other_hz: Option<f64>,
    /// Values, and those beyond what the model was trained on.
    values_seen: u64,
    beyond: u64,
    rows: Rows<Input>,
    stream: Stream,
    ends: Ends,
    window: usize,
    values: Vec<f32>,
    /// The way back to each window, and the values of its rows, the newest last; none where no error is asked for.
    rebuilder: Option<Rebuilder<'a>>,
    kept: Vec<f32>,
}

impl<'a> Windows<'a> {
    fn open(
        model: &'a TextureModel,
        args: &'a EncodeArgs,
        take: Take<'_>,
        ends: Ends,
    ) -> Result<Self, Failure> {
        Ok(Self {
            // Without a column of times the rows are taken for the model's.
            rows: Rows::open(
                &args.file,
                take,
                Some(&Timing {
                    column: args.time.clone(),
                    rate_hz: args.rate.or(model.rate_hz()).or(Some(1.0)),
                    ..Timing::default()
                }),
            )?,
            model,
            args,
            times: Vec::new(),
            other_hz: None,
            values_seen: 0,
            beyond: 0,
            stream: Stream::new(Arc::new(model.encoder()?), 1),
            ends,
            window: model.window(),
            values: Vec::new(),
            rebuilder: None,
            kept: Vec::new(),
        })
    }

    /// Looks at a row before it is encoded: when it came, and what the model knows of its values.
    ///
    /// # Errors
    /// Rows of another rate than `--rate` says or the model was trained on, once a window is full.
    fn look(&mut self, time_us: u64) -> Result<(), Failure> {
        let beyond = self.model.with(|model| {
            let ranges = model.scale_min.iter().zip(model.scale_max);
            let known = |(value, (low, high)): &(&f32, (&f32, &f32))| {
                let margin = MARGIN * (**high - **low);
                (**low - margin..=**high + margin).contains(*value)
            };
            self.values.iter().zip(ranges).filter(|v| !known(v)).count()
        });
        self.beyond += beyond as u64;
        self.values_seen += self.values.len() as u64;
        if self.times.len() > self.window.max(2) {
            return Ok(());
        }
        self.times.push(time_us);
        if self.times.len() != self.window.max(2) {
            return Ok(());
        }
        let steps = self
            .times
            .windows(2)
            .map(|pair| pair[1].saturating_sub(pair[0]));
        let mut steps: Vec<u64> = steps.collect();
        steps.sort_unstable();
        let usual = quantile(&steps, 0.5).map_or(0, |middle| middle.above);
        let hz = 1e6 / usual.max(1) as f64;
        if let Some(said) = self.args.rate.filter(|said| (hz / said - 1.0).abs() > 0.01) {
            return Err(Failure::Input(format!(
                "{}: expected rows at {said} Hz, as --rate says, found {hz:.1} Hz in their times (leave out --rate, or correct either)",
                self.args.file.display()
            )));
        }
        match self.model.check_rate(hz) {
            Ok(()) => {}
            Err(_) if self.args.any_rate => self.other_hz = Some(hz),
            Err(error) => {
                return Err(Failure::Input(format!(
                    "{}: {error} (--any-rate encodes them all the same)",
                    self.args.file.display()
                )));
            }
        }
        Ok(())
    }

    /// Remarks on the recording, once its end is reached.
    fn notes(&mut self) -> Vec<String> {
        let mut notes = self.rows.notes();
        let known = self.model.rate_hz();
        notes.extend(
            self.other_hz.zip(known).map(|(hz, known)| {
                format!("EXTRAPOLATED: rows at {hz:.1} Hz (learned {known} Hz)")
            }),
        );
        if self.beyond > 0 {
            let share = 100.0 * self.beyond as f64 / self.values_seen as f64;
            notes.push(format!(
                "EXTRAPOLATED: {share:.1} % of the values lie beyond what the model was trained on"
            ));
        }
        notes
    }

    /// The next latent vector; none at the end.
    fn advance(&mut self) -> Result<Option<Latent>, Failure> {
        while let Some(at) = self.rows.advance(&mut self.values)? {
            let row = self.rows.count() - 1;
            self.look(at.time_us)?;
            let begin = self.ends.begins(row as u64, self.window);
            let latents = self.stream.push(&self.values, begin).map_err(|e| {
                let (line, file) = (at.line, self.args.file.display());
                Failure::Input(format!("{file}:{line}: {e}"))
            })?;
            let z = latents.map(<[f32]>::to_vec);
            if self.rebuilder.is_some() {
                let full = (self.window - 1) * self.values.len();
                let old = self.kept.len().saturating_sub(full);
                self.kept.drain(..old);
                self.kept.extend_from_slice(&self.values);
            }
            if let Some(z) = z {
                let error = self.rebuilder.as_ref().map(|r| r.error(&self.kept));
                return Ok(Some(Latent {
                    frame: row,
                    z,
                    error: error.transpose()?,
                }));
            }
        }
        let (count, window) = (self.rows.count(), self.window);
        if count < window {
            return Err(Failure::Input(format!(
                "{}: expected at least {window} rows, one window, found {count} rows",
                self.args.file.display()
            )));
        }
        Ok(None)
    }
}

/// Six decimals: what differs between machines, if anything, lies below.
fn write_csv(
    found: &[Latent],
    (latents, args): (usize, &EncodeArgs),
    begins: bool,
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let mut text = String::new();
    if begins {
        let names = (1..=latents).map(|i| format!("z{i}"));
        let error = args.error.then(|| "error".to_owned());
        text = as_csv([("frame", names.chain(error).collect::<Vec<_>>())]);
    }
    let figure = |z: f64| format!("{:.6}", if z.abs() < 5e-7 { 0.0 } else { z });
    let row = |found: &Latent| {
        let z = found.z.iter().copied().map(f64::from);
        let figures = z.chain(found.error).map(figure);
        (found.frame, figures.collect::<Vec<_>>())
    };
    text += &as_csv(found.iter().map(row));
    out.write_all(text.as_bytes())
}

/// A part of one array, with its ends where it has them.
fn write_json(
    found: &[Latent],
    (begins, ends): (bool, bool),
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let rounded = |z: f64| (z * 1e6).round() / 1e6 + 0.0;
    for (n, found) in found.iter().enumerate() {
        out.write_all(if begins && n == 0 { b"[" } else { b"," })?;
        let z: Vec<f64> = found.z.iter().map(|z| rounded(f64::from(*z))).collect();
        let mut one = json!({"frame": found.frame, "z": z});
        if let Some(error) = found.error {
            one["error"] = json!(rounded(error));
        }
        serde_json::to_writer(&mut *out, &one)?;
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
    let outputs = Outputs::new(args.force);
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
