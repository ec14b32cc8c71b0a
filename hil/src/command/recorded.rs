//! A recording and the recipe that says how it is to be read.

use std::path::{Path, PathBuf};

use palpate_files::{
    FileError, FileKind, Format, Loaded, Recipe, RecipePlan, SensorLayout, Source, TimeColumn,
    format_of, kind_of, load_recipe,
};
use palpate_run::Failure;

/// A recording, and its recipe where there is one.
#[derive(Debug)]
pub(super) struct Recorded {
    /// The recording.
    pub(super) file: PathBuf,
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
    pub(super) fn of(named: Option<&Path>, file: &Path) -> Result<Self, Failure> {
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
    pub(super) fn note(&self) -> Option<String> {
        let recipe = self.recipe.as_ref().filter(|_| self.is_beside)?;
        Some(format!(
            "{}: read by the recipe {} beside it",
            self.file.display(),
            recipe.source.label()
        ))
    }

    /// The path of the recipe.
    pub(super) fn recipe(&self) -> Option<PathBuf> {
        Some(self.recipe.as_ref()?.source.label().into())
    }

    /// The layout that the recipe names: a built-in name or a path.
    pub(super) fn layout(&self) -> Option<String> {
        let Loaded { value, source } = self.recipe.as_ref()?;
        let name = &value.layout;
        Some(match FileKind::Layout.names().contains(&name.as_str()) {
            true => name.clone(),
            false => beside_of(source, name).display().to_string(),
        })
    }

    /// The column of times, where no rate was typed.
    pub(super) fn time(&self, typed_hz: Option<f64>) -> Option<TimeColumn> {
        self.recipe
            .as_ref()
            .filter(|_| typed_hz.is_none())?
            .value
            .clock()
    }

    /// Rows per second.
    pub(super) fn rate_hz(&self) -> Option<f64> {
        self.recipe.as_ref()?.value.rate_hz
    }

    /// The recipe for a layout.
    ///
    /// # Errors
    /// A recipe that does not fit the layout.
    pub(super) fn plan(&self, layout: &SensorLayout) -> Result<Option<RecipePlan>, FileError> {
        let recipe = self.recipe.as_ref();
        recipe
            .map(|recipe| RecipePlan::of(&recipe.value, &recipe.source, layout))
            .transpose()
    }
}

/// A path in a recipe, from the recipe's folder on.
fn beside_of(source: &Source, name: &str) -> PathBuf {
    let folder = source.folder();
    folder.map_or_else(|| name.into(), |folder| folder.join(name))
}
