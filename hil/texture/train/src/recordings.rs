//! Recordings: labelled tables of raw readings, from a folder of CSV files or from the iCub set's blobs.

use std::path::{Path, PathBuf};

use palpate_files::{Rows, Take, read_bytes};
use palpate_texture::rows::files;

use crate::failure::Failure;

/// One stroke or slide.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The file's stem, or blob and slide.
    pub name: String,
    /// Label of the texture that was touched.
    pub label: String,
    /// Raw readings, row after row.
    pub values: Vec<f32>,
}

/// Recordings with the same columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Recordings {
    pub columns: Vec<String>,
    pub all: Vec<Recording>,
}

/// Ratings of a label by people, 1 to 6, with `trained` where it may be trained on.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
pub struct Rating {
    pub label: String,
    pub trained: bool,
    pub hardness: f32,
    pub roughness: f32,
    pub friction: f32,
}

/// Surface of a label, as `hil texture strokes` writes it.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
pub struct Material {
    pub label: String,
    pub trained: bool,
    pub stiffness_n_per_mm: f64,
    pub relief_um: f64,
    pub friction: f64,
}

impl Material {
    /// Properties that stand for roughness, friction and hardness, in the order of the coordinates.
    pub const PROPERTIES: [fn(&Self) -> f64; 3] = [
        |m: &Self| m.relief_um,
        |m: &Self| m.friction,
        |m: &Self| m.stiffness_n_per_mm,
    ];

    /// Smallest and largest of a property over the materials that may be trained on.
    pub fn range(materials: &[Self], of: fn(&Self) -> f64) -> [f64; 2] {
        let trained = materials.iter().filter(|m| m.trained).map(of);
        trained.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    }
}

/// Facts about labels besides their recordings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LabelFacts {
    pub ratings: Vec<Rating>,
    pub materials: Vec<Material>,
}

impl LabelFacts {
    /// Reads both tables of a folder; a table that is not there is empty.
    pub fn read(folder: &Path) -> Result<Self, Failure> {
        let known = Self {
            ratings: table(&folder.join(RATINGS))?,
            materials: table(&folder.join(MATERIALS))?,
        };
        let bad = known.materials.iter().find(|m| {
            let fits = |of: &fn(&Material) -> f64| of(m).is_finite() && of(m) >= 0.0;
            !Material::PROPERTIES.iter().all(fits)
        });
        match bad {
            Some(material) => Err(Failure::file(
                &folder.join(MATERIALS),
                format!(
                    "{}: expected relief, friction and stiffness to be finite and not negative",
                    material.label
                ),
            )),
            None => Ok(known),
        }
    }

    /// Tells whether a label may be trained on: any label may, unless a table says no.
    pub fn may_train(&self, label: &str) -> bool {
        let rated = self.ratings.iter().find(|r| r.label == label);
        let made = self.materials.iter().find(|m| m.label == label);
        rated.is_none_or(|r| r.trained) && made.is_none_or(|m| m.trained)
    }
}

/// Largest file that is read, bytes: a blob of the iCub set has 4 MB, and a much larger file is some other one.
const MOST_BYTES: u64 = 256 << 20;
/// The file of ratings in a folder of recordings.
const RATINGS: &str = "ratings.csv";
/// File of the surfaces' properties.
const MATERIALS: &str = "materials.csv";

impl Recordings {
    /// Reads a folder. CSV: columns whose name begins with `prefix`, without those of the taxels in `without`; the
    /// label is the file's name up to the first `_`. A folder with `icub_*.npy` holds the iCub set.
    pub fn read(folder: &Path, prefix: &str, without: &[String]) -> Result<Self, Failure> {
        let of = |ending| files(folder, ending).map_err(|e| Failure::file(folder, e));
        let mut blobs = of("npy")?;
        blobs.retain(|(name, _)| name.starts_with("icub_"));
        if !blobs.is_empty() {
            return icub(&blobs);
        }
        let mut tables = of("csv")?;
        tables.retain(|(name, _)| name != "ratings" && name != "materials");
        let mut columns = Vec::new();
        let mut all = Vec::new();
        for (name, path) in tables {
            let mut rows = Rows::open(&path, Take::Prefixed { prefix, without }, None)?;
            let found: Vec<String> = rows.names().map(str::to_owned).collect();
            let values = rows.rest()?;
            if columns.is_empty() {
                columns = found;
            } else if columns != found {
                let what = "expected the columns of the files before it";
                return Err(Failure::file(&path, what));
            }
            all.push(Recording {
                label: name.split('_').next().unwrap_or_default().to_owned(),
                name,
                values,
            });
        }
        if columns.is_empty() {
            let what =
                format!("expected CSV files with columns {prefix}*, or icub_*.npy; found none");
            return Err(Failure::file(folder, what));
        }
        Ok(Self { columns, all })
    }

