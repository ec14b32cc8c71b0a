//! Touches in time.

use super::super::*;

fn touch(scene: &str, index: usize) -> Touch {
    load_scene(scene).unwrap().value.touches[index].clone()
}

#[test]
fn a_line_goes_there_and_back() {
    let touch = touch("sphere-along", 0);
    for (t, y) in [
        (0.8, -7.05),
        (1.8, 0.0),
        (2.8, 7.05),
        (3.8, 0.0),
        (4.8, -7.05),
    ] {
        let at = touch.at(t).unwrap();
        assert!(
            at.x_mm.abs() < 1e-12 && (at.y_mm - y).abs() < 1e-9,
            "{t}: {at:?}"
        );
    }
}

#[test]
fn a_circle_turns_anticlockwise_from_the_right() {
    let touch = touch("sphere-circle", 0);
    let start = touch.at(0.8).unwrap();
    let quarter = touch.at(0.8 + 4.6 / 4.0).unwrap();
    assert!((start.x_mm - 7.05).abs() < 1e-9 && start.y_mm.abs() < 1e-9);
    assert!(quarter.x_mm.abs() < 1e-9 && (quarter.y_mm - 7.05).abs() < 1e-9);
}

#[test]
fn corners_are_passed_at_constant_speed_and_ends_are_reached() {
    let touch = touch("two-finger-press", 1);
    let speed = |t: f64| {
        let (a, b) = (touch.at(t).unwrap(), touch.at(t + 1e-6).unwrap());
        (b.x_mm - a.x_mm).hypot(b.y_mm - a.y_mm)
    };
    assert!((speed(1.5) - speed(4.5)).abs() < 1e-9);
    let end = touch.at(4.8).unwrap();
    assert!((end.x_mm - 2.35).abs() < 1e-9 && (end.y_mm + 4.7).abs() < 1e-9);
}

#[test]
fn force_rises_from_zero_without_a_jump_and_nothing_is_felt_outside() {
    for scene in FileKind::Scene.names() {
        for touch in load_scene(scene).unwrap().value.touches {
            assert_eq!(touch.at(touch.start_s - 1e-9), None);
            assert_eq!(touch.at(touch.end_s + 1e-9), None);
            assert!(touch.at(touch.start_s).unwrap().force_n.abs() < 1e-12);
            assert!(touch.at(touch.end_s).unwrap().force_n.abs() < 1e-12);
            let mut before = touch.at(touch.start_s).unwrap();
            let steps = ((touch.end_s - touch.start_s) * 1000.0) as u32;
            for step in 1..steps {
                let now = touch.at(touch.start_s + f64::from(step) / 1000.0).unwrap();
                assert!(now.force_n >= 0.0 && (now.force_n - before.force_n).abs() < 0.05);
                assert!((now.x_mm - before.x_mm).hypot(now.y_mm - before.y_mm) < 0.05);
                before = now;
            }
        }
    }
}
