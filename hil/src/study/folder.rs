//! A study's folder: records that are on disk before the next trial begins, and tables as Psych-DS lays them out.
//!
//! `records/participant-N.jsonl` is what counts; `data/` is made from it, after every reply anew.

use std::fs::{self, File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use palpate_files::{Loaded, Protocol, load_protocol, read_bytes};
use palpate_live::output::{make_folder, write_text};
use palpate_run::Failure;
use palpate_study::{Line, Record, Step};

use super::tables::{data, description, sidecar};

/// Longest record, bytes: many times a session of drawings at 120 Hz.
const MOST_BYTES: u64 = 1 << 30;

/// A study's folder.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
}

/// A participant's record that grows.
#[derive(Debug)]
pub struct Writing {
    folder: Folder,
    participant: u32,
    path: PathBuf,
    file: File,
    /// Content of the record so far.
    pub record: Option<Record>,
}

/// Reads the record of the participant whose number is in its name; none where nothing whole was written yet.
fn read(path: &Path) -> Result<Option<Record>, Failure> {
    let bytes = read_bytes(path, "a session's record", MOST_BYTES)?;
    // What was being written when the program died may end within a letter.
    let Some(end) = bytes.iter().rposition(|byte| *byte == b'\n') else {
        return Ok(None);
    };
    let failed = |why: String| Failure::Input(format!("{}: {why}", path.display()));
    let text = str::from_utf8(&bytes[..=end]).map_err(|e| failed(e.to_string()))?;
    let record = Record::read(text).map_err(|e| failed(e.to_string()))?;
    let (own, name) = (
        file_name(record.about.participant),
        path.file_name().unwrap_or_default(),
    );
    match name == own.as_str() {
        true => Ok(Some(record)),
        false => Err(failed(format!(
            "line 1: expected the participant of the file's name, found {}",
            record.about.participant
        ))),
    }
}

/// The name of a participant's record.
fn file_name(participant: u32) -> String {
    format!("participant-{participant}.jsonl")
}

impl Folder {
    /// A folder for a protocol: made, with its description, or found with the same protocol in it.
    ///
    /// # Errors
    /// [`Failure::Input`] for a folder of another protocol, [`Failure::Write`] for one that cannot be written.
    pub fn make(path: &Path, protocol: &Loaded<Protocol>) -> Result<Self, Failure> {
        let folder = Self {
            path: path.to_path_buf(),
        };
        for part in ["records", "data"] {
            make_folder(&path.join(part))?;
        }
        let copy = folder.protocol_path();
        match fs::read_to_string(&copy) {
            Ok(text) if text == protocol.source.text() => {}
            Ok(_) => {
                return Err(Failure::Input(format!(
                    "{}: expected the protocol of this command: a study has one, and another one a folder of its own",
                    copy.display()
                )));
            }
            Err(_) => write_text(&copy, protocol.source.text())?,
        }
        let about = path.join("dataset_description.json");
        write_text(&about, &description(&protocol.value))?;
        Ok(folder)
    }

    /// The folder of a study that exists.
    ///
    /// # Errors
    /// [`Failure::Input`] for another folder.
    pub fn open(path: &Path) -> Result<(Self, Protocol), Failure> {
        let folder = Self {
            path: path.to_path_buf(),
        };
        let copy = folder.protocol_path();
        if !copy.is_file() {
            let found = match path.is_dir() {
                true => "a folder without protocol.toml",
                false => "no such folder",
            };
            return Err(Failure::Input(format!(
                "{}: expected the folder of a study, which `hil study run` makes, found {found}",
                path.display()
            )));
        }
        let protocol = load_protocol(&copy.display().to_string())?.value;
        Ok((folder, protocol))
    }

    fn protocol_path(&self) -> PathBuf {
        self.path.join("protocol.toml")
    }

    /// Every record, by participant.
    ///
    /// # Errors
    /// [`Failure::Input`] with file and line of what is none.
    pub fn records(&self) -> Result<Vec<Record>, Failure> {
        let folder = self.path.join("records");
        let entries = fs::read_dir(&folder)
            .map_err(|e| Failure::Input(format!("{}: {e}", folder.display())))?;
        let mut records = Vec::new();
        for entry in entries.flatten() {
            let path = entry.path();
            if path.extension().is_none_or(|ending| ending != "jsonl") {
                continue;
            }
            records.extend(read(&path)?);
        }
        records.sort_by_key(|record| record.about.participant);
        Ok(records)
    }

