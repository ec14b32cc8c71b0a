//! A contact whose own surface is textured: its relief and its friction add forces while it slides over the skin.

use palpate_core::random::RandomStream;

use super::stroke::{SLIP_MM, held};
use super::{Relief, SurfaceTexture};

/// The share of a module's face under one contact: a patch of thirty, as strokes have them.
const SHARE: f64 = 1.0 / 30.0;

/// One piece of texture on a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Rub {
    relief: Relief,
    friction: f64,
    /// Force per height, N/mm.
    spring: f64,
    slip_at: f64,
}

impl Rub {
    /// Contact `number` with a surface of `texture`, on a module whose silicone has a time constant of `lag_s`.
    pub fn new(texture: &SurfaceTexture, (seed, number): (u64, u32), lag_s: f64) -> Self {
        let mut stream = RandomStream::new(seed, &format!("contact {number} of {}", texture.name));
        Self {
            relief: Relief::new(texture, lag_s, &mut stream),
            friction: texture.friction,
            spring: SHARE * texture.contact_stiffness(),
            slip_at: SLIP_MM * stream.uniform(),
        }
    }

    /// Force that the relief adds after `travel` mm, at a speed in mm/s, N.
    pub fn force(&self, travel: f64, speed: f64) -> f64 {
        self.spring * self.relief.height(travel, 0.0, speed)
    }

    /// Coefficient of friction, relief and all: the skin is dragged along with the contact.
    pub fn drag(&self, travel: f64, speed: f64) -> f64 {
        held(self.friction, self.slip_at, travel) + self.relief.slope(travel, speed)
    }
}
