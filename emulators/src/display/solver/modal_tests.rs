//! Tests of `modal.rs`.

use super::*;
use palpate_core::physics::{TissueParameters, WireParameters};

#[test]
fn wide_vectors_give_the_same_bits() {
    let network = ThermalNetwork::new(&WireParameters::FINAL, &TissueParameters::DEFAULT).unwrap();
    for latent in [0.0, 1e-7] {
        let key = ModeKey {
            latent,
            feedback: 0.0,
        };
        let wide = Mode::new(&network, key);
        let plain = Mode {
            vectors: Vectors::plain(),
            ..wide.clone()
        };
        let z = wide.project(&core::array::from_fn(|i| 30.0 / (1.0 + i as f64)));
        let bits = |v: &[f64; NODES]| v.map(f64::to_bits);
        assert_eq!(bits(&wide.nodes(&z)), bits(&plain.nodes(&z)));
        for span in [1e-9, 124e-6, 5e-3, 1.0, 1e6] {
            let both = [&wide, &plain].map(|mode| {
                let p = Propagator::new(mode, span);
                let point = mode.sum(mode.rate(&z, 0.1), 33.0).point(span);
                let rows = [p.decay, p.rise, p.ramp(mode), point.terms].map(|row| bits(&row));
                (rows, point.value.to_bits(), point.slope.to_bits())
            });
            assert_eq!(both[0], both[1], "{span} s");
        }
    }
}
