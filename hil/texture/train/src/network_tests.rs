//! The network has the size of Table 3.1.

use super::*;
use burn::backend::NdArray;

#[test]
fn table_3_1_has_as_many_parameters_as_printed() {
    let network = Network::<NdArray>::new(45, 3, 100, 1, &Default::default());
    assert_eq!(network.num_params(), 299_106);
}
