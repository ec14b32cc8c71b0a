//! Readers of recordings and of readings that another machine sends during a run: raw counts as CSV, CAN buses as
//! candump logs and MCAP.
#![forbid(unsafe_code)]

mod ahead;
mod can_log;
mod contacts;
mod joints;
mod part;
mod pass;
mod recorded;
mod stream;
mod survey;
mod taxel_csv;
mod taxel_write;

#[cfg(test)]
mod tests;

pub use ahead::{Each, ahead};
pub use can_log::{CanRecording, is_can_recording, read_can_recording, write_can_log};
pub use contacts::compare_recordings;
pub use joints::read_joints;
pub use recorded::Recorded;
pub use stream::ReadingStream;
pub use survey::Survey;
pub use taxel_csv::{Reading, read_taxel_csv};
pub use taxel_write::write_taxel_csv;

use std::path::PathBuf;

use palpate_core::skin::Module;
use palpate_files::{Columns, SensorLayout};
use palpate_run::{Failure, Input, plan};
use part::Part;

/// Reads the recordings that drive a run in place of touches: one per module of a layout, one of all modules side by
/// side, or one of all its buses. A recipe may stand for its recording, or lie beside it. Remarks on the files come with them.
///
/// # Errors
/// [`Failure::Input`] with file, line and column.
pub fn recorded(
    paths: &[PathBuf],
    file: &SensorLayout,
    reading: &Reading,
) -> Result<(Input, Vec<String>), Failure> {
    if let [path] = paths
        && let Some((path, by_it, note)) = recorded::by_recipe(path, reading, file)?
    {
        let (input, notes) = recorded(&[path], file, &by_it)?;
        return Ok((input, note.into_iter().chain(notes).collect()));
    }
    let has_frames = |path: &&PathBuf| reading.timing.topic.is_none() && is_can_recording(path);
    if let Some(log) = paths.iter().find(has_frames) {
        let [log] = paths else {
            return Err(Failure::Input(format!(
                "--replay {}: expected one recording of all buses and nothing beside it, found {} files",
                log.display(),
                paths.len()
            )));
        };
        let layout = plan::layout(file)?;
        let addresses = layout.modules().iter().filter_map(Module::address);
        let buses = addresses.map(|a| usize::from(a.bus) + 1).max();
        if reading.prefix.is_some() || reading.recipe.is_some() || reading.timing.column.is_some() {
            return Err(Failure::Input(format!(
                "{}: expected a table for a recipe, --columns and --time, found a recording of buses",
                log.display()
            )));
        }
        let split = reading.timing.split_jumps;
        let of = (buses.unwrap_or(0), file.bitrate);
        let recording = read_can_recording(log, of, split)?;
        return Ok((Input::Frames(recording.frames), recording.notes));
    }
    if paths.len() != file.modules.len() || (reading.recipe.is_some() && paths.len() > 1) {
        let of_each = format!(
            "--replay: expected {} files, one per module of layout `{}`, found {}",
            file.modules.len(),
            file.name,
            paths.len()
        );
        let [path] = paths else {
            return Err(Failure::Input(of_each));
        };
        let skin = Columns::of_skin(file);
        let whole = read_taxel_csv(path, &skin, reading);
        let (whole, notes) = whole.map_err(|e| {
            Failure::Input(format!("{of_each}, which does not hold all of them: {e}"))
        })?;
        let modules = (0..file.modules.len()).filter_map(|m| Columns::of_module(file, m));
        let widths: Vec<usize> = modules.map(|columns| columns.count()).collect();
        return Ok((Input::Rows(Part::all_of(&whole, &widths)), notes));
    }
    let mut notes = Vec::new();
    let table = |(number, path): (usize, &PathBuf)| {
        let columns = Columns::of_module(file, number).ok_or_else(|| {
            Failure::Input(format!("layout `{}` has no module {number}", file.name))
        })?;
        let (table, said) = read_taxel_csv(path, &columns, reading)?;
        notes.extend(said);
        Ok(table)
    };
    let sources = paths.iter().enumerate().map(table);
    let sources: Result<_, Failure> = sources.collect();
    Ok((Input::Rows(sources?), notes))
}
