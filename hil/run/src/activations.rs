//! Activations from outside in place of a scene's illusion: for programs that learn or try out renderers.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use palpate_core::contact::Levels;
use palpate_core::illusion::Illusion;
use palpate_core::projector::Projector;
use palpate_core::units::{Duration, Point, Prescale};
use palpate_files::Setup;

use crate::failure::Failure;
use crate::{loops, plan};

/// Activation of every wire for each contact that is due, until it is changed. Clones are the same activations.
#[derive(Clone, Debug)]
pub struct Activations {
    held: Arc<Mutex<Box<[f32]>>>,
    /// Pulses of each wire at an onset; `None` where each lasts as long as its stimulus.
    pulses: Arc<Mutex<Option<Box<[u8]>>>>,
    prescale: Prescale,
    most: u8,
}

impl Activations {
    /// Zero activations of `wires` wires whose stimuli last `duration`.
    fn new(wires: usize, prescale: Prescale, duration: Duration) -> Self {
        // A pulse whose first half lies within the stimulus counts.
        let halves = duration.as_micros() * 2000 / prescale.period_ns();
        Self {
            held: Arc::new(Mutex::new(vec![0.0; wires].into())),
            pulses: Arc::default(),
            prescale,
            most: u8::try_from(halves.div_ceil(2)).unwrap_or(u8::MAX).max(1),
        }
    }

    fn held(&self) -> MutexGuard<'_, Box<[f32]>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn pulses(&self) -> MutexGuard<'_, Option<Box<[u8]>>> {
        self.pulses.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The most pulses of a wire at an onset.
    pub const fn most_pulses(&self) -> u8 {
        self.most
    }

    /// Sets each wire's pulses from the next onset on, one per PWM period; `None`: as many as a stimulus lasts.
    ///
    /// # Errors
    /// Another number of wires, or pulses outside 1 to [`Self::most_pulses`]; nothing has changed then.
    pub fn set_pulses(&self, pulses: Option<&[u8]>) -> Result<(), Failure> {
        let (wires, most) = (self.held().len(), self.most);
        let fits = |p: &[u8]| p.len() == wires && p.iter().all(|n| (1..=most).contains(n));
        if let Some(pulses) = pulses.filter(|p| !fits(p)) {
            return Err(Failure::Input(format!(
                "pulses: expected {wires} numbers from 1 to {most}, one per wire, found {pulses:?}"
            )));
        }
        *self.pulses() = pulses.map(Into::into);
        Ok(())
    }

    /// Activates the wires like this from the next onset on: 0 to 1 each, in the display's order.
    ///
    /// # Errors
    /// Another number of wires, or a value outside 0 to 1; nothing has changed then.
    pub fn set(&self, values: &[f32]) -> Result<(), Failure> {
        let mut held = self.held();
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
        let held = self.held();
        out.iter_mut().zip(held.iter()).for_each(|(o, a)| *o = *a);
    }

    fn lasts(&self, wire: usize) -> Option<Duration> {
        let pulses = *self.pulses().as_ref()?.get(wire)?;
        // The channel goes off in the middle of the last one's period.
        let halves = 2 * u64::from(pulses) - 1;
        Some(Duration::from_micros(
            halves * self.prescale.period_ns() / 2000,
        ))
    }
}

/// A setup's loop whose activations come from outside. Drive, guard and chips after them are the setup's own.
///
/// # Errors
/// Errors of [`crate::build()`]; [`Failure::File`] for a scene whose illusion chooses pulses by itself.
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
    let wires = plan.display.wires().len();
    let (prescale, duration) = (plan.guard.prescale(), plan.output.timing.duration);
    let activations = Activations::new(wires, prescale, duration);
    plan.output.illusion = Box::new(activations.clone());
    Ok((loops::made(setup, plan)?, activations))
}

#[cfg(test)]
#[path = "activations_tests.rs"]
mod tests;
