//! Wires that lie on a finger, and the person whose finger it is.

use palpate_core::physics::{ParameterError, TissueParameters, WireParameters};

use crate::display::wire::Wire;
use crate::person::channels::{Felt, Perceiver, Person};
use crate::time::Nanos;

/// Equal wires on one finger.
#[derive(Debug)]
pub struct Wearing {
    /// Wires, one per place.
    pub wires: Vec<Wire>,
    perceiver: Option<Perceiver>,
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
        Ok(Self::all(one.worn(tissue)?, self.wires.len()))
    }

    fn all(one: Wire, count: usize) -> Self {
        Self {
            wires: vec![one; count],
            perceiver: None,
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

    /// Sums up what was felt until `now`.
    pub fn settle(&mut self, now: Nanos) {
        let Some(perceiver) = &mut self.perceiver else {
            return;
        };
        for (index, wire) in self.wires.iter_mut().enumerate() {
            wire.take_stretches(now, |stretch| perceiver.pass(index, stretch));
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
