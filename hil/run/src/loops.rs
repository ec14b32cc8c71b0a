//! The loop of a scene on a bench, built from its files.

use palpate_core::contact::Levels;
use palpate_core::projector::{Plan, Projector};
use palpate_core::units::Instant;
use palpate_files::Setup;

use crate::failure::Failure;
use crate::place::fingers;
use crate::plan::{self, Responses};
use crate::stagger::stagger;

/// Start of a hot pass in its scene: the skin's boards are heard by then.
pub(crate) const PASS_AT: Instant = Instant::from_micros(750_000);

/// The loop of a scene on a bench, with intensity levels found beforehand.
///
/// # Errors
/// [`Failure::Input`] for what fits no hardware.
pub fn build(setup: &Setup, seed: u64, levels: Levels) -> Result<Projector, Failure> {
    build_with(setup, seed, levels, &Responses::default())
}

/// Builds a loop with the responses that other loops have found already.
///
/// # Errors
/// Errors of [`build`].
pub fn build_with(
    setup: &Setup,
    seed: u64,
    levels: Levels,
    responses: &Responses,
) -> Result<Projector, Failure> {
    made(setup, plan::plan_with(setup, seed, levels, responses)?)
}

/// Checks that a setup can be run: builds its loop, or that of each of its fingers in its place on the grid of onsets,
/// and drops it.
///
/// # Errors
/// Errors of [`build`]; [`Failure::Input`] for fingers that cannot take turns on a board.
pub fn fits(setup: &Setup) -> Result<(), Failure> {
    let alone = fingers(setup);
    if alone.is_empty() {
        return build(setup, 1, Levels::Off).map(drop);
    }
    let responses = Responses::default();
    let loops = alone.iter();
    let loops = loops.map(|(_, setup)| build_with(setup, 1, Levels::Off, &responses));
    let mut loops: Vec<Projector> = loops.collect::<Result<_, _>>()?;
    let places = alone.iter().map(|(place, _)| place);
    stagger(setup, places.zip(&mut loops).collect())
}

pub(crate) fn made(setup: &Setup, plan: Plan) -> Result<Projector, Failure> {
    let mut projector = Projector::new(plan)
        .map_err(|e| Failure::Input(format!("{}: {e}", setup.scene.source.label())))?;
    if let Some(pass) = setup.pass.itself() {
        projector.pass(pass, PASS_AT);
    }
    Ok(projector)
}
