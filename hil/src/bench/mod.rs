//! `hil bench`: run time against error, ours beside others', as tables, JSON and plots.
//!
//! A family is a file here with one function that measures and returns [`Findings`]; its name stands in
//! [`FAMILIES`]. Methods of one case are timed in turn in one run, so that their ratios hold on a noisy
//! machine. Only builds with the feature `bench` have this room: peers never reach the ordinary program.

pub mod compression;
pub mod emulators;
pub mod guard;
pub mod illusion;
pub mod page;
mod peers;
pub mod physics;
pub mod plot;
pub mod projection;
pub mod records;
pub mod table;
pub mod texture;
pub mod timing;

use serde::Serialize;

use crate::failure::Failure;
use plot::Plot;

/// One measured method on one case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The family's name.
    pub family: &'static str,
    /// What was computed.
    pub case: String,
    /// How; `default` is what the program uses.
    pub method: String,
    /// How far off, in `error_unit`; JSON writes null for what is no number (a method that diverged).
    pub error: f64,
    /// Unit and kind of the error.
    pub error_unit: &'static str,
    /// Median run time of the case, microseconds; null where only the error counts.
    pub median_us: f64,
    /// Whether it is somebody else's method.
    pub peer: bool,
}

/// What a family found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// The table.
    pub rows: Vec<Row>,
    /// The pictures.
    pub plots: Vec<Plot>,
    /// Pictures that are no plots of measurements.
    pub figures: Vec<Figure>,
    /// Sentences below the table: conditions, targets met and missed.
    pub words: Vec<String>,
}

/// A drawing with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its file's name, after the family's: lower case with hyphens.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// What it shows.
    pub words: String,
    /// The drawing, an SVG element that takes its colours from the page.
    pub svg: String,
}

/// A family of measurements.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// As the command line spells it.
    pub name: &'static str,
    /// Measures everything.
    pub measure: fn() -> Result<Findings, Failure>,
}

/// Every family, in the order of the pages.
pub const FAMILIES: [Family; 7] = [
    Family {
        name: "physics",
        measure: physics::measure,
    },
    Family {
        name: "emulators",
        measure: emulators::measure,
    },
    Family {
        name: "compression",
        measure: compression::measure,
    },
    Family {
        name: "texture",
        measure: texture::measure,
    },
    Family {
        name: "illusion",
        measure: illusion::measure,
    },
    Family {
        name: "loop",
        measure: projection::measure,
    },
    Family {
        name: "records",
        measure: records::measure,
    },
];

/// The family of that name, or all.
///
/// # Errors
/// [`Failure::Input`] names those there are.
pub fn chosen(name: Option<&str>) -> Result<Vec<Family>, Failure> {
    let Some(name) = name else {
        return Ok(FAMILIES.to_vec());
    };
    match FAMILIES.iter().find(|f| f.name == name) {
        Some(family) => Ok(vec![*family]),
        None => {
            let names: Vec<_> = FAMILIES.iter().map(|f| f.name).collect();
            Err(Failure::Input(format!(
                "no family `{name}`: expected {}",
                names.join(", ")
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_family_is_found_by_its_name_and_no_other() {
        assert_eq!(chosen(None).unwrap().len(), FAMILIES.len());
        assert_eq!(chosen(Some("physics")).unwrap()[0].name, "physics");
        let error = chosen(Some("chemistry")).unwrap_err();
        assert_eq!(error.status(), 2);
        assert!(error.to_string().contains("expected physics"), "{error}");
    }
}