    /// Rows of a recording.
    pub fn rows(&self, recording: &Recording) -> usize {
        recording.values.len() / self.columns.len()
    }

    /// Labels, sorted, each once.
    pub fn labels(&self) -> Vec<String> {
        let mut labels: Vec<_> = self.all.iter().map(|r| r.label.clone()).collect();
        labels.sort();
        labels.dedup();
        labels
    }
}

/// The rows of a table, none where there is no such file.
fn table<T: serde::de::DeserializeOwned>(path: &Path) -> Result<Vec<T>, Failure> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let mut reader = csv::Reader::from_path(path).map_err(|e| Failure::file(path, e))?;
    reader
        .deserialize()
        .map(|row| row.map_err(|e| Failure::file(path, e)))
        .collect()
}

/// Columns, steps and rows of a slide of the iCub set. The files say (6, 10, 75), but neighbouring values in memory
/// are the six rows of one column at one time: only read as 10 columns x 75 steps x 6 rows do the readings run on
/// smoothly (mean change from step to step 0.66; 7.1 as the files say).
const ICUB: [usize; 3] = [10, 75, 6];

fn icub(blobs: &[(String, PathBuf)]) -> Result<Recordings, Failure> {
    let [columns, steps, rows] = ICUB;
    let mut all = Vec::new();
    for (blob, path) in blobs {
        let values = npy(path, "'<f4'", 4)?;
        let slides: Vec<f32> = values
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        if let Some(bad) = slides.iter().position(|v| !v.is_finite()) {
            let what = format!(
                "number {bad}: expected finite readings, found {}",
                slides[bad]
            );
            return Err(Failure::file(path, what));
        }
        let labels_path = path.with_file_name(blob.replace("icub", "labels") + ".npy");
        let labels = npy(&labels_path, "'<i8'", 8)?;
        let slides = slides.chunks_exact(columns * steps * rows);
        if slides.len() != labels.len() / 8 {
            let what = format!(
                "expected {} labels, found {}",
                slides.len(),
                labels.len() / 8
            );
            return Err(Failure::file(&labels_path, what));
        }
        for (number, (slide, label)) in slides.zip(labels.chunks_exact(8)).enumerate() {
            let at = |step: usize, feature: usize| {
                let (column, row) = (feature / rows, feature % rows);
                slide[(column * steps + step) * rows + row]
            };
            let values = (0..steps)
                .flat_map(|step| (0..columns * rows).map(move |f| at(step, f)))
                .collect();
            all.push(Recording {
                name: format!("{blob}_{number:03}"),
                label: format!("material{:02}", label[0]),
                values,
            });
        }
    }
    let columns = (0..columns * rows)
        .map(|f| format!("column{}_row{}", f / rows, f % rows))
        .collect();
    Ok(Recordings { columns, all })
}

/// The bytes of a NumPy file of version 1 with this type in C order.
fn npy(path: &Path, kind: &str, width: usize) -> Result<Vec<u8>, Failure> {
    let bytes = read_bytes(path, "a NumPy file", MOST_BYTES)?;
    let header = bytes
        .get(8..10)
        .map(|b| usize::from(b[0]) + 256 * usize::from(b[1]));
    let data = header.and_then(|length| bytes.get(10 + length..));
    let text = header
        .and_then(|length| bytes.get(10..10 + length))
        .map(String::from_utf8_lossy);
    match (data, text) {
        (Some(data), Some(text))
            if bytes.starts_with(b"\x93NUMPY\x01")
                && text.contains(kind)
                && text.contains("'fortran_order': False")
                && data.len() % width == 0 =>
        {
            Ok(data.to_vec())
        }
        _ => Err(Failure::file(
            path,
            format!("expected a NumPy file, version 1, of {kind} in C order"),
        )),
    }
}

#[cfg(test)]
#[path = "recordings_tests.rs"]
mod tests;
