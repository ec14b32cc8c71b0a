//! A record that grows, in any of the formats.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use palpate_files::Format;
use palpate_records::mcap::{Attachment, BusTraffic, McapRecording};
use palpate_records::readings::ModulePlaces;
use palpate_records::trace::Header;
use palpate_records::trace::event::each;
use palpate_records::vcd::Vcd;
use palpate_records::{contacts_csv, schedule};

use super::piece::Piece;
use crate::output::{Outputs, Unfinished, write_sidecar};
use crate::recording::write_can_log;
use palpate_run::Failure;

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Contacts, CSV.
    Contacts,
    /// The schedule, JSON Lines.
    Schedule,
    /// The CAN side, as candump logs it.
    Can,
    /// Everything, MCAP.
    Mcap,
    /// Commanded ticks, VCD.
    Vcd,
}

impl Kind {
    /// Whether each of several displays has a file of its own.
    #[must_use]
    pub const fn is_per_display(self) -> bool {
        matches!(self, Self::Mcap | Self::Vcd)
    }

    /// Its format.
    #[must_use]
    pub const fn format(self) -> Format {
        match self {
            Self::Contacts => Format::Contacts,
            Self::Schedule => Format::Schedule,
            Self::Can => Format::Candump,
            Self::Mcap => Format::Mcap,
            Self::Vcd => Format::Vcd,
        }
    }
}

