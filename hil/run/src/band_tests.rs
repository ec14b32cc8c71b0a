//! Bands that ship are of their benches, and stale ones say how to make them anew.

use palpate_files::{FileKind, Overrides};

use super::*;

fn setup(scene: &str, set: &[&str]) -> Setup {
    let mut overrides = Overrides::default();
    for text in set {
        overrides.set("--set", text).unwrap();
    }
    let setup = Setup::load(scene, "emulated").unwrap();
    setup.with(&overrides).unwrap()
}

/// Digest of the default band's files on a setup, with other texts in place of some.
fn digest_of(setup: &Setup, change: impl Fn(Source) -> Source) -> String {
    let Loaded { value, source } = setup.band.as_ref().unwrap();
    let named = value.named().into_iter();
    let named = named.map(|(kind, name, key)| resolve_from(kind, name, source, &key).unwrap());
    digest(setup, &named.map(change).collect::<Vec<_>>()).unwrap()
}

/// A bench, law or model that has changed needs its band computed anew: the sentence has the command.
#[test]
fn every_band_that_ships_is_of_its_bench() {
    assert!(FileKind::Band.names().contains(&"emulated"));
    for name in FileKind::Band.names() {
        let setup = Setup::load(SCENE, name).unwrap();
        assert!(setup.bench.is_as_shipped(), "{name}");
        let band = band(&setup).unwrap_or_else(|why| {
            panic!("{name}: {why}; `ci/bands --write {name}` does so for the shipped one")
        });
        assert!(band.effective >= crate::calibrate::ENOUGH, "{name}");
    }
}

#[test]
fn what_the_draws_go_back_to_is_in_the_digest_and_a_comment_is_not() {
    let own = setup(SCENE, &[]);
    let same = |source| source;
    let digest = digest_of(&own, same);
    // The scene that a run plays is not what the band is of.
    assert_eq!(digest_of(&setup("sphere-circle", &[]), same), digest);
    for set in [
        "bench.drive.current_ma=1100",
        "bench.mount.sag_um=240",
        "bench.wire.kind=final-75um",
        "bench.wire.alloy=high",
        "bench.tissue.modulus_kpa=60",
    ] {
        assert_ne!(digest_of(&setup(SCENE, &[set]), same), digest, "{set}");
    }
    let commented =
        |source: Source| Source::new("mine.toml", format!("# More.\n{}", source.text()));
    assert_eq!(digest_of(&own, commented), digest);
    for (from, to) in [
        ("[35, 55]", "[35, 54]"),
        ("value = 10.0", "value = 9.0"),
        ("name = \"first-100um\"", "name = \"first-101um\""),
        ("name = \"low\"", "name = \"lower\""),
    ] {
        let changed = std::cell::Cell::new(0);
        let change = |source: Source| {
            changed.set(changed.get() + source.text().matches(from).count());
            Source::new("mine.toml", source.text().replace(from, to))
        };
        assert_ne!(digest_of(&own, change), digest, "{from}");
        assert_eq!(changed.get(), 1, "{from}");
    }
}

#[test]
fn a_bench_that_was_changed_names_the_command_for_its_own_band() {
    let why = |set: &[&str]| band(&setup("sphere-circle", set)).unwrap_err();
    assert_eq!(
        why(&["bench.drive.current_ma=800", "bench.description=two words"]),
        "not computed: fixtures/bands/emulated.toml is of other values; hil calibrate emulated --set drive.current_ma=800 --set 'description=two words' --out FILE makes it anew"
    );
    assert_eq!(
        why(&["illusion.model=phantom"]),
        "not computed for the law phantom: fixtures/bands/emulated.toml has inverse"
    );
    let mut without = setup("sphere-circle", &[]);
    without.band = None;
    assert_eq!(
        band(&without).unwrap_err(),
        "not computed: hil calibrate emulated --out FILE, then band = \"FILE\" in the bench"
    );
}

#[test]
fn a_band_by_other_evidence_is_made_anew_with_it() {
    let mut own = setup(SCENE, &[]);
    let file = own.band.as_mut().unwrap();
    file.value.evidence.push("found.toml".to_owned());
    let why = band(&own).unwrap_err();
    assert!(
        why.contains("evidence[1]: expected evidence (published) or a file, found \"found.toml\""),
        "{why}"
    );
    let file = own.band.as_mut().unwrap();
    file.value.evidence.pop();
    file.value.evidence.push("published".to_owned());
    file.value.seed = 11;
    file.value.identified = false;
    let why = band(&own).unwrap_err();
    let command = "hil calibrate emulated --evidence published --evidence published --planned nominal --seed 11 --out FILE";
    assert!(why.contains(command), "{why}");
}
