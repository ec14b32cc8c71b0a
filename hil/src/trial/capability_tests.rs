//! Tests of `capability.rs`.

use super::*;
use palpate_files::{Real, Setup, load_scene};

fn named(scene: &str, touch: bool) -> Vec<String> {
    let setup = Setup::load(scene, "emulated").unwrap();
    let mut bench = setup.bench.value.clone();
    bench.kind = BenchKind::Real;
    let mut real = Real::new(vec!["can0".into()], vec!["/dev/i2c-1".into()]);
    real.touch = touch;
    bench.real = Some(real);
    lacks(&setup.scene.value, &setup.sensor.value, &bench)
}

#[test]
fn an_emulated_bench_lacks_nothing_but_a_display() {
    for scene in palpate_fixtures::scene_names() {
        let own = load_scene(scene).unwrap().value.own_bench().to_owned();
        let setup = Setup::load(scene, &own).unwrap();
        let bench = &setup.bench.value;
        let (scene, sensor) = (&setup.scene.value, &setup.sensor.value);
        assert_eq!(lacks(scene, sensor, bench), Vec::<String>::new());
        let mut other = scene.clone();
        let another = match bench.display.as_str() {
            "tactile-brush-4x3" => "thimble-8",
            _ => "tactile-brush-4x3",
        };
        other.map.display = Some(another.into());
        let missing = format!("display {another}");
        assert_eq!(lacks(&other, sensor, bench), [missing]);
    }
}

#[test]
fn a_real_bench_lacks_faults_touch_and_interfaces_by_name() {
    assert_eq!(named("idle", false), Vec::<String>::new());
    assert_eq!(named("sphere-along", false), ["touch (`real.touch`)"]);
    assert_eq!(named("sphere-along", true), Vec::<String>::new());
    assert_eq!(named("stuck-amplifier", true), ["fault injection"]);
    assert_eq!(named("allegro-four-buses", true), ["4 CAN interfaces"]);
    let moved = named("allegro-one-bus-overwrite", true);
    assert!(moved.iter().any(|m| m.contains("overwrite")), "{moved:?}");
}
