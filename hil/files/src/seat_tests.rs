//! Tests of `seat.rs`.

use super::super::{Scene, Setup};
use super::*;

fn scene(seats: &str) -> Result<Scene, FileError> {
    let text = format!("name = \"s\"\ndescription = \"S\"\n{seats}");
    Scene::read(&Source::new("s.toml", text))
}

#[test]
fn nonsense_is_named_with_key_and_range() {
    for (points, said) in [
        (
            "[]",
            "seats[0].points_s_part: expected at least one point: [seconds, of the motion]",
        ),
        (
            "[[0.0, 1.5]]",
            "seats[0].points_s_part[0]: expected a number from 0 to 1 of the motion, found [0.0, 1.5]",
        ),
        (
            "[[0.0, nan]]",
            "seats[0].points_s_part[0][1]: expected a finite number, found nan",
        ),
        (
            "[[1.0, 0.5], [1.0, 0.2]]",
            "seats[0].points_s_part[1]: expected a time after 1 s",
        ),
    ] {
        let error = scene(&format!("[[seats]]\nwire = 1\npoints_s_part = {points}"));
        let error = error.unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    let one = "[[seats]]\nwire = 1\npoints_s_part = [[0, 0.5]]\n";
    let error = scene(&one.repeat(2)).unwrap_err().to_string();
    assert!(
        error.contains("seats[1].wire: expected a wire that no other seat has"),
        "{error}"
    );
    assert_eq!(scene(one).unwrap().seats[0].wire, 1);
}

#[test]
fn a_seat_is_of_a_wire_that_the_bench_has() {
    let mut setup = Setup::load("sphere-along", "emulated").unwrap();
    let seat = |wire| Seat {
        wire,
        points_s_part: vec![[0.0, 0.5]],
    };
    setup.scene.value.seats = vec![seat(7)];
    assert!(Setup::join(setup.scene.clone(), setup.bench.clone()).is_ok());
    setup.scene.value.seats = vec![seat(8)];
    let error = Setup::join(setup.scene, setup.bench)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("seats[0].wire: expected less than 8"),
        "{error}"
    );
    let mut setup = Setup::load("sphere-along", "lra-8").unwrap();
    setup.scene.value.seats = vec![seat(0)];
    let error = Setup::join(setup.scene, setup.bench)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("seats: expected nothing on a bench of motors"),
        "{error}"
    );
}
