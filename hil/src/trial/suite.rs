//! Trials that a command line names: built-in scenes by name, scene files, and folders with the scenes, benches and
//! quarantine of a project.

use std::path::{Path, PathBuf};

use palpate_files::{
    FileError, FileKind, Loaded, Scene, Source, did_you_mean, entries, kind_of, load_scene,
};
use palpate_run::Failure;

use super::GOLDENS;

/// Folders of build systems, which hold no scenes but may hold many files.
const SKIPPED: [&str; 2] = ["target", "node_modules"];
/// Depth to which folders are searched.
const DEPTH: usize = 8;
/// Name of a folder's own quarantine.
const QUARANTINE: &str = "quarantine.toml";

/// A scene that is tried.
#[derive(Clone, Debug)]
pub struct Member {
    /// Content of the scene.
    pub scene: Loaded<Scene>,
    /// File of the scene; `None` for a built-in one.
    pub file: Option<PathBuf>,
}

/// Scenes and files that a command line names.
#[derive(Clone, Debug, Default)]
pub struct Suite {
    /// The scenes, in the order of names and paths.
    pub members: Vec<Member>,
    /// Every scene file in the folders, with those that are left out or cannot be read.
    pub scenes: Vec<PathBuf>,
    /// Bench files in the folders.
    pub benches: Vec<PathBuf>,
    /// Folders of goldens in the folders.
    pub goldens: Vec<PathBuf>,
    /// Files in the folders that cannot be read, and why.
    pub broken: Vec<(PathBuf, String)>,
    /// `true` where only folders are tried, and everything in them.
    pub whole: bool,
    /// The first folder named, where what failed is remembered.
    pub folder: Option<PathBuf>,
    /// A quarantine in that folder.
    pub quarantine: Option<PathBuf>,
}

impl Suite {
    /// Collects what these names, files and folders mean; without any, every built-in scene. Only scenes whose name
    /// contains `filter` stay.
    ///
    /// # Errors
    /// A name that is neither, a path where nothing is, and a named file that cannot be read.
    pub fn collect(targets: &[String], filter: Option<&str>) -> Result<Self, Failure> {
        let mut suite = Self {
            whole: filter.is_none() && targets.iter().all(|t| Path::new(t).is_dir()),
            ..Self::default()
        };
        if targets.is_empty() {
            suite.built_in("")?;
        }
        for target in targets {
            let path = Path::new(target);
            if path.is_dir() {
                suite.search(path, DEPTH)?;
                let quarantine = path.join(QUARANTINE);
                if suite.folder.is_none() {
                    suite.folder = Some(path.to_path_buf());
                    suite.quarantine = quarantine.is_file().then_some(quarantine);
                }
            } else if path.is_file() {
                suite.file(path)?;
            } else if target.ends_with(".toml") || target.contains('/') {
                let expected = "a scene file or a folder with scenes";
                return Err(FileError::whole(target, expected, "no such file or folder").into());
            } else if target.trim().is_empty() {
                let text = "\"\": expected part of a scene's name, a scene file or a folder, found nothing";
                return Err(Failure::Input(text.into()));
            } else {
                suite.built_in(target)?;
            }
        }
        if let Some(part) = filter {
            suite.members.retain(|m| m.scene.value.name.contains(part));
        }
        Ok(suite)
    }

    fn file(&mut self, path: &Path) -> Result<(), FileError> {
        self.members.push(Member {
            scene: load_scene(&path.display().to_string())?,
            file: Some(path.to_path_buf()),
        });
        Ok(())
    }

    /// The built-in scenes whose names contain `part`.
    fn built_in(&mut self, part: &str) -> Result<(), Failure> {
        let before = self.members.len();
        for name in palpate_fixtures::scene_names().filter(|n| n.contains(part)) {
            self.members.push(Member {
                scene: load_scene(name)?,
                file: None,
            });
        }
        if self.members.len() > before {
            return Ok(());
        }
        let all: Vec<&str> = palpate_fixtures::scene_names().collect();
        let meant = did_you_mean(part, all.iter().copied());
        Err(Failure::Input(format!(
            "{part}: expected part of a scene's name (`hil list scenes` has them), a scene file or a folder, found none{meant}"
        )))
    }

    /// Scenes and benches in a folder and those below it, known by what they say.
    fn search(&mut self, folder: &Path, depth: usize) -> Result<(), Failure> {
        for path in entries(folder)? {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
            let name = name.unwrap_or_default();
            if name.starts_with('.') || SKIPPED.contains(&name.as_str()) || name == QUARANTINE {
                continue;
            }
            if path.is_dir() && name == GOLDENS {
                self.goldens.push(path);
                continue;
            }
            if path.is_dir() {
                // A linked folder may lie above this one, and its scenes would be tried twice.
                if depth > 0 && !path.is_symlink() {
                    self.search(&path, depth - 1)?;
                }
                continue;
            }
            if !name.ends_with(".toml") {
                continue;
            }
            match Source::open(&path).and_then(|source| kind_of(&source)) {
                Ok(FileKind::Scene) => {
                    let read = self.file(&path);
                    self.scenes.push(path.clone());
                    read.unwrap_or_else(|error| self.broken.push((path, error.to_string())));
                }
                Ok(FileKind::Bench) => self.benches.push(path),
                Ok(_) => {}
                // It may be a scene: its goldens are not without one.
                Err(error) => {
                    self.scenes.push(path.clone());
                    self.broken.push((path, error.to_string()));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "suite_tests.rs"]
mod tests;
