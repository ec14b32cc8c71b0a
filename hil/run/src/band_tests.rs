//! Tests of `band.rs`.

use palpate_files::{Overrides, Source, WireFile};

use super::*;
use crate::{Input, Keep, run_with};

fn setup(set: &[&str]) -> Setup {
    let mut overrides = Overrides::default();
    for text in set {
        overrides.set("--set", text).unwrap();
    }
    let setup = Setup::load("sphere-circle", "emulated").unwrap();
    setup.with(&overrides).unwrap()
}

fn felt(setup: &Setup) -> crate::summary_felt::FeltSummary {
    let keep = Keep {
        band: true,
        ..Keep::default()
    };
    let outcome = run_with(setup, &Input::Scene, 1, keep, &mut ()).unwrap();
    outcome.summary.felt
}

/// Height of the bow, um, at which a wire of 5 mm on soft tissue has this gain.
fn sag_um(setup: &Setup, gain: f64) -> f64 {
    let (mut low, mut high) = (60.0, 900.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        let mut wire = plan::wire(setup);
        wire.mount.sag_m = middle * 1e-6;
        let tissue = setup.bench.value.tissue.parameters();
        match Bow::new(&wire, &tissue).unwrap().gain > gain {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

/// A corner says what a run of its own says: other wires, another gain (by another bow) and another person.
#[test]
fn a_corner_is_a_run_of_its_own() {
    // Pressed on so firmly that nothing parts, on tissue so soft that a bow has the largest gain.
    // By a law that is told nothing of the wires: the currents are the same. No pass comes first, which other wires would need
    // other pulses for.
    let common = [
        "bench.drive.hot_pass=false",
        "length_s=3",
        "illusion.model=balanced",
        "illusion.beta=0.005",
        "bench.mount.preload_mn=100",
        "bench.tissue.modulus_kpa=5",
        "bench.wire.kind=final-75um",
    ];
    let headline = setup(&common);
    let band = felt(&headline).band.unwrap();
    assert_eq!(band.corners.len(), 12);
    for corner in &band.corners {
        let kind = match corner.preset {
            "taut" => "taut",
            _ => "final-75um",
        };
        let wire = format!("bench.wire.kind={kind}");
        let sag = format!("bench.mount.sag_um={}", sag_um(&headline, corner.gain));
        let person = format!("illusion.person=\"{}\"", corner.person);
        let own = [&common[..6], &[&wire, &sag, &person]].concat();
        let own = felt(&setup(&own));
        let level = own.level_db.unwrap().median;
        // At so small a current nothing turns, and the bow is nearly straight in strain.
        assert!((level - corner.level_db).abs() < 0.1, "{corner:?}: {level}");
        let [own, of_corner] = [own.error_energy_mm, corner.error_energy_mm].map(Option::unwrap);
        assert!(
            (own.rmse - of_corner.rmse).abs() < 0.01,
            "{corner:?}: {own:?}"
        );
        let within = |[low, high]: [f64; 2], value| (low..=high).contains(&value);
        assert!(within(band.level_db, corner.level_db));
        assert!(within(
            band.error_mm.unwrap(),
            corner.error_energy_mm.unwrap().rmse
        ));
    }
    assert!(
        band.level_db[1] - band.level_db[0] > 20.0,
        "{:?}",
        band.level_db
    );
}

/// What no one is shown is not computed.
#[test]
fn a_band_is_computed_where_it_is_shown() {
    let setup = setup(&["length_s=2"]);
    let outcome = crate::run(&setup, &Input::Scene, 1).unwrap();
    assert_eq!(outcome.summary.felt.band, None);
}

/// Taut wires of a file of their own, on the default bench, by a law that knows no wire: the currents are the same.
#[test]
fn taut_is_a_run_with_a_file_of_taut_wires() {
    let headline = setup(&[
        "length_s=3",
        "illusion.model=balanced",
        "bench.drive.hot_pass=false",
    ]);
    let (file, _) = headline.wire.source.text().split_once("[r_phase]").unwrap();
    let file = [
        ("bias_stress_mpa = 10.0", "bias_stress_mpa = 172.0"),
        (
            "transformation_strain = 0.002",
            "transformation_strain = 0.045",
        ),
    ]
    .iter()
    .fold(file.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replacen(old, new, 1)
    });
    let mut taut = headline.clone();
    taut.wire.value = WireFile::read(&Source::new("taut.toml", file)).unwrap();
    let tissue = headline.bench.value.tissue.parameters();
    let gain = Bow::new(&plan::wire(&headline), &tissue).unwrap().gain;
    let (band, own) = (felt(&headline).band.unwrap(), felt(&taut));
    let person = headline.person.value.name.as_str();
    let corners = band.corners.iter();
    let of_taut = corners.filter(|c| c.preset == "taut" && c.person == person);
    let levels: Vec<[f64; 2]> = of_taut
        .map(|corner| {
            let level = own.level_db.as_ref().unwrap().median;
            [
                corner.level_db,
                level + 20.0 * libm::log10(corner.gain / gain),
            ]
        })
        .collect();
    assert_eq!(levels.len(), GAINS.len());
    for [corner, own] in levels {
        assert!((corner - own).abs() < 0.1, "{corner} for {own}");
    }
    // Wires of the bench are no taut ones.
    let loose = felt(&headline).level_db.unwrap().median;
    assert!((loose - own.level_db.unwrap().median).abs() > 1.0);
}
