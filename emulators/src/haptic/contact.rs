//! The contactor of a motor: its case, which lies on skin and shakes against it.

use core::f64::consts::{PI, TAU};

/// A motor's case on skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Mass of the case without the moving mass, kg.
    pub case_kg: f64,
    /// Moving mass, kg.
    pub moving_kg: f64,
    /// Diameter of the face on the skin, m.
    pub face_m: f64,
    /// Stiffness of the skin under it, N/m.
    pub skin_n_m: f64,
    /// Damping of the skin under it, N s/m.
    pub skin_ns_m: f64,
}

impl Contact {
    /// Area of the face, cm2.
    pub fn area_cm2(&self) -> f64 {
        PI / 4.0 * self.face_m * self.face_m * 1e4
    }

    /// Amplitude of the case over the amplitude of the moving mass at a frequency, 1. The mass pushes the case with
    /// m w^2 x; case and skin give way by their stiffness, damping and inertia. The case's own motion is left out of the mass's.
    pub fn gain(&self, hz: f64) -> f64 {
        let omega = TAU * hz;
        let force = self.moving_kg * omega * omega;
        let elastic = self.skin_n_m - self.case_kg * omega * omega;
        force / libm::hypot(elastic, self.skin_ns_m * omega)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COIN: Contact = Contact {
        case_kg: 1e-3,
        moving_kg: 0.7e-3,
        face_m: 8e-3,
        skin_n_m: 1000.0,
        skin_ns_m: 1.5,
    };

    /// The steady amplitude of `M x'' + b x' + k x = F cos(w t)`, stepped through by Runge and Kutta.
    #[test]
    fn the_gain_is_that_of_a_driven_mass_on_skin() {
        let (hz, step) = (175.0, 1e-6);
        let omega = TAU * hz;
        let force = |t: f64| COIN.moving_kg * omega * omega * (omega * t).cos();
        let slope = |t: f64, x: f64, v: f64| {
            let push = force(t) - COIN.skin_ns_m * v - COIN.skin_n_m * x;
            (v, push / COIN.case_kg)
        };
        let (mut x, mut v, mut t, mut most) = (0.0_f64, 0.0, 0.0, 0.0_f64);
        while t < 0.2 {
            let a = slope(t, x, v);
            let b = slope(t + step / 2.0, x + a.0 * step / 2.0, v + a.1 * step / 2.0);
            let c = slope(t + step / 2.0, x + b.0 * step / 2.0, v + b.1 * step / 2.0);
            let d = slope(t + step, x + c.0 * step, v + c.1 * step);
            x += step / 6.0 * (a.0 + 2.0 * (b.0 + c.0) + d.0);
            v += step / 6.0 * (a.1 + 2.0 * (b.1 + c.1) + d.1);
            t += step;
            if t > 0.15 {
                most = most.max(x.abs());
            }
        }
        assert!(
            (most / COIN.gain(hz) - 1.0).abs() < 1e-5,
            "{most} {}",
            COIN.gain(hz)
        );
    }

    #[test]
    fn a_face_of_8_mm_has_half_a_square_centimetre() {
        assert!((COIN.area_cm2() - 0.502_65).abs() < 1e-4);
    }
}
