//! Tests of `mount.rs`.

use palpate_core::physics::{Bow, WireParameters};

use super::super::{Bench, Setup};
use super::*;

fn bench(tables: &str) -> Result<Bench, FileError> {
    let text = format!("name = \"b\"\ndescription = \"B\"\n{tables}");
    Bench::read(&Source::new("b.toml", text))
}

#[test]
fn the_defaults_are_the_programs_own_constants() {
    let bench = bench("").unwrap();
    assert_eq!(bench.mount.parameters(), Mount::DEFAULT);
    let tissue = TissueParameters {
        body_c: 30.0,
        ..TissueParameters::DEFAULT
    };
    assert_eq!(bench.tissue.parameters(), tissue);
}

#[test]
fn a_mount_moves_the_skin() {
    let bench =
        bench("[mount]\nsag_um = 75\nends = \"pinned\"\n[tissue]\nmodulus_kpa = 30\n").unwrap();
    let wire = WireParameters {
        mount: bench.mount.parameters(),
        ..WireParameters::FINAL
    };
    let bow = Bow::new(&wire, &bench.tissue.parameters()).unwrap();
    assert!(bow.gain > 9.0, "{bow:?}");
}

#[test]
fn nonsense_is_named_with_key_and_range() {
    for (tables, said) in [
        (
            "[mount]\nsag_um = 0",
            "b.toml:4: mount.sag_um: expected a number from 1 to 10000 um, found 0",
        ),
        (
            "[mount]\nends = \"loose\"",
            "mount.ends: expected one of `clamped`, `pinned`, `buckled`, found `loose`",
        ),
        (
            "[mount]\npreload_mn = -1",
            "mount.preload_mn: expected a number from 0 to 100 mN, found -1",
        ),
        (
            "[mount]\ncompliance_um_per_mn = -1",
            "mount.compliance_um_per_mn: expected a number from 0 to 1000 um/mN, found -1",
        ),
        (
            "[tissue]\nmodulus_kpa = 0",
            "tissue.modulus_kpa: expected a number from 1 to 10000 kPa",
        ),
        (
            "[tissue]\nrest_c = 25.9",
            "b.toml:4: tissue.rest_c: expected a number from 26 to 36 C: the guard has rows of heat for no other finger, found 25.9",
        ),
        (
            "[tissue]\nrest_c = 36.1",
            "tissue.rest_c: expected a number from 26 to 36 C",
        ),
        (
            "[tissue]\nwarmest_c = 29.0",
            "tissue.warmest_c: expected a number from 30 to 36 C",
        ),
        (
            "[tissue]\nrest_c = 32.9\n[heat]",
            "tissue.rest_c: expected 33 with [heat]: the module is modelled on such a finger",
        ),
    ] {
        let error = bench(tables).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    let file = std::env::temp_dir().join(format!("palpate-mount-{}.toml", std::process::id()));
    std::fs::write(
        &file,
        "name = \"b\"\ndescription = \"B\"\n[mount]\nsag_um = 1100\n",
    )
    .unwrap();
    let error = Setup::load("idle", file.to_str().unwrap())
        .unwrap_err()
        .to_string();
    std::fs::remove_file(&file).unwrap();
    assert!(
        error.contains("mount.sag_um: expected a number from 1 to 1000 um"),
        "{error}"
    );
}

#[test]
fn a_finger_is_colder_than_every_row_of_its_limits() {
    let (coldest, warmest) = (
        bench("[tissue]\nrest_c = 26"),
        bench("[tissue]\nrest_c = 36"),
    );
    for (bench, rest_c) in [(coldest, 26.0), (warmest, 36.0)] {
        let tissue = bench.unwrap().tissue;
        let body_c = tissue.parameters().body_c;
        assert!((body_c - rest_c).abs() < 1e-12, "{body_c}");
        let guarded_c = tissue.guarded_c();
        assert!((guarded_c - rest_c.max(33.0)).abs() < 1e-12, "{guarded_c}");
    }
    let folder = std::env::temp_dir().join(format!("palpate-rest-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let limits = "name = \"l\"\ndescription = \"L\"\n[skin]\nmean_10s_c = 35\n";
    std::fs::write(folder.join("limits.toml"), limits).unwrap();
    let file = folder.join("bench.toml");
    let load = |rest_c: f64| {
        let bench = format!(
            "name = \"b\"\ndescription = \"B\"\nlimits = \"limits.toml\"\ntissue.rest_c = {rest_c:?}\n"
        );
        std::fs::write(&file, bench).unwrap();
        let error = Setup::load("idle", file.to_str().unwrap()).err();
        error.map(|e| e.to_string())
    };
    let (below, at) = (load(34.9), load(35.0));
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(below, None);
    let said =
        "bench.toml:4: tissue.rest_c: expected less than 35, the lowest row of [skin] in `l`";
    assert!(at.as_ref().is_some_and(|at| at.contains(said)), "{at:?}");
}
