//! The bench that ships with the things that a scene wants, and the things that another bench lacks.

use super::bench::Bench;
use super::error::FileError;
use super::loaded::{Loaded, load_bench};
use super::scene::Scene;
use super::wants::capability;

/// The bench of a scene that wants nothing.
pub const DEFAULT_BENCH: &str = "emulated";

impl Scene {
    /// The bench that ships with the thing that the scene wants; the default one where it wants none.
    #[must_use]
    pub fn own_bench(&self) -> &str {
        let Some(wanted) = &self.wants else {
            return DEFAULT_BENCH;
        };
        let Some(of) = capability(wanted) else {
            return wanted;
        };
        // Several may have it: the one whose displays are the scene's counts.
        let fits =
            |name: &&str| load_bench(name).is_ok_and(|bench| self.has_displays(&bench.value));
        let mut benches = std::iter::once(of.bench).chain(palpate_fixtures::bench_names());
        match of.name {
            "fingers" => benches.find(fits).unwrap_or(of.bench),
            _ => of.bench,
        }
    }

    /// Returns true if every finger's display is on a bench.
    fn has_displays(&self, bench: &Bench) -> bool {
        let named = |name: &str| bench.displays.iter().any(|display| display.name == name);
        self.fingers.iter().all(|finger| named(&finger.display))
    }

    /// Words for hardware that the scene wants and a bench lacks.
    #[must_use]
    pub fn misses(&self, bench: &Bench) -> Option<String> {
        let wanted = self.wants.as_ref()?;
        match capability(wanted) {
            Some(of) => (!(of.has)(bench)).then(|| of.words.to_owned()),
            None => (bench.name != *wanted).then(|| format!("all of bench `{wanted}`")),
        }
    }
}

impl Loaded<Scene> {
    /// Refuses a bench that lacks the thing that the scene wants.
    pub(super) fn fits_bench(&self, bench: &Bench) -> Result<(), FileError> {
        let Some(missing) = self.value.misses(bench) else {
            return Ok(());
        };
        let expected = format!(
            "a bench with {missing}, such as `{}`",
            self.value.own_bench()
        );
        let found = format!("bench `{}`", bench.name);
        Err(self.source.bad_found("wants", expected, found))
    }
}

#[cfg(test)]
#[path = "own_bench_tests.rs"]
mod tests;
