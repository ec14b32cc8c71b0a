//! A recording and the recipe that says how it is to be read.

use std::path::{Path, PathBuf};

use palpate_files::{
    FileError, FileKind, Format, Loaded, Recipe, RecipePlan, SensorLayout, Source, TimeColumn,
    Timing, format_of, kind_of, load_recipe, plan_of,
};
use palpate_run::Failure;

use super::taxel_csv::Reading;

/// A recording, and its recipe where there is one.
#[derive(Debug)]
pub struct Recorded {
    /// The recording.
    pub file: PathBuf,
    /// Recipe of the recording.
    recipe: Option<Loaded<Recipe>>,
    /// `true` where the recipe was found beside the recording.
    is_beside: bool,
}

impl Recorded {
    /// The recording `file` by the recipe that is named, by itself where it is a recipe, or by the one beside it.
    ///
    /// # Errors
    /// A recipe that cannot be, or that names no recording where it stands for one.
    pub fn find(named: Option<&Path>, file: &Path) -> Result<Self, Failure> {
        let load = |path: &Path| load_recipe(&path.display().to_string());
        let is_recipe = |path: &Path| {
            let source = Source::open(path);
            source.is_ok_and(|source| kind_of(&source) == Ok(FileKind::Recording))
        };
        let mut recorded = Self {
            file: file.to_owned(),
            recipe: named.map(load).transpose()?,
            is_beside: false,
        };
        if named.is_some() {
            return Ok(recorded);
        }
        let beside = file.with_extension("toml");
        if format_of(file) == Some(Format::Toml) && is_recipe(file) {
            let recipe = load(file)?;
            let name = recipe.value.recording.as_ref();
            let name =
                name.ok_or_else(|| recipe.source.bad("recording", "the recording's path"))?;
            recorded.file = beside_of(&recipe.source, name);
            recorded.recipe = Some(recipe);
        } else if file.extension().is_some_and(|end| end != "toml")
            && beside.is_file()
            && is_recipe(&beside)
        {
            let recipe = load(&beside)?;
            let name = recipe.value.recording.as_ref();
            if name.is_none_or(|name| beside_of(&recipe.source, name) == file) {
                recorded.recipe = Some(recipe);
                recorded.is_beside = true;
            }
        }
        Ok(recorded)
    }

    /// Note on a recipe that was not named.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        let recipe = self.recipe.as_ref().filter(|_| self.is_beside)?;
        Some(format!(
            "{}: read by the recipe {} beside it",
            self.file.display(),
            recipe.source.label()
        ))
    }

    /// The path of the recipe.
    #[must_use]
    pub fn recipe(&self) -> Option<PathBuf> {
        Some(self.recipe.as_ref()?.source.label().into())
    }

    /// The layout that the recipe names: a built-in name or a path.
    #[must_use]
    pub fn layout(&self) -> Option<String> {
        let Loaded { value, source } = self.recipe.as_ref()?;
        let name = &value.layout;
        Some(match FileKind::Layout.names().contains(&name.as_str()) {
            true => name.clone(),
            false => beside_of(source, name).display().to_string(),
        })
    }

    /// The column of times, where no rate was typed.
    #[must_use]
    pub fn time(&self, typed_hz: Option<f64>) -> Option<TimeColumn> {
        self.recipe
            .as_ref()
            .filter(|_| typed_hz.is_none())?
            .value
            .clock()
    }

    /// The topic whose messages are rows.
    #[must_use]
    pub fn topic(&self) -> Option<String> {
        self.recipe.as_ref()?.value.topic.clone()
    }

    /// Rows per second.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        self.recipe.as_ref()?.value.rate_hz
    }

    /// The recipe for the layout that it names.
    ///
    /// # Errors
    /// A layout that cannot be read, or that the recipe does not fit.
    pub fn own_plan(&self) -> Result<Option<RecipePlan>, FileError> {
        let recipe = self.recipe.as_ref();
        recipe.map(|recipe| Ok(plan_of(recipe)?.0)).transpose()
    }

    /// The recipe for a layout.
    ///
    /// # Errors
    /// A recipe that does not fit the layout.
    pub fn plan(&self, layout: &SensorLayout) -> Result<Option<RecipePlan>, FileError> {
        let recipe = self.recipe.as_ref();
        recipe
            .map(|recipe| RecipePlan::new(&recipe.value, &recipe.source, layout))
            .transpose()
    }
}

/// The reading of a recording by its recipe, for a skin, where none was named; the recording comes with it, and a note. None
/// without a recipe.
///
/// # Errors
/// A recipe that cannot be, or does not fit the skin.
pub(super) fn by_recipe(
    path: &Path,
    reading: &Reading,
    skin: &SensorLayout,
) -> Result<Option<(PathBuf, Reading, Option<String>)>, Failure> {
    let timing = &reading.timing;
    if reading.recipe.is_some() || reading.prefix.is_some() || timing.column.is_some() {
        return Ok(None);
    }
    let found = Recorded::find(None, path)?;
    let Some(recipe) = found.plan(skin)? else {
        return Ok(None);
    };
    let by_it = Reading {
        timing: Timing {
            column: found.time(timing.rate_hz),
            rate_hz: timing.rate_hz.or_else(|| found.rate_hz()),
            topic: timing.topic.clone().or_else(|| found.topic()),
            ..timing.clone()
        },
        prefix: None,
        recipe: Some(recipe),
    };
    let note = found.note();
    Ok(Some((found.file, by_it, note)))
}

/// A path in a recipe, from the recipe's folder on.
fn beside_of(source: &Source, name: &str) -> PathBuf {
    let folder = source.folder();
    folder.map_or_else(|| name.into(), |folder| folder.join(name))
}

#[cfg(test)]
#[path = "recorded_tests.rs"]
mod tests;
