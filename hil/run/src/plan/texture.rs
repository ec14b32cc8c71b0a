//! A scene's texture section as the core's plan.

use std::sync::Arc;

use palpate_core::illusion::Display;
use palpate_core::projector::{Carrier, TexturePlan};
use palpate_core::skin::Layout;
use palpate_core::texture::{ControlMap, Drivers, Pulses, along};
use palpate_core::units::{Duration, Point, Prescale};

use crate::failure::Failure;
use palpate_files::{FileError, Setup};
use palpate_files::{TextureModel, taxel};

/// A texture's surface for the emulators.
pub fn surface(
    entry: &palpate_files::TextureEntry,
) -> palpate_emulators::sensor::surface::SurfaceTexture {
    palpate_emulators::sensor::surface::SurfaceTexture {
        name: entry.name.clone(),
        stiffness_n_per_mm: entry.stiffness_n_per_mm,
        relief_mm: entry.relief_um / 1000.0,
        wavelength_mm: entry.wavelength_mm,
        octaves: entry.octaves,
        friction: entry.friction,
    }
}

/// The network's features as taxels of a module and axes: columns of a recording are called `txl1_x`. A model that
/// names none takes every taxel in order.
fn features(model: &TextureModel, taxels: usize) -> Result<Box<[(u32, u8)]>, String> {
    if model.feature_names().is_empty() {
        let every = (0..taxels as u32).flat_map(|t| [(t, 0), (t, 1), (t, 2)]);
        return Ok(every.collect());
    }
    let one = |name: &String| {
        let (taxel, axis) = taxel(name).filter(|(taxel, _)| *taxel < taxels)?;
        Some((taxel as u32, axis as u8)) // a module has few
    };
    let expected = || format!("a model whose features are txl1_x to txl{taxels}_z");
    let all = model.feature_names().iter().map(one);
    all.collect::<Option<_>>().ok_or_else(expected)
}

/// Error for a key of the texture, with its place in the scene.
fn bad(setup: &Setup, key: &str, expected: String) -> FileError {
    let key = format!("{}{key}", setup.section);
    setup.scene.source.bad(&key, expected)
}

/// The texture of a scene; none where it has none.
///
/// # Errors
/// [`Failure::File`] with file and key of what does not fit together.
pub(super) fn texture(
    setup: &Setup,
    layout: &Layout,
    display: &Display,
    prescale: Prescale,
    seed: u64,
) -> Result<Option<TexturePlan>, Failure> {
    let scene = &setup.scene.value;
    let Some(felt) = &scene.texture else {
        return Ok(None);
    };
    let bad = |key: &str, expected: String| Failure::File(bad(setup, key, expected));
    let model = TextureModel::open(&felt.model)?;
    model.check_rate(scene.rate_hz)?;
    let module = felt.module.unwrap_or(scene.drives);
    let features = features(&model, layout.range(module).len())
        .map_err(|expected| bad("texture.model", expected))?;
    let drivers = model.drivers(felt.driver)?;
    if felt.hardness == Some(true) && drivers.hardness.is_none() {
        let expected = "a model with a coordinate for hardness, or `hardness = false`";
        return Err(bad("texture.model", expected.into()));
    }
    let (map, carrier) = projection(setup, drivers, display, prescale, seed)?;
    Ok(Some(TexturePlan {
        encoder: Arc::new(model.encoder()?),
        module: u16::try_from(module).unwrap_or(u16::MAX),
        features,
        gather: felt.rubs,
        sample: Duration::from_micros((1e6 / scene.rate_hz).round() as u64),
        map,
        carrier,
    }))
}

/// Projection of a latent vector onto the display, by the scene's texture section and a model's driving coordinates.
///
/// # Errors
/// [`Failure::File`] for a scene without a texture, or with file and key of what does not fit together.
pub fn projection(
    setup: &Setup,
    drivers: Drivers,
    display: &Display,
    prescale: Prescale,
    seed: u64,
) -> Result<(ControlMap, Carrier), Failure> {
    let scene = &setup.scene;
    let bad = |key: &str, expected: String| Failure::File(bad(setup, key, expected));
    let (Some(felt), Some(stroked)) = (&scene.value.texture, &setup.texture) else {
        return Err(bad("texture", "a scene with a texture".into()));
    };
    let file = &stroked.activation.value;
    let asked = felt.hardness.unwrap_or(file.tap.is_some());
    let shows = felt.carrier == palpate_files::FeltBy::Display && file.tap.is_some();
    if felt.hardness == Some(true) && !shows {
        let expected = "carrier \"display\" and an activation with [tap] for hardness";
        return Err(bad("texture.hardness", expected.into()));
    }
    if felt.carrier == palpate_files::FeltBy::Contacts {
        let map = file.burst_map(drivers);
        let map = map.map_err(|e| bad("texture.model", e.to_string()))?;
        return Ok((map, Carrier::Contacts));
    }
    let map = file.map(drivers);
    let map = map.map_err(|e| bad("texture.model", e.to_string()))?;
    let activation = file.activation();
    let activation = activation.ok_or_else(|| {
        bad(
            "texture.activation",
            "an activation with alpha + beta < 1".into(),
        )
    })?;
    let places: Vec<Point> = display.wires().iter().map(|w| w.place).collect();
    let gaps = along(&places, display.gap());
    let pulses = Pulses::new(activation, felt.draw, prescale, &gaps, seed);
    Ok((map, Carrier::Display(pulses, file.taps().filter(|_| asked))))
}
