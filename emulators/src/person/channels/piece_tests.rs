//! Tests of `piece.rs`.

use proptest::prelude::*;

use super::*;

proptest! {
    /// What is not looked at is not larger: the bound that leaves a piece out holds for any values.
    #[test]
    fn no_peak_passes_its_bound(
        values in prop::array::uniform12(-1e6..1e6f64),
        known in prop_oneof![Just(0.0), 0.0..1e8f64],
    ) {
        let (rule, vectors) = (Gauss::new(), Vectors::widest());
        let mut most = known;
        raise(&rule, vectors, &values, &mut most);
        let every = known.max(peak(&rule, vectors, &values));
        prop_assert_eq!(most.to_bits(), every.to_bits());
    }
}
