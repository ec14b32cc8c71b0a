//! Tests of presses: a joint that bends presses as its line says, and what cannot be is refused.

use super::*;
use crate::scene::Scene;

/// A value in thousandths, which are exact.
fn thousandths(value: f64) -> i64 {
    (value * 1e3).round() as i64
}

fn scene(press: &str) -> Result<Scene, FileError> {
    let text = format!(
        "name = \"grasp\"\ndescription = \"A finger that bends\"\nlength_s = 5.0\n\n\
         [[joints]]\nname = \"mcp\"\npoints_s_deg = [[1.0, 10.0], [3.0, 50.0], [5.0, 10.0]]\npress = {press}\n"
    );
    Scene::read(&Source::new("grasp.toml", text))
}

#[test]
fn a_joint_presses_beyond_its_angle_and_moves_the_contact() {
    let scene = scene(
        "{ from_deg = 30.0, n_per_deg = 0.05, from_mm = [0.0, -4.0], mm_per_deg = [0.0, 0.4] }",
    )
    .unwrap();
    let [touch] = &*scene.touches else {
        panic!("expected one touch, found {}", scene.touches.len());
    };
    // 30 degrees at 2 s and 4 s; 40 degrees at 2.5 s: 10 degrees beyond, 0.5 N and 4 mm on.
    assert!(touch.at(1.99).is_none() && touch.at(4.02).is_none());
    let found = touch.at(2.5).unwrap();
    let met = [found.x_mm, found.y_mm, found.force_n].map(thousandths);
    assert_eq!(met, [0, 0, 500]);
    let deepest = touch.at(3.0).unwrap();
    assert_eq!(
        [deepest.y_mm, deepest.force_n].map(thousandths),
        [4000, 1000]
    );
}

#[test]
fn a_press_of_hostile_numbers_stays_within_what_a_hand_can_do() {
    let press = JointPress {
        module: 0,
        from_deg: -360.0,
        n_per_deg: 20.0,
        from_mm: [1e3, -1e3],
        mm_per_deg: [1e3, -1e3],
        diameter_mm: 19.45,
    };
    let far = press.at(360.0);
    let most = [far.x_mm, far.y_mm, far.force_n].map(thousandths);
    assert_eq!(most, [1_000_000, -1_000_000, 20_000]);
    assert_eq!(thousandths(press.at(f64::NAN).force_n), 0);
}

#[test]
fn presses_that_cannot_be_are_refused() {
    for (press, expected) in [
        (
            "{ from_deg = 5.0, n_per_deg = 0.05 }",
            "joints[0].press: expected an angle that presses nothing until",
        ),
        (
            "{ from_deg = 30.0, n_per_deg = -1.0 }",
            "joints[0].press.n_per_deg: expected a number from 0 to 20 N per degree",
        ),
        (
            "{ from_deg = 30.0, n_per_deg = 0.1, from_mm = [0.0, nan] }",
            "joints[0].press.from_mm[1]: expected a finite number, found nan",
        ),
    ] {
        let error = scene(press).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}
