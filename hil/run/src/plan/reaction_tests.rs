//! Tests of `reaction.rs`.

use super::*;
use crate::{build, dynamic_levels};

fn of_wire(wire: &str) -> Reaction {
    let mut overrides = palpate_files::Overrides::default();
    overrides.set("--set", wire).unwrap();
    let scene = palpate_files::load_scene("sphere-along").unwrap();
    let bench = palpate_files::load_bench("emulated").unwrap();
    let setup = Setup::join(scene, bench.with(&overrides).unwrap()).unwrap();
    let levels = dynamic_levels(&setup.scene.value.compression);
    reaction(&setup, &build(&setup, 1, levels).unwrap()).unwrap()
}

#[test]
fn a_wire_moves_within_its_burst_and_is_felt_by_whom_it_reaches() {
    let loose = of_wire("bench.drive.current_ma=1970");
    assert!((0.01e-3..0.01).contains(&loose.moved_s), "{loose:?}");
    assert!(
        loose.felt_s.is_some_and(|s| (0.1e-3..0.1).contains(&s)),
        "{loose:?}"
    );
    // A five-hundredth of the current heats by next to nothing.
    let weak = of_wire("bench.drive.current_ma=4");
    assert_eq!(weak.felt_s, None, "{weak:?}");
}

#[test]
fn pieces_of_a_stretch_move_as_far_as_the_whole() {
    let whole = Stretch::sinking(0.0123, 7.0, 40.0);
    let all: f64 = pieces(&whole).iter().map(moves).sum();
    assert!((all - moves(&whole)).abs() < 1e-12);
    assert!((all + 7.0 * (1.0 - libm::exp(-40.0 * 0.0123))).abs() < 1e-12);
    assert!(
        pieces(&whole)
            .iter()
            .all(|piece| piece.seconds <= STEP_S * 1.000_001)
    );
}
