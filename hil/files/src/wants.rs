//! What a scene needs of its bench, and the bench that ships with it.

use super::bench::Bench;
use super::error::FileError;
use super::loaded::{Loaded, load_bench};
use super::near::did_you_mean;
use super::scene::Scene;
use super::source::Source;

/// The bench of a scene that needs nothing.
pub const DEFAULT_BENCH: &str = "emulated";

/// Something that a bench has or lacks.
struct Capability {
    name: &'static str,
    /// The thing in words.
    words: &'static str,
    has: fn(&Bench) -> bool,
    /// The first bench to look at among those that ship.
    bench: &'static str,
}

static CAPABILITIES: [Capability; 3] = [
    Capability {
        name: "unit",
        words: "a driver unit",
        has: |bench| bench.unit.is_some(),
        bench: "unit",
    },
    Capability {
        name: "warmth",
        words: "a Peltier module",
        has: |bench| bench.heat.is_some(),
        bench: "warm",
    },
    Capability {
        name: "fingers",
        words: "a display for each finger",
        has: |bench| !bench.displays.is_empty(),
        bench: "allegro-hand",
    },
];

fn capability(name: &str) -> Option<&'static Capability> {
    CAPABILITIES.iter().find(|of| of.name == name)
}

/// Checks that something of this name can be wanted.
pub(super) fn check(scene: &Scene, source: &Source) -> Result<(), FileError> {
    let Some(wanted) = &scene.wants else {
        return Ok(());
    };
    let capabilities = CAPABILITIES.iter().map(|of| of.name);
    let known: Vec<&str> = capabilities
        .chain(palpate_fixtures::bench_names())
        .collect();
    if known.contains(&wanted.as_str()) {
        return Ok(());
    }
    let benches: Vec<&str> = palpate_fixtures::bench_names().collect();
    let names: Vec<String> = CAPABILITIES
        .iter()
        .map(|of| format!("`{}`", of.name))
        .collect();
    let names = names.join(", ");
    let expected = format!("{names} or a bench that ships ({})", benches.join(", "));
    let meant = did_you_mean(wanted, known);
    Err(source.bad_found("wants", expected, format!("\"{wanted}\"{meant}")))
}

impl Scene {
    /// The bench that ships with what the scene wants; the default one where it wants nothing.
    #[must_use]
    pub fn own_bench(&self) -> &str {
        let Some(wanted) = &self.wants else {
            return DEFAULT_BENCH;
        };
        let Some(of) = capability(wanted) else {
            return wanted;
        };
        // Of several that have it, the one whose displays are the scene's.
        let fits =
            |name: &&str| load_bench(name).is_ok_and(|bench| self.has_displays(&bench.value));
        let mut benches = std::iter::once(of.bench).chain(palpate_fixtures::bench_names());
        match of.name {
            "fingers" => benches.find(fits).unwrap_or(of.bench),
            _ => of.bench,
        }
    }

    /// Whether every finger's display is on a bench.
    fn has_displays(&self, bench: &Bench) -> bool {
        let named = |name: &str| bench.displays.iter().any(|display| display.name == name);
        self.fingers.iter().all(|finger| named(&finger.display))
    }

    /// What the scene wants and a bench lacks, in words.
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
    /// Refuses a bench without what the scene wants.
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
#[path = "wants_tests.rs"]
mod tests;
