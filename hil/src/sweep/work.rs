//! The grid of a sweep, its rows in the table, and those still to run. The table is the same to the byte whether the
//! threads of `hil sweep` run it or the workers of a cluster.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use palpate_files::Setup;
use palpate_records::runs::{RunKey, RunRow};
use palpate_run::Failure;
use palpate_run::sweep::{Grid, Variant};
use rayon::prelude::*;

use super::growing::Growing;
use palpate_live::output::Outputs;

/// Runs that are wanted, and runs that are done.
#[derive(Debug)]
pub struct Work {
    grid: Grid,
    /// The key of each combination, but for the seed.
    variants: Vec<RunKey>,
    /// Rows of the grid, of this process and of earlier ones.
    rows: BTreeMap<RunKey, RunRow>,
    /// Number of wanted rows that were there.
    before: usize,
    part: Option<(usize, usize)>,
}

impl Work {
    /// Reads every combination of a grid, so that all are good before anything runs. Their files are read again when
    /// they run: a scene has more text than a row, and a grid many combinations. Of `part` (K, N) only every N-th row
    /// is wanted, from the K-th on.
    ///
    /// # Errors
    /// [`Failure`] for the first combination that cannot run.
    pub fn read(base: &Setup, grid: Grid, part: Option<(usize, usize)>) -> Result<Self, Failure> {
        let all = (0..grid.combinations()).into_par_iter();
        let variants: Vec<Result<RunKey, Failure>> = all
            .map(|n| Ok(Variant::new(base, grid.set(n))?.key(0)))
            .collect();
        Ok(Self {
            grid,
            variants: variants.into_iter().collect::<Result<_, _>>()?,
            rows: BTreeMap::new(),
            before: 0,
            part,
        })
    }

    /// Opens or makes the table, and takes the rows that it has.
    ///
    /// # Errors
    /// The errors of [`Growing::open`].
    pub fn open(&mut self, path: &Path, outputs: Outputs<'_>) -> Result<Growing, Failure> {
        let swept = self.variants.first().map(|key| key.set.clone());
        let swept = swept.unwrap_or_default();
        let (all, seeds): (BTreeSet<&RunKey>, BTreeSet<&u64>) = (
            self.variants.iter().collect(),
            self.grid.seeds().iter().collect(),
        );
        let is_of_grid = |row: &RunRow| {
            let variant = RunKey {
                seed: 0,
                ..row.key.clone()
            };
            seeds.contains(&row.key.seed) && all.contains(&variant)
        };
        let keys = swept.keys().map(String::as_str);
        let (table, rows) = Growing::open(path, keys, outputs, is_of_grid)?;
        self.take(rows);
        self.before = self.there().len();
        Ok(table)
    }

    /// Takes rows that have run.
    pub fn take(&mut self, rows: Vec<RunRow>) {
        let rows = rows.into_iter().map(|row| (row.key.clone(), row));
        self.rows.extend(rows);
    }

    /// Puts the table in the order of the grid.
    ///
    /// # Errors
    /// The errors of [`Growing::finish`].
    pub fn finish(&self, table: Growing) -> Result<(), Failure> {
        table.finish(self.keys().filter_map(|(_, key)| self.rows.get(&key)))
    }

    /// All keys of the grid in its order, each with its combination.
    fn keys(&self) -> impl Iterator<Item = (usize, RunKey)> {
        let seeds = self.grid.seeds();
        let of = move |(n, key): (usize, &RunKey)| {
            let key = key.clone();
            seeds.iter().map(move |&seed| {
                (
                    n,
                    RunKey {
                        seed,
                        ..key.clone()
                    },
                )
            })
        };
        self.variants.iter().enumerate().flat_map(of)
    }

    /// Wanted runs, each with its combination: all, or every N-th.
    fn wanted(&self) -> impl Iterator<Item = (usize, RunKey)> {
        let (k, n) = self.part.unwrap_or((1, 1));
        self.keys().skip(k - 1).step_by(n)
    }

    /// Number of wanted rows.
    pub fn wanted_count(&self) -> usize {
        self.wanted().count()
    }

    /// The wanted rows that are there, in the order of the grid.
    pub fn there(&self) -> Vec<&RunRow> {
        let found = self.wanted().filter_map(|(_, key)| self.rows.get(&key));
        found.collect()
    }

    /// Number of wanted rows that the table had when it was opened.
    pub const fn before(&self) -> usize {
        self.before
    }

    /// The runs that are wanted and not there, as combination and seed, in the order of the grid.
    pub fn lacking(&self) -> Vec<(usize, u64)> {
        let lacking = self.wanted();
        let lacking = lacking.filter(|(_, key)| !self.rows.contains_key(key));
        lacking.map(|(variant, key)| (variant, key.seed)).collect()
    }

    /// Key of the run of a combination with this seed; `None` beyond the grid.
    pub fn key(&self, combination: usize, seed: u64) -> Option<RunKey> {
        let key = self.variants.get(combination)?.clone();
        Some(RunKey { seed, ..key })
    }

    /// The grid.
    pub const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Names of scene and bench.
    pub fn names(&self) -> Option<(&str, &str)> {
        let first = self.variants.first()?;
        Some((&first.scene, &first.bench))
    }
}