/// What is recorded.
#[derive(Clone, Copy, Debug)]
pub enum About<'a> {
    /// A run, the modules whose readings will come, and the files it goes back to.
    Run(&'a Header, &'a [ModulePlaces], &'a [Attachment]),
    /// Sensor buses alone: bus n is the n-th of these interfaces.
    Buses(&'a [String]),
}

/// So much may be lost when the program is killed, microseconds of the recording's time.
const FLUSH_US: u64 = 100_000;

enum Form {
    Lines(Kind, Vec<String>, Lines),
    /// With the period of the boards, ns.
    Schedule(u64, Lines),
    Mcap(Box<McapRecording<BufWriter<File>>>),
    Vcd(Box<Vcd<BufWriter<File>>>),
}

/// Whole lines, each piece in one write: a death in between leaves no half of one, and neither does a full disk.
struct Lines {
    file: File,
    /// Bytes in whole pieces.
    length: u64,
}

impl Lines {
    fn append(&mut self, text: &[u8]) -> io::Result<()> {
        let written = self.file.write_all(text);
        match written {
            Ok(()) => self.length += text.len() as u64,
            // What of this piece still fitted goes again; a pipe has no length, and no disk.
            Err(_) => drop(self.file.set_len(self.length)),
        }
        written
    }
}

/// A file that grows.
pub struct Sink {
    path: PathBuf,
    /// Where it is there only once it is whole.
    unfinished: Option<(Unfinished, File)>,
    form: Form,
    /// Time of the newest event, and at the last flush.
    now_us: u64,
    flushed_us: u64,
}

impl std::fmt::Debug for Sink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Sink")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

fn failure(path: &Path, error: io::Error) -> Failure {
    Failure::Write {
        path: path.display().to_string(),
        error,
    }
}

impl Sink {
    /// Creates files with what comes first in them. What is written until something ends the program stays.
    ///
    /// # Errors
    /// [`Failure::Write`] for the first that cannot be written, [`Failure::Input`] for one that may not be replaced and
    /// for a format that buses alone do not fill.
    pub fn create_all(
        files: &[(Kind, PathBuf)],
        about: &About<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Vec<Self>, Failure> {
        let create = |(kind, path): &(Kind, PathBuf)| {
            let file = outputs.grow(path, kind.format())?;
            Self::create(*kind, path, file, about)
        };
        files.iter().map(create).collect()
    }

    /// The same, of files that are there only once they are whole.
    ///
    /// # Errors
    /// As [`Sink::create_all`].
    pub fn begin_all(
        files: &[(Kind, PathBuf)],
        about: &About<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Vec<Self>, Failure> {
        let begin = |(kind, path): &(Kind, PathBuf)| {
            let (unfinished, file) = outputs.begin(path, kind.format())?;
            let again = file.try_clone().map_err(|error| failure(path, error))?;
            Ok(Self {
                unfinished: Some((unfinished, file)),
                ..Self::create(*kind, path, again, about)?
            })
        };
        files.iter().map(begin).collect()
    }

    fn create(kind: Kind, path: &Path, file: File, about: &About<'_>) -> Result<Self, Failure> {
        let told = |error| failure(path, error);
        let form = match (kind, about) {
            (Kind::Mcap, _) => {
                let out = BufWriter::with_capacity(1 << 16, file);
                let recording = match about {
                    About::Run(header, modules, attachments) => {
                        McapRecording::of_run(header, modules, attachments, out)
                    }
                    About::Buses(interfaces) => McapRecording::of_buses(interfaces, out),
                };
                let mut recording = recording.map_err(told)?;
                recording.flush().map_err(told)?;
                Form::Mcap(Box::new(recording))
            }
            (Kind::Vcd, About::Run(header, ..)) => {
                let mut vcd = Vcd::begin(header, BufWriter::new(file)).map_err(told)?;
                vcd.get_mut().flush().map_err(told)?;
                Form::Vcd(Box::new(vcd))
            }
            (_, About::Run(header, ..)) => {
                let mut first = Vec::new();
                let rendered = match kind {
                    Kind::Contacts => {
                        write_sidecar(path, Some(header))?;
                        writeln!(first, "{}", contacts_csv::HEADER)
                    }
                    Kind::Schedule => schedule::write_header(header, &mut first),
                    _ => Ok(()),
                };
                let mut lines = Lines { file, length: 0 };
                rendered.and_then(|()| lines.append(&first)).map_err(told)?;
                match kind {
                    Kind::Schedule => Form::Schedule(header.pre_scale.period_ns(), lines),
                    _ => Form::Lines(kind, Vec::new(), lines),
                }
            }
            (Kind::Can, About::Buses(interfaces)) => {
                Form::Lines(kind, interfaces.to_vec(), Lines { file, length: 0 })
            }
            (_, About::Buses(_)) => {
                return Err(Failure::Input(format!(
                    "{}: expected .log or .mcap for a recording of buses",
                    path.display()
                )));
            }
        };
        Ok(Self {
            path: path.into(),
            unfinished: None,
            form,
            now_us: 0,
            flushed_us: 0,
        })
    }

    /// Appends a piece.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file and what the system said.
    pub fn piece(&mut self, piece: &Piece) -> Result<(), Failure> {
        self.append(piece)
            .map_err(|error| failure(&self.path, error))
    }

    fn append(&mut self, piece: &Piece) -> io::Result<()> {
        let event = piece.events.last().map(|e| e.t_ns() / 1000);
        let frame = piece.frames.last().map(|f| f.at.as_micros());
        self.now_us = self.now_us.max(event.max(frame).unwrap_or(0));
        let due = self.now_us >= self.flushed_us.saturating_add(FLUSH_US);
        if due {
            self.flushed_us = self.now_us;
        }
        match &mut self.form {
            Form::Lines(kind, interfaces, lines) => {
                let mut text = Vec::new();
                match kind {
                    Kind::Contacts => contacts_csv::write_rows(each(&piece.events), &mut text)?,
                    _ => write_can_log(&piece.frames, interfaces, &mut text)?,
                }
                lines.append(&text)
            }
            Form::Schedule(period_ns, lines) => {
                let mut text = Vec::new();
                schedule::write_records(&piece.events, *period_ns, &mut text)?;
                lines.append(&text)
            }
            Form::Mcap(recording) => {
                let traffic = BusTraffic {
                    can: &piece.frames,
                    i2c: &piece.i2c,
                    taxels: &piece.taxels,
                };
                recording.piece(&piece.events, traffic)?;
                if due { recording.flush() } else { Ok(()) }
            }
            Form::Vcd(vcd) => {
                vcd.events(&piece.events)?;
                if due { vcd.get_mut().flush() } else { Ok(()) }
            }
        }
    }

    /// Closes the file with what comes last in it.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file and what the system said.
    pub fn finish(self) -> Result<(), Failure> {
        let closed = match self.form {
            Form::Lines(..) | Form::Schedule(..) => Ok(()),
            Form::Mcap(recording) => recording.finish().map(drop),
            Form::Vcd(vcd) => vcd.finish(self.now_us.saturating_mul(1000)),
        };
        let closed = closed.and_then(|()| match self.unfinished {
            Some((unfinished, file)) => unfinished.finish(&file),
            None => Ok(()),
        });
        closed.map_err(|error| failure(&self.path, error))
    }
}

/// Where one of several displays has its file: `run.mcap` is `run-index.mcap` of the display `index`.
pub fn path_of(path: &Path, display: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{display}.{ending}"))
}

/// The kind of a record by the ending of its name.
pub fn kind_of(path: &Path) -> Option<Kind> {
    match path.extension()?.to_str()? {
        "csv" => Some(Kind::Contacts),
        "jsonl" => Some(Kind::Schedule),
        "log" => Some(Kind::Can),
        "mcap" => Some(Kind::Mcap),
        "vcd" => Some(Kind::Vcd),
        _ => None,
    }
}
