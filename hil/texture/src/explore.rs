//! Strokes over a table of textures: as recordings, and as latent vectors of a model.

use std::io::{self, Write};

use palpate_core::codec::uskin::Reading;
use palpate_core::texture::Encoder;
use palpate_emulators::sensor::surface::{Explorer, Habits, Recording, SurfaceTexture, milli_g};
use palpate_files::{TextureEntry, TextureModel, TextureTable, taxel};
use palpate_records::table::as_csv;
use palpate_run::Failure;
use palpate_run::plan::surface;

/// Strokes every texture of the table `strokes` times by one person with one module. `passed` takes the part that is
/// done, 0 to 1.
pub fn explore(
    table: &TextureTable,
    strokes: u32,
    seed: u64,
    passed: impl Fn(f64),
) -> Vec<(&TextureEntry, Recording)> {
    let mut explorer = Explorer::new(Habits::default(), table.dead_taxel, seed);
    explore_as((table, surface), strokes, &mut explorer, passed)
}

/// Explores with a given module and hand: `pairing` gives the surface that a texture is to the module.
pub fn explore_as<'a>(
    (table, pairing): (&'a TextureTable, fn(&TextureEntry) -> SurfaceTexture),
    strokes: u32,
    explorer: &mut Explorer,
    passed: impl Fn(f64),
) -> Vec<(&'a TextureEntry, Recording)> {
    let mut all = Vec::new();
    let count = table.texture.len() * strokes as usize;
    for entry in &table.texture {
        let surface = pairing(entry);
        for number in 0..strokes {
            all.push((entry, explorer.stroke(&surface, number)));
            passed(all.len() as f64 / count as f64);
        }
    }
    all
}

/// Writes a recording as CSV with a header, the input of training.
///
/// # Errors
/// Error of the output.
pub fn write_rows(recording: &Recording, out: &mut dyn Write) -> io::Result<()> {
    let taxels = recording.rows.first().map_or(0, Vec::len);
    let header = |t: usize| ["x", "y", "z"].map(|axis| format!("txl{t}_{axis}"));
    let header: Vec<_> = (1..=taxels).map(header).collect();
    let row = |r: &Reading| [r.x, r.y, r.z];
    let rows = recording.rows.iter();
    let rows = as_csv(rows.map(|taxels| Vec::from_iter(taxels.iter().map(row))));
    out.write_all((as_csv([header]) + &rows).as_bytes())
}

/// Writes the accelerometer's readings as CSV with a header, milli-g,
/// [`palpate_emulators::sensor::surface::ACCELEROMETER_HZ`] rows per second.
///
/// # Errors
/// Error of the output.
pub fn write_acceleration(recording: &Recording, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "x_mg,y_mg,z_mg")?;
    let row = |row: &[i16; 3]| row.map(|counts| format!("{:.1}", milli_g(counts)));
    out.write_all(as_csv(recording.acceleration.iter().map(row)).as_bytes())
}

/// Writes the properties of a table's surfaces as CSV: the truth for recordings.
///
/// # Errors
/// Error of the output.
pub fn write_materials(table: &TextureTable, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "label,trained,stiffness_n_per_mm,relief_um,wavelength_mm,octaves,friction"
    )?;
    let row = |t: &TextureEntry| {
        let figures = [
            t.stiffness_n_per_mm,
            t.relief_um,
            t.wavelength_mm,
            t.octaves,
            t.friction,
        ];
        (t.name.clone(), t.trained, figures.map(|f| f.to_string()))
    };
    out.write_all(as_csv(table.texture.iter().map(row)).as_bytes())
}

/// Writes the ratings of a table as CSV: the input of training besides the recordings.
///
/// # Errors
/// Error of the output.
pub fn write_ratings(table: &TextureTable, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "label,trained,hardness,roughness,friction")?;
    let row = |t: &TextureEntry| {
        let rated = t.rated.as_ref()?;
        let figures = [rated.hardness, rated.roughness, rated.friction];
        Some((t.name.clone(), t.trained, figures.map(|f| f.to_string())))
    };
    out.write_all(as_csv(table.texture.iter().filter_map(row)).as_bytes())
}

/// A stroke as a model encodes it: the latent vector of every tenth window.
pub struct Encoded<'a> {
    /// Texture that was stroked.
    pub entry: &'a TextureEntry,
    /// Latent vectors, in the order of time.
    pub latents: Vec<Vec<f32>>,
}

/// Rows from one encoded window to the next: neighbours are nearly the same.
const HOP: usize = 10;

/// Encodes strokes. `passed` hears the part that is done, 0 to 1.
///
/// # Errors
/// A model whose features are no columns of a flat module, whose window is longer than a stroke, or that was trained at another
/// rate.
pub fn encode<'a>(
    model: &TextureModel,
    all: &[(&'a TextureEntry, Recording)],
    passed: impl Fn(f64),
) -> Result<Vec<Encoded<'a>>, Failure> {
    let encoder = model.encoder()?;
    let mut encoded = Vec::with_capacity(all.len());
    for &(entry, ref recording) in all {
        let latents = latents((model, &encoder), recording)?;
        encoded.push(Encoded { entry, latents });
        passed(encoded.len() as f64 / all.len() as f64);
    }
    Ok(encoded)
}

/// Readings per second of emulated strokes.
pub const STROKED_HZ: f64 = 100.0;

/// The latent vector of every tenth window of an emulated stroke, in the order of time.
///
/// # Errors
/// As [`encode`].
pub fn latents(
    (model, encoder): (&TextureModel, &Encoder),
    recording: &Recording,
) -> Result<Vec<Vec<f32>>, Failure> {
    model.check_rate(STROKED_HZ)?;
    let mut room = encoder.room();
    let length = encoder.window() * encoder.features();
    let values = features(model, recording)?;
    if values.len() < length {
        let found = format!("a model with windows of {}", encoder.window());
        let expected = format!("expected windows of at most {} rows", recording.rows.len());
        return Err(Failure::Input(format!(
            "{expected}, the length of a stroke; found {found}"
        )));
    }
    let firsts = (0..=values.len() - length).step_by(HOP * encoder.features());
    let window = |first: usize| {
        let z = encoder.encode(&mut room, &values[first..first + length]);
        let stroke = recording.number;
        z.map(<[f32]>::to_vec)
            .map_err(|e| Failure::Input(format!("stroke {stroke}: {e}")))
    };
    firsts.map(window).collect()
}

/// Features of a stroke for a model: the readings that it takes, row after row.
///
/// # Errors
/// A model whose features are no columns of a flat module.
pub fn features(model: &TextureModel, recording: &Recording) -> Result<Vec<f32>, Failure> {
    let place = |name: &String| taxel(name).filter(|(taxel, _)| *taxel < 16);
    let columns: Option<Vec<_>> = model.feature_names().iter().map(place).collect();
    let columns = columns.filter(|c| !c.is_empty()).ok_or_else(|| {
        let expected =
            "expected features of a flat module, txl1_x to txl16_z; this model has others";
        Failure::Input(format!("{expected}, or does not name them"))
    })?;
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
