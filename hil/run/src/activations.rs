//! Activations from outside in place of a scene's illusion: what learns or tries out renderers sets them.

use std::sync::{Arc, Mutex, PoisonError};

use palpate_core::contact::Levels;
use palpate_core::illusion::Illusion;
use palpate_core::projector::Projector;
use palpate_core::units::Point;
use palpate_files::Setup;

use crate::failure::Failure;
use crate::{plan, runner};

/// The activation of every wire for whatever contact is due, until it is changed. Clones are the same activations.
#[derive(Clone, Debug)]
pub struct Activations(Arc<Mutex<Box<[f32]>>>);

impl Activations {
    /// None for so many wires.
    fn new(wires: usize) -> Self {
        Self(Arc::new(Mutex::new(vec![0.0; wires].into())))
    }

    /// Activates the wires like this from the next onset on: 0 to 1 each, in the display's order.
    ///
    /// # Errors
    /// Another number of wires, or a value outside 0 to 1; nothing has changed then.
    pub fn set(&self, values: &[f32]) -> Result<(), Failure> {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let unit = 0.0..=1.0;
        if values.len() != held.len() || !values.iter().all(|value| unit.contains(value)) {
            return Err(Failure::Input(format!(
                "activations: expected {} numbers from 0 to 1, one per wire, found {values:?}",
                held.len()
            )));
        }
        held.copy_from_slice(values);
        Ok(())
    }
}

impl Illusion for Activations {
    fn activate(&self, at: Point, out: &mut [f32]) {
        out.fill(0.0);
        if !(at.x.is_finite() && at.y.is_finite()) {
            return;
        }
        let held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        out.iter_mut().zip(held.iter()).for_each(|(o, a)| *o = *a);
    }
}

/// A setup's loop whose activations come from outside. Everything after them is as ever: drive, guard, chips.
///
/// # Errors
/// As [`crate::build()`]; a scene whose pulses no illusion chooses.
pub(crate) fn build(
    setup: &Setup,
    seed: u64,
    levels: Levels,
) -> Result<(Projector, Activations), Failure> {
    let mut plan = plan::plan(setup, seed, levels)?;
    if plan.output.render.is_some() {
        let source = &setup.scene.source;
        let expected = "a model that gives activations, such as \"balanced\": `inverse` chooses pulses by itself";
        return Err(Failure::File(source.bad("illusion.model", expected)));
    }
    let activations = Activations::new(plan.display.wires().len());
    plan.output.illusion = Box::new(activations.clone());
    Ok((runner::made(setup, plan)?, activations))
}

#[cfg(test)]
#[path = "activations_tests.rs"]
mod tests;
