//! Seams of a skin: edges at which two of its modules join.

use serde::Deserialize;

use super::error::FileError;
use super::module::SkinModule;
use super::source::Source;

/// Shortest edge, and largest difference of its two lengths, mm.
const LEAST_MM: f64 = 0.01;

/// An edge at which two modules join, folded or flat: distances over the whole skin go through it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct LayoutSeam {
    /// Names of both modules; of copies, each one's own.
    pub modules: [String; 2],
    /// Both ends of the edge from the centre of the first module, mm, and the same ends from that of the second.
    pub edges_mm: [[[f64; 2]; 2]; 2],
}

impl LayoutSeam {
    /// Indices of the modules; `None` where one is not there.
    #[must_use]
    pub fn indices(&self, modules: &[SkinModule]) -> Option<[usize; 2]> {
        let index = |name: &String| modules.iter().position(|m| m.name == *name);
        Some([index(&self.modules[0])?, index(&self.modules[1])?])
    }

    pub(super) fn check(
        &self,
        modules: &[SkinModule],
        source: &Source,
        key: &str,
    ) -> Result<(), FileError> {
        let is_pair = self.indices(modules).is_some_and(|[a, b]| a != b);
        if !is_pair {
            let expected = "the names of two different modules of this layout";
            return Err(source.bad(&format!("{key}.modules"), expected));
        }
        let lengths = self
            .edges_mm
            .map(|[[ax, ay], [bx, by]]| (bx - ax).hypot(by - ay));
        for (n, edge) in self.edges_mm.iter().enumerate() {
            for (end, place) in edge.iter().enumerate() {
                source.range(
                    &format!("{key}.edges_mm[{n}][{end}]"),
                    place,
                    -1e4..=1e4,
                    "mm",
                )?;
            }
        }
        if lengths[0].min(lengths[1]) <= LEAST_MM || (lengths[0] - lengths[1]).abs() > LEAST_MM {
            let expected = "an edge of one length in both modules, more than 0.01 mm";
            return Err(source.bad(&format!("{key}.edges_mm"), expected));
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "seam_tests.rs"]
mod tests;
