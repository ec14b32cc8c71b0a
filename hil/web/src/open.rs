//! Setup of a page's session, from its request.

use palpate_files::{Loaded, Overrides, Setup, Source, load_bench, load_scene};
use palpate_run::Failure;

use crate::request::Chosen;

/// Most taxels of a page's skin.
const MOST_TAXELS: usize = 8192;

/// Seed of a request that states none.
pub const SEED: u64 = 1;

/// Reads scene and bench with the request's changes.
///
/// # Errors
/// [`Failure::Input`] or [`Failure::File`] for what cannot be, or is not for a page.
pub fn setup(chosen: &Chosen) -> Result<Setup, Failure> {
    let scene = match &chosen.text {
        Some(text) => Loaded::read(Source::new("the session", text.clone()))?,
        None => load_scene(&chosen.scene)?,
    };
    let mut changes = Overrides::default();
    for text in &chosen.set {
        changes.set("the page", text)?;
    }
    let bench = load_bench(&chosen.bench)?.with(&changes)?;
    let setup = Setup::join(scene.with(&changes)?, bench)?;
    let taxels = setup.sensor.value.readings();
    if taxels > MOST_TAXELS {
        return Err(Failure::Input(format!(
            "layout `{}`: expected at most {MOST_TAXELS} taxels in a page, found {taxels}; `hil run` has no such bound",
            setup.sensor.value.name
        )));
    }
    match chosen.observe {
        true => Ok(setup.observed()?),
        false => Ok(setup),
    }
}
