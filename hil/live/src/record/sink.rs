//! A record that grows, in any of the formats.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use palpate_files::Format;
use palpate_records::mcap::{Attachment, BusTraffic, McapRecording};
use palpate_records::readings::ModulePlaces;
use palpate_records::trace::event::each;
use palpate_records::trace::{DisplayInfo, Header};
use palpate_records::vcd::Vcd;
use palpate_records::{contacts_csv, schedule};

use crate::output::{Outputs, Unfinished, is_ordinary, write_sidecar};
use crate::recording::write_can_log;
use palpate_run::{Failure, Piece};

/// Subject of a recording.
#[derive(Clone, Copy, Debug)]
pub enum About<'a> {
    /// A run, the modules whose readings will come, and the files it goes back to.
    Run(&'a Header, &'a [ModulePlaces], &'a [Attachment]),
    /// Sensor buses alone: bus n is the n-th of these interfaces.
    Buses(&'a [String]),
}

/// Longest stretch that is lost when the program is killed, microseconds of the recording's time.
const FLUSH_US: u64 = 100_000;

enum Form {
    /// Contacts, with the displays where there are several.
    Contacts(Vec<DisplayInfo>, Lines),
    /// Frames, with the names of the interfaces where they are known.
    Candump(Vec<String>, Lines),
    /// Entries, with the period of the boards, ns.
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
            // The part of this piece that still fitted goes again; a pipe has no length, and no disk.
            Err(_) => drop(self.file.set_len(self.length)),
        }
        written
    }
}

/// A file that grows.
pub struct Sink {
    path: PathBuf,
    /// The unfinished file, where the name appears only once the file is whole.
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

impl Sink {
    /// Creates files with their first lines. Everything written until something ends the program stays.
    ///
    /// # Errors
    /// [`Failure::Write`] for the first that cannot be written, [`Failure::Input`] for one that may not be replaced and
    /// for a format that buses alone do not fill.
    pub fn create_all(
        files: &[(Format, PathBuf)],
        about: &About<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Vec<Self>, Failure> {
        let create = |(format, path): &(Format, PathBuf)| {
            let file = outputs.grow(path, *format)?;
            Self::create(*format, path, file, about)
        };
        files.iter().map(create).collect()
    }

    /// Creates files whose names appear only once they are whole.
    ///
    /// # Errors
    /// Errors of [`Sink::create_all`].
    pub fn begin_all(
        files: &[(Format, PathBuf)],
        about: &About<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Vec<Self>, Failure> {
        let begin = |(format, path): &(Format, PathBuf)| {
            let (unfinished, file) = outputs.begin(path, *format)?;
            let again = file.try_clone().map_err(Failure::written(path))?;
            Ok(Self {
                unfinished: Some((unfinished, file)),
                ..Self::create(*format, path, again, about)?
            })
        };
        files.iter().map(begin).collect()
    }

    fn create(format: Format, path: &Path, file: File, about: &About<'_>) -> Result<Self, Failure> {
        let told = || Failure::written(path);
        let form = match (format, about) {
            (Format::Mcap, _) => {
                let out = BufWriter::with_capacity(1 << 16, file);
                let recording = match about {
                    About::Run(header, modules, attachments) => {
                        McapRecording::of_run(header, modules, attachments, out)
                    }
                    About::Buses(interfaces) => McapRecording::of_buses(interfaces, out),
                };
                let mut recording = recording.map_err(told())?;
                recording.flush().map_err(told())?;
                Form::Mcap(Box::new(recording))
            }
            (Format::Vcd, About::Run(header, ..)) => {
                let mut vcd = Vcd::begin(header, BufWriter::new(file)).map_err(told())?;
                vcd.get_mut().flush().map_err(told())?;
                Form::Vcd(Box::new(vcd))
            }
            (Format::Contacts | Format::Schedule | Format::Candump, About::Run(header, ..)) => {
                let mut first = Vec::new();
                let begun = match format {
                    Format::Contacts => {
                        write_sidecar(path, Some(header))?;
                        contacts_csv::write_header(&header.displays, &mut first)
                    }
                    Format::Schedule => schedule::write_header(header, &mut first),
                    _ => Ok(()),
                };
                let mut lines = Lines { file, length: 0 };
                begun.and_then(|()| lines.append(&first)).map_err(told())?;
                match format {
                    Format::Schedule => Form::Schedule(header.pre_scale.period_ns(), lines),
                    Format::Contacts => Form::Contacts(header.displays.clone(), lines),
                    _ => Form::Candump(Vec::new(), lines),
                }
            }
            (Format::Candump, About::Buses(interfaces)) => {
                Form::Candump(interfaces.to_vec(), Lines { file, length: 0 })
            }
            (format, About::Run(..)) => {
                return Err(Failure::Input(format!(
                    "{}: expected a record that grows, found {}",
                    path.display(),
                    format.noun()
                )));
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

    /// Path of a pipe, socket or terminal, which takes data only while somebody reads; `None` for an ordinary file.
    pub fn stream(&self) -> Option<&Path> {
        (!is_ordinary(&self.path)).then_some(&self.path)
    }

    /// Appends a piece.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file and the system's error.
    pub fn piece(&mut self, piece: &Piece) -> Result<(), Failure> {
        self.append(piece).map_err(Failure::written(&self.path))
    }

    fn append(&mut self, piece: &Piece) -> io::Result<()> {
        let event = piece.events.last().map(|e| e.t_ns() / 1000);
        let frame = piece.can.last().map(|f| f.at.as_micros());
        self.now_us = self.now_us.max(event.max(frame).unwrap_or(0));
        let due = self.now_us >= self.flushed_us.saturating_add(FLUSH_US);
        if due {
            self.flushed_us = self.now_us;
        }
        match &mut self.form {
            Form::Contacts(displays, lines) => {
                let mut text = Vec::new();
                contacts_csv::write_rows(each(&piece.events), displays, &mut text)?;
                lines.append(&text)
            }
            Form::Candump(interfaces, lines) => {
                let mut text = Vec::new();
                write_can_log(&piece.can, interfaces, &mut text)?;
                lines.append(&text)
            }
            Form::Schedule(period_ns, lines) => {
                let mut text = Vec::new();
                schedule::write_records(&piece.events, *period_ns, &mut text)?;
                lines.append(&text)
            }
            Form::Mcap(recording) => {
                let traffic = BusTraffic {
                    can: &piece.can,
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

    /// Closes the file with its last lines.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file and the system's error.
    pub fn finish(self) -> Result<(), Failure> {
        let closed = match self.form {
            Form::Contacts(..) | Form::Candump(..) | Form::Schedule(..) => Ok(()),
            Form::Mcap(recording) => recording.finish().map(drop),
            Form::Vcd(vcd) => vcd.finish(self.now_us.saturating_mul(1000)),
        };
        let closed = closed.and_then(|()| match self.unfinished {
            Some((unfinished, file)) => unfinished.finish(&file),
            None => Ok(()),
        });
        closed.map_err(Failure::written(&self.path))
    }
}

/// Path of a display's own file among several: `run.mcap` is `run-index.mcap` of the display `index`.
pub fn path_of(path: &Path, display: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{display}.{ending}"))
}
