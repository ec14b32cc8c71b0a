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
    assert_eq!(bench.tissue.parameters(), TissueParameters::DEFAULT);
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
            "[tissue]\nmodulus_kpa = 0",
            "tissue.modulus_kpa: expected a number from 1 to 10000 kPa",
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
