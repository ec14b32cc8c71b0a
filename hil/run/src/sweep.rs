//! Many runs: a grid over keys and seeds, and a run as a row of a table. Every process computes the same row, so a
//! program, another language or a cluster can share a grid.

use std::collections::BTreeMap;

use palpate_files::{Overrides, Setup};
use palpate_records::digest::short_digest;
use palpate_records::runs::{RunKey, RunRow, by_number, values};

use crate::header::files;
use crate::policy::refuse_hardware;
use crate::{Failure, Host, Input, Keep, fits, run_with};

/// Most points of a grid.
const MOST: usize = 10_000_000;

/// A key and the values that it takes in turn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// A key of the scene, or after `bench.` one of the bench.
    pub key: String,
    /// Values of the key, as [`Overrides`] take them.
    pub values: Vec<String>,
}

/// Every combination of the values, each with every seed. The first axis moves slowest, the seed fastest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    axes: Vec<Axis>,
    seeds: Vec<u64>,
}

impl Grid {
    /// A grid of these axes and seeds.
    ///
    /// # Errors
    /// [`Failure::Input`] for an axis without values, a key, value (by number) or seed that is there twice, and too many
    /// points.
    pub fn new(axes: Vec<Axis>, seeds: Vec<u64>) -> Result<Self, Failure> {
        let twice = |what: &str, value: &dyn std::fmt::Display| {
            Failure::Input(format!("{what}: expected each once, found {value} again"))
        };
        for (n, axis) in axes.iter().enumerate() {
            if axes[..n].iter().any(|before| before.key == axis.key) {
                return Err(twice("--set", &axis.key));
            }
            let mut seen: BTreeMap<String, &str> = BTreeMap::new();
            for value in &axis.values {
                let Some(before) = seen.insert(by_number(value), value) else {
                    continue;
                };
                let found = match before == value {
                    true => value.clone(),
                    false => format!("{before} as {value}"),
                };
                return Err(twice(&format!("--set {}", axis.key), &found));
            }
        }
        let mut sorted = seeds.clone();
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(twice("--seeds", &pair[0]));
        }
        let counts = axes.iter().map(|axis| axis.values.len());
        let points = counts.chain([seeds.len()]).try_fold(1, usize::checked_mul);
        match points.filter(|points| (1..=MOST).contains(points)) {
            Some(_) => Ok(Self { axes, seeds }),
            None => Err(Failure::Input(format!(
                "the grid: expected 1 to {MOST} runs, found {}",
                points.map_or_else(|| "more".to_owned(), |points| points.to_string())
            ))),
        }
    }

    /// Axes of the grid.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// The seeds of every combination.
    pub fn seeds(&self) -> &[u64] {
        &self.seeds
    }

    /// Number of combinations of values.
    pub fn combinations(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// The values of a combination, by key; `index` counts below [`Grid::combinations`].
    pub fn set(&self, index: usize) -> BTreeMap<String, String> {
        let mut rest = index;
        let mut set = BTreeMap::new();
        for axis in self.axes.iter().rev() {
            let value = &axis.values[rest % axis.values.len()];
            rest /= axis.values.len();
            set.insert(axis.key.clone(), value.clone());
        }
        set
    }
}

/// A checked scene on a bench with a combination's values, and the key of its runs.
#[derive(Clone, Debug)]
pub struct Variant {
    setup: Setup,
    /// The key of its runs, but for the seed.
    key: RunKey,
}

impl Variant {
    /// A variant with these values in place of the files' own.
    ///
    /// # Errors
    /// [`Failure`] for a key or value that cannot be, what fits no loop, and a bench of hardware.
    pub fn new(base: &Setup, set: BTreeMap<String, String>) -> Result<Self, Failure> {
        let mut overrides = Overrides::default();
        for (key, value) in &set {
            overrides.set("--set", &format!("{key}={value}"))?;
        }
        let setup = base.clone().with(&overrides)?;
        refuse_hardware(&setup.bench.value)?;
        fits(&setup)?;
        let key = RunKey {
            scene: setup.scene.value.name.clone(),
            digest: digest(&setup),
            bench: setup.bench.value.name.clone(),
            set,
            seed: 0,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        Ok(Self { setup, key })
    }

    /// Key that tells the run with this seed from all others.
    pub fn key(&self, seed: u64) -> RunKey {
        RunKey {
            seed,
            ..self.key.clone()
        }
    }

    /// The run with this seed as a row. It holds only figures that every machine computes alike.
    ///
    /// # Errors
    /// [`Failure`] for what cannot run at all; a run that fails is a row.
    pub fn row(&self, seed: u64, host: &mut dyn Host) -> Result<RunRow, Failure> {
        let outcome = run_with(&self.setup, &Input::Scene, seed, Keep::default(), host)?;
        let conclusion = &outcome.summary.conclusion;
        Ok(RunRow {
            key: self.key(seed),
            verdict: conclusion.verdict,
            why: conclusion.why.first().cloned().unwrap_or_default(),
            values: values(&outcome.summary),
        })
    }
}

/// Digest of the values of all files that a run goes back to, without those that options put in their place.
fn digest(setup: &Setup) -> String {
    let mut text = String::new();
    for (name, source) in files(setup) {
        let values = source.values();
        text += &format!("{name} {}\n{values}\n", values.len());
    }
    let of_fingers = setup.fingers.iter().filter_map(|f| f.texture.as_ref());
    let of_fingers = of_fingers.map(|(_, stroked)| stroked);
    for stroked in setup.texture.iter().chain(of_fingers) {
        text += &format!(
            "{:?}\n{}\n",
            stroked.surface,
            stroked.activation.source.values()
        );
    }
    short_digest(&text)
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
