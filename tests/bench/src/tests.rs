//! The command line, run times, tables, plots, and how the peers are built.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::hint::black_box;
use std::time::Duration;

use toml::Table;

use super::*;
use plot::{Mark, Plot, Series};
use timing::{Race, Samples};

#[test]
fn a_family_is_found_by_its_name_and_no_other() {
    let parsed = Arguments::try_parse_from(["palpate-bench", "physics", "--json"]).unwrap();
    assert_eq!(parsed.family.as_deref(), Some("physics"));
    let error = Arguments::try_parse_from(["palpate-bench", "chemistry"]).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("physics"), "{error}");
}

#[test]
fn every_method_gets_its_samples_and_a_slow_one_at_least_one() {
    let (quick, slow) = (Cell::new(0_u32), Cell::new(0_u32));
    // No processor goes round the slow one's loop in so short a time.
    let mut race = Race::of_samples(Duration::from_micros(20));
    race.enter(|| quick.set(quick.get() + 1));
    race.enter(|| {
        slow.set(slow.get() + 1);
        (0..200_000_u64).fold(0, |sum, i| black_box(sum ^ i))
    });
    let samples = race.run(5, Duration::from_nanos(1));
    assert_eq!((samples[0].len(), samples[1].len()), (1, 1));
    assert!(quick.get() > slow.get() && slow.get() == 2);
    assert!(samples[0].median() < samples[1].median());
}

#[test]
fn quantiles_are_samples() {
    let mut samples = Samples::default();
    (1..=100).for_each(|us| samples.push(f64::from(us)));
    assert_eq!((samples.median(), samples.quantile(0.99)), (50.0, 99.0));
    assert!(Samples::default().median().is_nan());
}

#[test]
fn three_digits_in_the_unit_that_fits() {
    use units::{error, time};
    assert_eq!(time(0.0312), "31.2 ns");
    assert_eq!(time(2.5), "2.50 us");
    assert_eq!(time(123_456.0), "123 ms");
    assert_eq!(time(f64::NAN), "-");
    assert_eq!(error(0.234_56, "K"), "0.235 K");
    assert_eq!(error(3.21e-9, "K"), "3.21e-9 K");
    assert_eq!(error(f64::INFINITY, "K"), "-");
}

#[test]
fn whatever_was_measured_can_be_drawn() {
    let odd = vec![
        (1.0, 1e-9),
        (f64::NAN, 1.0),
        (10.0, 0.0),
        (1e6, f64::INFINITY),
        (1e5, 1e-3),
    ];
    let series = |name: &str, points| Series::new(name, Mark::Swept, points);
    let both = vec![series("a&b", odd), series("alone", vec![(3.0, 1e-5)])];
    let figure = Plot::work_precision("error [K]", both).figure("x", "A <title>", "words");
    let svg = &figure.svg;
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    assert!(svg.contains("A &lt;title&gt;") && svg.ends_with("</svg>\n"));
    assert!(figure.legend.contains("a&amp;b") && figure.legend.contains("2 alone"));
    let empty = Plot::work_precision("e", vec![series("none", Vec::new())]);
    assert!(!empty.figure("x", "t", "w").svg.contains("NaN"));
}

fn parsed(file: &str) -> Table {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(file);
    std::fs::read_to_string(path).unwrap().parse().unwrap()
}

/// The peers, and every crate that they are built from.
fn built_from(peers: &[&str]) -> BTreeSet<String> {
    let lock = parsed("Cargo.lock");
    let packages = lock["package"].as_array().unwrap();
    let mut found = BTreeSet::new();
    let mut pending: Vec<String> = peers.iter().map(ToString::to_string).collect();
    while let Some(name) = pending.pop() {
        let versions = packages
            .iter()
            .filter(|p| p["name"].as_str() == Some(&name));
        let needed = versions.filter_map(|p| p.get("dependencies")?.as_array());
        for dependency in needed.flatten().filter_map(toml::Value::as_str) {
            // `name` or `name version`.
            pending.extend(dependency.split(' ').next().map(String::from));
        }
        found.insert(name);
        pending.retain(|name| !found.contains(name));
    }
    found
}

#[test]
fn every_setting_that_the_loop_is_measured_with_can_be_run() {
    for sweep in &settings::SWEEPS {
        for &value in sweep.values {
            let setup = palpate_hil::reproduce::setups::changed(settings::PATHS[0], |s| {
                (sweep.change)(s, value)
            });
            assert!(setup.is_ok(), "{} {value}: {:?}", sweep.name, setup.err());
        }
    }
}

#[test]
fn peers_are_built_no_slower_than_ours() {
    const PEERS: [&str; 4] = ["ckmeans", "diffsol", "nalgebra", "ode_solvers"];
    let built_from = built_from(&PEERS);
    assert!(built_from.len() > PEERS.len(), "{built_from:?}");
    let release = &parsed("Cargo.toml")["profile"]["release"];
    let level = |v: &toml::Value| v.get("opt-level")?.as_integer();
    let all = level(release).unwrap_or(3);
    let packages = &release["package"];
    let others = packages.get("*").and_then(level).unwrap_or(all);
    for name in &built_from {
        let level = packages.get(name).and_then(level).unwrap_or(others);
        assert_eq!(level, 3, "{name} is built at level {level}");
    }
    for name in PEERS.into_iter().chain(["palpate-bench", "palpate-core"]) {
        let units = packages[name]["codegen-units"].as_integer();
        assert_eq!(units, Some(1), "{name}");
    }
}
