//! Strokes over a table of textures: as recordings on disk, and as latent vectors of a model.

use std::io::{self, Write};
use std::path::Path;

use palpate_core::texture::Weights;
use palpate_emulators::surface::{Explorer, Habits, Recording, Texture};

use super::{TextureModel, taxel};
use crate::failure::Failure;
use crate::output::write_file;
use palpate_files::{TextureEntry, TextureTable};

/// A texture as the emulators take it.
pub fn surface(entry: &TextureEntry) -> Texture {
    Texture {
        name: entry.name.clone(),
        stiffness_n_per_mm: entry.stiffness_n_per_mm,
        relief_mm: entry.relief_um / 1000.0,
        wavelength_mm: entry.wavelength_mm,
        octaves: entry.octaves,
        friction: entry.friction,
    }
}

/// Every texture of the table stroked `strokes` times by one person with one module.
pub fn explore(table: &TextureTable, strokes: u32, seed: u64) -> Vec<(&TextureEntry, Recording)> {
    let mut explorer = Explorer::new(Habits::default(), table.dead_taxel, seed);
    let mut all = Vec::new();
    for entry in &table.texture {
        let surface = surface(entry);
        for number in 0..strokes {
            all.push((entry, explorer.stroke(&surface, number)));
        }
    }
    all
}

/// Writes recordings as `NAME_NUMBER.csv` and the ratings beside them: what the training program reads.
///
/// # Errors
/// A file that cannot be written.
pub fn write(
    folder: &Path,
    table: &TextureTable,
    all: &[(&TextureEntry, Recording)],
) -> Result<(), Failure> {
    for (entry, recording) in all {
        let path = folder.join(format!("{}_{:02}.csv", entry.name, recording.number));
        write_file(&path, |out| write_rows(recording, out))?;
    }
    write_file(&folder.join("ratings.csv"), |out| {
        writeln!(out, "label,trained,hardness,roughness,friction")?;
        for t in &table.texture {
            let r = t.rated;
            writeln!(
                out,
                "{},{},{},{},{}",
                t.name, t.trained, r.hardness, r.roughness, r.friction
            )?;
        }
        Ok(())
    })
}

fn write_rows(recording: &Recording, out: &mut dyn Write) -> io::Result<()> {
    let taxels = recording.rows.first().map_or(0, Vec::len);
    let header = |t: usize| format!("txl{t}_x,txl{t}_y,txl{t}_z");
    writeln!(
        out,
        "{}",
        (1..=taxels).map(header).collect::<Vec<_>>().join(",")
    )?;
    for row in &recording.rows {
        let cells = row.iter().map(|r| format!("{},{},{}", r.x, r.y, r.z));
        writeln!(out, "{}", cells.collect::<Vec<_>>().join(","))?;
    }
    Ok(())
}

/// What a model makes of a stroke: the latent vector of every tenth window.
pub struct Encoded<'a> {
    /// What was stroked.
    pub entry: &'a TextureEntry,
    /// Latent vectors, in the order of time.
    pub latents: Vec<Vec<f32>>,
}

/// Rows from one encoded window to the next: neighbours are nearly the same.
const HOP: usize = 10;

/// Encodes strokes.
///
/// # Errors
/// A model whose features are no columns of a flat module.
pub fn encode<'a>(
    model: &TextureModel,
    all: &[(&'a TextureEntry, Recording)],
) -> Result<Vec<Encoded<'a>>, Failure> {
    let encoder = model.encoder(Weights::Exact)?;
    let mut room = encoder.room(1);
    let length = encoder.window() * encoder.features();
    let mut encoded = Vec::with_capacity(all.len());
    for &(entry, ref recording) in all {
        let values = features(model, recording)?;
        if values.len() < length {
            let found = format!("a model with windows of {}", encoder.window());
            let expected = format!("expected windows of at most {} rows", recording.rows.len());
            return Err(Failure::Input(format!(
                "{expected}, the length of a stroke; found {found}"
            )));
        }
        let mut latents = Vec::new();
        for first in (0..=values.len() - length).step_by(HOP * encoder.features()) {
            let z = encoder
                .encode(&mut room, &values[first..first + length])
                .map_err(|e| Failure::Input(format!("{}: {e}", entry.name)))?;
            latents.push(z.to_vec());
        }
        encoded.push(Encoded { entry, latents });
    }
    Ok(encoded)
}

