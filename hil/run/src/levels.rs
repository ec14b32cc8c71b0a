//! Static intensity levels over a whole input, with bounded memory.

use palpate_core::contact::LevelTable;

/// So many intensities find the levels; of more, evenly many between the lowest and the highest are taken.
const TELLING: usize = 1 << 17;

/// The table of `k` levels of these intensities, raw counts; none where nothing was touched.
#[must_use]
pub fn level_table(intensities: Vec<f32>, k: usize) -> Option<LevelTable> {
    LevelTable::from_intensities(&thinned(intensities), k).ok()
}

/// At most [`TELLING`] of them.
fn thinned(mut intensities: Vec<f32>) -> Vec<f32> {
    let count = intensities.len();
    if count <= TELLING {
        return intensities;
    }
    intensities.sort_unstable_by(f32::total_cmp);
    (0..TELLING)
        .map(|n| intensities[n * (count - 1) / (TELLING - 1)])
        .collect()
}

#[cfg(test)]
#[path = "levels_tests.rs"]
mod tests;
