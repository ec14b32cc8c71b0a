//! Capabilities of a bench that a scene may want.

use super::bench::Bench;
use super::error::FileError;
use super::near::did_you_mean;
use super::source::Source;

/// Something that a bench has or lacks.
pub(super) struct Capability {
    /// Name in files.
    pub name: &'static str,
    /// The thing in words.
    pub words: &'static str,
    /// Returns true if a bench has it.
    pub has: fn(&Bench) -> bool,
    /// The first bench to look at among those that ship.
    pub bench: &'static str,
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

/// Capability of a name; none where the name is a bench's.
pub(super) fn capability(name: &str) -> Option<&'static Capability> {
    CAPABILITIES.iter().find(|of| of.name == name)
}

/// Checks that something of this name can be wanted.
pub(super) fn check(wanted: &str, source: &Source) -> Result<(), FileError> {
    let capabilities = CAPABILITIES.iter().map(|of| of.name);
    let known: Vec<&str> = capabilities
        .chain(palpate_fixtures::bench_names())
        .collect();
    if known.contains(&wanted) {
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