/// A stroke as a model takes it: the readings that are its features, row after row.
///
/// # Errors
/// A model whose features are no columns of a flat module.
pub fn features(model: &TextureModel, recording: &Recording) -> Result<Vec<f32>, Failure> {
    let columns = columns(model)?;
    let mut values = Vec::with_capacity(recording.rows.len() * columns.len());
    for row in &recording.rows {
        let reading = |&(taxel, axis): &(usize, usize)| {
            row.get(taxel)
                .map_or(0.0, |r| f32::from([r.x, r.y, r.z][axis]))
        };
        values.extend(columns.iter().map(reading));
    }
    Ok(values)
}

/// Taxel and axis of each of the model's features.
fn columns(model: &TextureModel) -> Result<Vec<(usize, usize)>, Failure> {
    let place = |name: &String| taxel(name).filter(|(taxel, _)| *taxel < 16);
    let found: Option<Vec<_>> = model.feature_names().iter().map(place).collect();
    found.filter(|c| !c.is_empty()).ok_or_else(|| {
        let expected =
            "expected features of a flat module, txl1_x to txl16_z; this model has others";
        Failure::Input(format!("{expected}, or does not name them"))
    })
}

#[cfg(test)]
mod tests {
    use super::super::draw;
    use super::super::map::{self, Axis, View};
    use super::*;
    use crate::texture::seeded::Seeded;
    use palpate_files::load_textures;

    fn model(features: &str, count: usize) -> TextureModel {
        let bytes = Seeded::new(3, &[count, 8, 3], 100, 1.0).file().unwrap();
        let text = String::from_utf8_lossy(&bytes[8..]).into_owned();
        let end = text.find("\"window\"").unwrap();
        let header = format!("\"features\":\"{features}\",");
        let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) + header.len() as u64;
        let mut out = length.to_le_bytes().to_vec();
        out.extend(&bytes[8..8 + end]);
        out.extend(header.as_bytes());
        out.extend(&bytes[8 + end..]);
        TextureModel::parse("test", &out).unwrap()
    }

    #[test]
    fn strokes_are_reproduced_and_encoded_by_the_columns_names() {
        let table = load_textures("thesis").unwrap().value;
        let all = explore(&table, 2, 5);
        assert_eq!(all.len(), 16);
        assert!(all == explore(&table, 2, 5) && all != explore(&table, 2, 6));
        let mut text = Vec::new();
        write_rows(&all[0].1, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert_eq!(text.lines().count(), 201);
        assert!(text.starts_with("txl1_x,txl1_y,txl1_z,txl2_x"));
        assert!(text.lines().all(|line| line.split(',').count() == 48));

        let encoded = encode(&model("txl1_z,txl9_x", 2), &all).unwrap();
        assert_eq!(
            (
                encoded.len(),
                encoded[0].latents.len(),
                encoded[0].latents[0].len()
            ),
            (16, 11, 3)
        );
        let refused = encode(&model("proximity1,channel2", 2), &all);
        assert!(refused.is_err_and(|e| e.to_string().contains("txl1_x to txl16_z")));

        let axis = |coordinate, sign| Axis {
            coordinate,
            sign,
            stands_for: "",
        };
        let view = View {
            x: axis(0, 1),
            y: axis(2, -1),
        };
        let figures = map::figures(&encoded, view);
        assert_eq!(figures["textures"].as_array().unwrap().len(), 8);
        let drawing = draw::draw(&encoded, view, "A map");
        for name in ["sponge1", "shoe-sole"] {
            assert!(drawing.contains(&format!(">{name}<")));
        }
        // dashed on the map and beside the name
        assert_eq!(drawing.matches("unseen w").count(), 2 * 4);
    }
}