    /// Writes a file of the analysis.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file.
    pub fn write(&self, name: &str, text: &str) -> Result<PathBuf, Failure> {
        let path = self.path.join("analysis").join(name);
        if let Some(folder) = path.parent() {
            make_folder(folder)?;
        }
        write_text(&path, text)?;
        Ok(path)
    }

    /// Opens a participant's record.
    ///
    /// # Errors
    /// [`Failure::Input`] for a number that is taken: by a session that goes on elsewhere, by one that is over, or without
    /// `resume` by one that is not.
    pub fn participant(&self, number: u32, resume: bool) -> Result<Writing, Failure> {
        let path = self.path.join("records").join(file_name(number));
        let open = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path);
        let mut file = open.map_err(Failure::written(&path))?;
        let taken = |why: &str| {
            Err(Failure::Input(format!(
                "--participant {number}: expected a number that no participant of this study has, found {why} ({})",
                path.display()
            )))
        };
        if file.try_lock().is_err() {
            return taken("a session of it that goes on");
        }
        let record = read(&path)?;
        if let Some(record) = &record {
            let protocol = load_protocol(&self.protocol_path().display().to_string())?.value;
            let session = record
                .resumed(protocol)
                .map_err(|e| Failure::Input(format!("{}: {e}", path.display())))?;
            let over = matches!(session.step(), Step::Done | Step::Declined);
            match (over, resume) {
                (true, _) => return taken("a session of it that is over"),
                (false, false) => {
                    return taken("a session of it that is not over, which --resume goes on with");
                }
                (false, true) => {}
            }
        }
        // What was being written when the program died is no line.
        let whole = record.as_ref().map_or(0, |record| record.whole as u64);
        file.set_len(whole).map_err(Failure::written(&path))?;
        file.seek(SeekFrom::End(0))
            .map_err(Failure::written(&path))?;
        Ok(Writing {
            folder: self.clone(),
            participant: number,
            path,
            file,
            record,
        })
    }
}

impl Writing {
    /// The time, ms, of a line that is written at a time of the session: each line has one of its own, later than the last.
    #[must_use]
    pub fn stamp(&self, now_ms: u64) -> u64 {
        let last_ms = self.record.as_ref().map_or(0, Record::last_ms);
        now_ms.max(last_ms + 1)
    }

    /// Adds a line. It is on the disk when this returns.
    ///
    /// # Errors
    /// [`Failure::Write`] with what the system said, such as a full disk; nothing of the line is kept then.
    pub fn add(&mut self, line: Line) -> Result<(), Failure> {
        let mut text =
            serde_json::to_string(&line).map_err(|e| Failure::written(&self.path)(e.into()))?;
        text.push('\n');
        let before = self
            .file
            .stream_position()
            .map_err(Failure::written(&self.path))?;
        let written = self.file.write_all(text.as_bytes());
        if let Err(e) = written.and_then(|()| self.file.sync_data()) {
            let _ = self.file.set_len(before);
            return Err(Failure::written(&self.path)(e));
        }
        match (&mut self.record, line) {
            (None, Line::Session(about)) => {
                self.record = Some(Record {
                    about,
                    lines: Vec::new(),
                    whole: text.len(),
                });
            }
            (Some(record), line) => {
                record.whole += text.len();
                record.lines.push(line);
            }
            (None, _) => {}
        }
        Ok(())
    }

    /// Makes the participant's tables anew.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file.
    pub fn tables(&self, protocol: &Protocol) -> Result<(), Failure> {
        let Some(record) = &self.record else {
            return Ok(());
        };
        let stem = format!(
            "subject-{}_study-{}_data",
            self.participant,
            protocol.name.replace('-', "")
        );
        let data_folder = self.folder.path.join("data");
        write_text(&data_folder.join(format!("{stem}.csv")), &data(record))?;
        write_text(
            &data_folder.join(format!("{stem}.json")),
            &sidecar(protocol),
        )
    }
}

#[cfg(test)]
#[path = "folder_tests.rs"]
mod tests;
