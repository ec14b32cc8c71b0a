//! `hil texture rebuild`: strokes through a model's bottleneck and back.

use palpate_files::{TextureDecoder, TextureModel, load_textures};
use palpate_live::output::{print, print_json};
use palpate_live::progress::Progress;
use palpate_run::Failure;
use palpate_texture::explore;
use palpate_texture::rebuild::{Part, Rebuilder, Rebuilt};
use serde_json::json;

use crate::cli::RebuildArgs;

/// Rebuilds strokes, and prints the error of each part of the training.
///
/// # Errors
/// A model without a decoder or for other features, a table that cannot be read.
pub fn rebuild(args: &RebuildArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let decoder = TextureDecoder::open(&args.model, &model)?;
    let rebuilder = Rebuilder::new(&model, &decoder)?;
    let table = load_textures(&args.of.textures)?.value;
    let shown = Progress::of_part("strokes");
    let strokes = explore::explore(&table, args.of.strokes, args.seed, |part| shown.part(part));
    drop(shown);
    let split = model.split().unwrap_or_default();
    let shown = Progress::of_part("windows");
    let mut found: Vec<(Part, Rebuilt)> = Vec::new();
    for (done, part) in Part::ALL.into_iter().enumerate() {
        shown.part(done as f64 / Part::ALL.len() as f64);
        let rebuilt = rebuilder.part(&strokes, &split, part)?;
        found.extend((rebuilt.windows > 0).then_some((part, rebuilt)));
    }
    drop(shown);
    let (layers, decoder) = (model.layers().iter(), decoder.parameters());
    let encoder: usize = layers.map(palpate_files::Layer::parameters).sum();
    if args.json {
        let parts = found.iter().map(|(part, rebuilt)| {
            let own = json!({"windows": rebuilt.windows, "error": rebuilt.error});
            (part.word().to_owned(), own)
        });
        return print_json(&json!({
            "source": "emulated strokes",
            "parameters": {"encoder": encoder, "decoder": decoder},
            "parts": parts.collect::<serde_json::Map<_, _>>(),
        }));
    }
    print(|out| {
        writeln!(out, "{encoder} parameters to z, {decoder} back.\n")?;
        writeln!(out, "emulated strokes  windows    error")?;
        for (part, rebuilt) in &found {
            let (windows, error) = (rebuilt.windows, rebuilt.error);
            writeln!(out, "{:<17} {windows:>7} {error:>8.5}", part.word())?;
        }
        Ok(())
    })
}
