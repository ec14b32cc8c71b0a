//! Recipes: how a recording of another maker is to be read, said once in a file.

use serde::Deserialize;

use super::dialect::Writing;
use super::error::FileError;
use super::gain::Gain;
use super::settings::bounds;
use super::source::Source;
use super::times::{TimeColumn, TimeUnit};

/// The only kind a [`Recipe`] may state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
enum RecordingTag {
    Recording,
}

/// Separators of fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Delimiter {
    /// `,`.
    Comma,
    /// `;`.
    Semicolon,
    /// A tab.
    Tab,
    /// One blank or tab, or more.
    Blanks,
}

/// Orders of a module's columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ColumnOrder {
    /// By the numbers in their names; x, y and z of a taxel side by side.
    #[default]
    Numbers,
    /// The order of the file.
    File,
    /// The order of the file: x of all taxels, then y, then z.
    AxesFirst,
}

/// A recipe: columns, modules, units and times of a recording.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    #[allow(dead_code, reason = "checked by its type")]
    kind: RecordingTag,
    /// Lower case with hyphens.
    pub name: String,
    /// A sentence on the recording.
    pub description: String,
    /// Assumptions in it, in a sentence.
    pub assumed: Option<String>,
    /// The recording, from the folder of this file on; left out: any.
    pub recording: Option<String>,
    /// The skin: a built-in layout or a file.
    pub layout: String,
    /// The topic whose messages are rows, in a file of messages; left out: the one with the most numbers.
    pub topic: Option<String>,
    /// Separator of fields; left out: the one that leaves numbers.
    pub delimiter: Option<Delimiter>,
    /// Commas for decimal points; left out: as the first rows have it.
    pub decimal_comma: Option<bool>,
    /// Lines of a frame of a pressure map; left out: as blank lines part frames, and 1 where none do.
    pub lines_per_frame: Option<usize>,
    /// Rows per second, where no column says when they came.
    pub rate_hz: Option<f64>,
    /// The column that says when rows came; left out: one whose name does.
    pub time: Option<RecipeTime>,
    /// The column whose values name the sensor of a row, where rows of several sensors take turns.
    pub sensor_column: Option<String>,
    /// Unit of the values, such as `N`; left out: counts.
    pub unit: Option<String>,
    /// Counts per unit; with `unit`.
    pub gain: Option<f64>,
    /// Counts at 0 of the unit.
    #[serde(default)]
    pub offset: f64,
    /// The modules of the layout; their order is the layout's, where they have no names.
    pub modules: Vec<RecipeModule>,
}

/// The column that says when rows came.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecipeTime {
    /// Heading; without headings the column's number, from 1.
    pub column: String,
    /// Unit of the numbers in it.
    pub unit: TimeUnit,
}

/// The columns of a module, and how it is mounted.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecipeModule {
    /// Name of the module in the layout.
    pub name: Option<String>,
    /// Beginning of the columns' names; or `columns` or `first_column`.
    pub prefix: Option<String>,
    /// The names of its columns in the layout's order; or `prefix` or `first_column`.
    pub columns: Option<Vec<String>>,
    /// The number of its first column, from 1; or `prefix` or `columns`.
    pub first_column: Option<usize>,
    /// The order of its columns.
    #[serde(default)]
    pub order: ColumnOrder,
    /// Taxels of the file that the layout does not have, by the numbers in their names; without numbers, counted from 0.
    #[serde(default)]
    pub without: Vec<u64>,
    /// Turn of the module to the left against its maker's picture, degrees: 0, 90, 180 or 270.
    #[serde(default)]
    pub turned_deg: u16,
    /// Left and right exchanged against the maker's picture, before the turn.
    #[serde(default)]
    pub mirrored: bool,
    /// Value that stands in `sensor_column` for this module.
    pub sensor: Option<String>,
    /// Counts per unit; left out: those of the recording.
    pub gain: Option<f64>,
    /// Counts at 0 of the unit; left out: those of the recording.
    pub offset: Option<f64>,
}

