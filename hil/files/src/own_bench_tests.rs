//! Scenes get the bench that they want, and are refused on one that lacks it.

use super::*;
use crate::source::Source;
use crate::{Setup, load_scene};

fn wanting(wanted: &str) -> Result<Loaded<Scene>, FileError> {
    let text = format!("name = \"own\"\ndescription = \"d\"\nwants = \"{wanted}\"\n");
    Loaded::read(Source::new("own.toml", text))
}

#[test]
fn every_shipped_scene_runs_on_its_own_bench_and_on_no_bench_without_what_it_wants() {
    let mut wanting = Vec::new();
    for name in palpate_fixtures::scene_names() {
        let scene = load_scene(name).unwrap();
        let own = scene.value.own_bench().to_owned();
        Setup::join(scene.clone(), load_bench(&own).unwrap()).unwrap();
        if own == DEFAULT_BENCH {
            continue;
        }
        let refused = Setup::load(name, DEFAULT_BENCH).unwrap_err().to_string();
        assert!(
            refused.contains(": wants: expected a bench with"),
            "{refused}"
        );
        assert!(refused.contains(&format!("such as `{own}`")), "{refused}");
        wanting.push((name, own));
    }
    let benches = [
        ("allegro-rubs", "allegro-hand"),
        ("back-circle", "lra-grid-4x3"),
        ("coils-circle", "voice-coil-8"),
        ("coins-along", "lra-8"),
        ("sphere-along-wifi", "unit"),
        ("ten-fingers", "ten-fingers"),
        ("warm-materials", "warm"),
        ("wifi-outage", "unit"),
    ];
    assert_eq!(wanting, benches.map(|(scene, own)| (scene, own.to_owned())));
}

#[test]
fn a_capability_is_had_by_every_bench_with_it_and_a_bench_by_itself_alone() {
    let bench = |name: &str| load_bench(name).unwrap().value;
    let unit = wanting("unit").unwrap().value;
    assert_eq!(unit.misses(&bench("unit-whole")), None);
    assert_eq!(unit.misses(&bench("warm")).unwrap(), "a driver unit");
    let warmth = wanting("warmth").unwrap().value;
    assert_eq!(warmth.misses(&bench("unit-whole")), None);
    let thesis = wanting("thesis").unwrap().value;
    assert_eq!(thesis.own_bench(), "thesis");
    assert_eq!(thesis.misses(&bench("thesis")), None);
    let missing = thesis.misses(&bench("emulated")).unwrap();
    assert_eq!(missing, "all of bench `thesis`");
}

#[test]
fn what_is_wanted_has_to_be_something() {
    let refused = wanting("unti").unwrap_err().to_string();
    assert!(
        refused.starts_with("own.toml:3: wants: expected `unit`, `warmth`, `fingers` or a bench")
    );
    assert!(refused.contains("did you mean `unit`?"), "{refused}");
    assert!(wanting("").is_err());
}
