//! Wires that lie on a finger, and the person whose finger it is.

use palpate_core::physics::{ParameterError, TissueParameters, WireParameters};
use palpate_core::statistics::interpolated;

use crate::display::solver::stretch::Stretch;
use crate::display::wire::Wire;
use crate::person::channels::{Felt, Perceiver, Person};
use crate::time::Nanos;

/// Equal wires on one finger.
#[derive(Debug)]
pub struct Wearing {
    /// Wires, one per place.
    pub wires: Vec<Wire>,
    perceiver: Option<Perceiver>,
    /// Times in seconds, and the part of each wire's motion that reaches the skin; no points of a wire that lies on it evenly.
    seats: Vec<Vec<[f64; 2]>>,
    /// End of the motion that was summed up.
    settled: Nanos,
}

impl Wearing {
    /// `count` wires, worn and at rest; nothing feels them yet.
    ///
    /// # Errors
    /// A parameter that cannot be computed with, by name.
    pub fn new(
        wire: &WireParameters,
        tissue: &TissueParameters,
        count: usize,
    ) -> Result<Self, ParameterError> {
        let one = Wire::new(wire, tissue, tissue.body_c)?.worn(tissue)?;
        Ok(Self::all(one, count))
    }

    /// Other wires at rest in the place of these.
    ///
    /// # Errors
    /// A parameter that cannot be computed with, by name.
    pub fn instead(
        &self,
        wire: &WireParameters,
        tissue: &TissueParameters,
    ) -> Result<Self, ParameterError> {
        let one = Wire::beside(self.wires.first(), wire, tissue, tissue.body_c)?;
        Ok(Self {
            seats: self.seats.clone(),
            settled: self.settled,
            ..Self::all(one.worn(tissue)?, self.wires.len())
        })
    }

    fn all(one: Wire, count: usize) -> Self {
        Self {
            wires: vec![one; count],
            perceiver: None,
            seats: vec![Vec::new(); count],
            settled: Nanos::ZERO,
        }
    }

    /// The burn integrals are kept from here on.
    #[must_use]
    pub fn with_dose(mut self) -> Self {
        self.wires = self.wires.into_iter().map(Wire::with_dose).collect();
        self
    }

    /// A person feels the wires from here on, which are at these places, mm. Until the next [`Wearing::settle`] every
    /// stretch of their motion is kept.
    ///
    /// # Errors
    /// A parameter of the person that cannot be, by name.
    pub fn by(&mut self, person: Person, places: &[(f64, f64)]) -> Result<(), ParameterError> {
        self.perceiver = Some(Perceiver::new(person, places)?);
        self.wires.iter_mut().for_each(Wire::keep_stretches);
        Ok(())
    }

    /// Lets only a part of a wire's motion reach the skin, by times in seconds; a wire that is not there is left alone.
    pub fn seat(&mut self, wire: usize, points_s_part: &[[f64; 2]]) {
        if let Some(seat) = self.seats.get_mut(wire) {
            *seat = points_s_part.to_vec();
        }
    }

    /// Sums up what was felt until `now`.
    pub fn settle(&mut self, now: Nanos) {
        let begun_s = core::mem::replace(&mut self.settled, now).as_secs_f64();
        let Some(perceiver) = &mut self.perceiver else {
            return;
        };
        for (index, (wire, seat)) in self.wires.iter_mut().zip(&self.seats).enumerate() {
            let mut t_s = begun_s;
            wire.take_stretches(now, |stretch| {
                let part = interpolated(seat, t_s).unwrap_or(1.0);
                t_s += stretch.seconds;
                let um_per_k = stretch.um_per_k * part;
                perceiver.pass(
                    index,
                    &Stretch {
                        um_per_k,
                        ..*stretch
                    },
                );
            });
        }
        perceiver.settle();
    }

    /// Takes the stimulus that a person met since the last onset, felt or not, and begins the next one. `None` where no
    /// wire moved or no person wears the display.
    pub fn onset(&mut self, now: Nanos) -> Option<Felt> {
        self.settle(now);
        let count = self.wires.len() as f64;
        // Receptors lie below the dead layer of 0.3 mm.
        let deep = self.wires.iter_mut().map(|wire| wire.tissue(now).1);
        let skin_c = deep.sum::<f64>() / count;
        let perceiver = self.perceiver.as_mut()?;
        let felt = perceiver.felt(skin_c);
        perceiver.onset();
        felt
    }
}

#[cfg(test)]
#[path = "wearing_tests.rs"]
mod tests;
