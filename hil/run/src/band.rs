//! The felt level and error of a bench over all that is not measured: what `hil calibrate` found, read from its file.
//!
//! A digest of all that the draws go back to tells whether that still holds.

use palpate_files::{
    BandFile, Bench, FileError, Loaded, Setup, Source, load_layout, load_person, load_scene,
    resolve_from,
};
use palpate_records::digest::short_digest;
use palpate_records::felt::FeltBand;

/// The scene that every draw of a calibration plays.
pub const SCENE: &str = "sphere-along";

/// The band of a setup's bench.
///
/// # Errors
/// Words for why there is none, with the command that makes one.
pub fn band(setup: &Setup) -> Result<FeltBand, String> {
    let typed = setup.bench.typed();
    let Some(Loaded {
        value: file,
        source,
    }) = &setup.band
    else {
        return Err(format!(
            "not computed: hil calibrate {typed} --out FILE, then band = \"FILE\" in the bench"
        ));
    };
    let law = setup.scene.value.illusion.model.name();
    if file.law != law {
        return Err(format!(
            "not computed for the law {law}: {} has {}",
            source.label(),
            file.law
        ));
    }
    // A browser's page has built-in files alone, whose digests a test compares; to compute one there would weigh more
    // than it tells.
    let holds = match cfg!(target_family = "wasm") {
        true => Ok(setup.bench.is_as_shipped()),
        false => read_digest(setup, file, source).map(|digest| digest == file.digest),
    };
    match holds {
        Ok(true) => Ok(read(file)),
        Ok(false) => Err(format!(
            "not computed: {} is of other values; hil calibrate {typed}{} makes it anew",
            source.label(),
            options(file, source)
        )),
        Err(error) => Err(format!("not computed: {error}")),
    }
}

/// The band that a file has.
fn read(file: &BandFile) -> FeltBand {
    FeltBand {
        level_db: file.level_db,
        felt: file.felt,
        error_mm: file.error_mm,
        draws: file.draws,
        effective: file.effective,
        seed: file.seed,
        scene: file.scene.clone(),
        identified: file.identified,
        evidence: file.evidence.clone(),
    }
}

/// Options of `hil calibrate` that make a band anew.
fn options(file: &BandFile, source: &Source) -> String {
    let mut words = String::new();
    if file.priors != "default" {
        words += &format!(" --priors {}", file.priors);
    }
    if file.evidence != ["published"] {
        let each = file.evidence.iter();
        words.extend(each.map(|name| format!(" --evidence {name}")));
    }
    if !file.identified {
        words += " --planned nominal";
    }
    if file.seed != 1 {
        words += &format!(" --seed {}", file.seed);
    }
    let out = source.folder().map_or("FILE", |_| source.label());
    words + &format!(" --out {out}")
}

/// Digest of what a band on this setup's bench would be made of, by the names in its file.
fn read_digest(setup: &Setup, file: &BandFile, source: &Source) -> Result<String, FileError> {
    let named = file.named().into_iter();
    let named = named.map(|(kind, name, key)| resolve_from(kind, name, source, &key));
    digest(setup, &named.collect::<Result<Vec<_>, _>>()?)
}

/// Words of a bench for keys that came later, at values that change nothing: no motors, and a rigid thimble.
const LATER: [&str; 2] = ["haptics: None, ", ", compliance_um_per_mn: 0.0"];

/// Digest of all values that draws of a bench go back to: the bench's own, its files, those of the scene that they play,
/// and the named files of its band, in their order.
///
/// # Errors
/// A file of the scene that is not there, or cannot be.
pub fn digest(setup: &Setup, named: &[Source]) -> Result<String, FileError> {
    let bench = Bench {
        band: None,
        ..setup.bench.value.clone()
    };
    let scene = load_scene(SCENE)?;
    let layout = load_layout(&scene.value.layout)?.source;
    let person = load_person(&scene.value.illusion.person)?.source;
    let own = [&setup.wire.source, &setup.alloy.source];
    let shared = [&setup.limits.source, &setup.display.source];
    let of_scene = [&scene.source, &layout, &person];
    let all = own.into_iter().chain(shared).chain(of_scene);
    // A bench without what came later has the digest that it had before, so files hold.
    let mut text = format!("{bench:?}\n");
    for words in LATER {
        text = text.replace(words, "");
    }
    for source in all.chain(named) {
        let values = source.values();
        text += &format!("{} {values}\n", values.len());
    }
    Ok(short_digest(&text))
}

#[cfg(test)]
#[path = "band_tests.rs"]
mod tests;