impl Recipe {
    /// Reads and checks a recipe; whether it fits its layout is checked by [`RecipePlan::new`](super::RecipePlan::new).
    ///
    /// # Errors
    /// Names the line and key of what cannot be.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let recipe: Self = source.read()?;
        source.heading(&recipe.name, &recipe.description)?;
        bounds!(source, "", recipe; rate_hz: 0.1..=1e6, "Hz")?;
        bounds!(source, "", recipe; lines_per_frame: 1..=100_000)?;
        if let (Some(_), Some(_)) = (recipe.rate_hz, &recipe.time) {
            return Err(source.bad("rate_hz", "a rate or a column of times"));
        }
        if let Some(unit) = &recipe.unit
            && unit.trim().is_empty()
        {
            return Err(source.bad("unit", "a unit, such as \"N\""));
        }
        if recipe.modules.is_empty() {
            return Err(source.bad("modules", "at least one module"));
        }
        for (index, module) in recipe.modules.iter().enumerate() {
            recipe.check_module(source, &format!("modules[{index}]"), module)?;
        }
        recipe.check_gain(source)?;
        Ok(recipe)
    }

    fn check_gain(&self, source: &Source) -> Result<(), FileError> {
        gain_of(source, "", self.gain, self.offset)?;
        if self.unit.is_none() {
            return Ok(());
        }
        match self
            .modules
            .iter()
            .position(|m| self.gain.or(m.gain).is_none())
        {
            None => Ok(()),
            Some(index) => {
                let key = format!("modules[{index}].gain");
                Err(source.bad(&key, "counts per unit, here or for the recording"))
            }
        }
    }

    fn check_module(
        &self,
        source: &Source,
        key: &str,
        module: &RecipeModule,
    ) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        let given = [
            ("prefix", module.prefix.is_some()),
            ("columns", module.columns.is_some()),
            ("first_column", module.first_column.is_some()),
        ];
        let mut given = given.iter().filter(|(_, given)| *given);
        match (given.next(), given.next()) {
            (None, _) => return Err(source.bad(&at("prefix"), "prefix, columns or first_column")),
            (_, Some((name, _))) => {
                return Err(source.bad(&at(name), "one of prefix, columns and first_column"));
            }
            _ => {}
        }
        bounds!(source, key, module; first_column: 1..=100_000_000)?;
        if module.columns.is_some() && module.order != ColumnOrder::Numbers {
            return Err(source.bad(&at("order"), "no order: `columns` is one"));
        }
        if module.columns.is_some() && !module.without.is_empty() {
            return Err(source.bad(
                &at("without"),
                "nothing: `columns` leaves out what it does not name",
            ));
        }
        if ![0, 90, 180, 270].contains(&module.turned_deg) {
            return Err(source.bad(&at("turned_deg"), "0, 90, 180 or 270"));
        }
        if module.sensor.is_some() != self.sensor_column.is_some() {
            let expected =
                "sensor_column for the recording and sensor for every module, or neither";
            return Err(source.bad(&at("sensor"), expected));
        }
        let (gain, offset) = (module.gain.or(self.gain), module.offset);
        if offset.is_some() && gain.is_none() {
            return Err(source.bad(&at("offset"), "a gain beside it"));
        }
        gain_of(source, key, module.gain, offset.unwrap_or_default())
    }

    /// Gain of a module's values; none where they are counts.
    pub(super) fn gain(&self, module: &RecipeModule) -> Option<Gain> {
        let gain = module.gain.or(self.gain)?;
        Some(Gain::new(gain, module.offset.unwrap_or(self.offset)))
    }

    /// Separator and decimal mark of the recording, as far as the recipe states them.
    pub(super) fn writing(&self) -> Writing {
        let separator = |delimiter: Delimiter| match delimiter {
            Delimiter::Comma => Some(b','),
            Delimiter::Semicolon => Some(b';'),
            Delimiter::Tab => Some(b'\t'),
            Delimiter::Blanks => None,
        };
        Writing {
            separator: self.delimiter.map(separator),
            decimal_comma: self.decimal_comma,
        }
    }

    /// The column of times, as an option would name it.
    #[must_use]
    pub fn clock(&self) -> Option<TimeColumn> {
        let time = self.time.as_ref()?;
        Some(TimeColumn {
            name: time.column.clone(),
            unit: time.unit,
        })
    }
}

/// A gain and an offset have to be numbers that counts can come from.
fn gain_of(source: &Source, table: &str, gain: Option<f64>, offset: f64) -> Result<(), FileError> {
    let at = |name: &str| super::wording::inside(table, name);
    if gain.is_some_and(|gain| gain.abs() < 1e-9 || gain.abs() > 1e12) {
        return Err(source.bad(&at("gain"), "counts per unit, other than 0"));
    }
    source.range(&at("offset"), &offset, -1e12..=1e12, "counts")
}

#[cfg(test)]
#[path = "recipe_tests.rs"]
mod tests;
