//! Files and streams that are either whole or not there.

use std::fs;
use std::io::{self, Read, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use palpate_files::{Format, open, unnumbered};
use palpate_records::json::write_json;
use palpate_records::runs::RunTable;
use palpate_records::table_schema::contacts_schema;
use palpate_records::trace::Header;

use palpate_run::Failure;
use serde::Serialize;

use crate::ending::Partial;
use crate::progress::aside;

/// Rules for files that outputs of a command may replace: earlier outputs of their kind alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outputs<'a> {
    /// `true` where anything may be replaced (`--force`).
    pub force: bool,
    /// The recordings that the command reads.
    pub inputs: &'a [PathBuf],
}

/// Beginning of a table of `hil design`.
pub const DESIGNS: &str = "wire,alloy,";
/// Beginning of the table of a frequency response.
pub const RESPONSES: &str = "hz,width_us,";

/// Bytes from a file's start that show its kind.
const START: u64 = 4096;

/// Tells whether a file of this format with this start was written by this program.
fn is_ours(start: &[u8], format: Format) -> bool {
    let text = String::from_utf8_lossy(start);
    match format {
        Format::Contacts | Format::Schedule | Format::Golden | Format::Candump => true,
        Format::Junit => text.contains("name=\"hil\""),
        Format::Json => {
            let marks = ["\"source\"", "\"$schema\"", "\"3D!palpate\""];
            marks.iter().any(|mark| text.contains(mark)) || RunTable::is_one(&text)
        }
        Format::Svg => text.contains("var(--card)"),
        Format::Csv => {
            text.starts_with("time_us,txl1_")
                || text.starts_with("txl1_x,")
                || text.starts_with("label,trained,")
                || text.starts_with(DESIGNS)
                || text.starts_with(RESPONSES)
                || RunTable::is_one(&text)
        }
        _ => text.contains("palpate"),
    }
}

impl Outputs<'_> {
    /// The outputs of a command that reads no recording. With `force` anything may be replaced.
    pub const fn new(force: bool) -> Outputs<'static> {
        Outputs { force, inputs: &[] }
    }

    /// Checks that a file of this format may be written. Commands ask before they begin their work, too.
    ///
    /// # Errors
    /// [`Failure::Input`] for an input, and for a file that is no earlier output of this format.
    pub fn check(self, path: &Path, format: Format) -> Result<(), Failure> {
        if self.force || !is_ordinary(path) {
            return Ok(());
        }
        let Ok(there) = fs::metadata(path) else {
            return Ok(()); // nothing there, or writing it will say why
        };
        let refuse = |found: &str| {
            Err(Failure::Input(format!(
                "{}: expected a new file, or an earlier output of hil in this format ({}), found {found}; --force replaces it",
                path.display(),
                format.noun()
            )))
        };
        let same = |input: &PathBuf| {
            fs::metadata(input).is_ok_and(|i| (i.dev(), i.ino()) == (there.dev(), there.ino()))
        };
        if self.inputs.iter().any(same) {
            return refuse("an input of this command");
        }
        let mut start = Vec::new();
        let read = open(path, "a file").map(|file| file.take(START).read_to_end(&mut start));
        if !matches!(read, Ok(Ok(_))) {
            return refuse("a file that cannot be read");
        }
        match Format::recognise(&start) {
            Some(found) if found == format && is_ours(&start, format) => Ok(()),
            _ if start.is_empty() => Ok(()),
            Some(found) if found == format => refuse("another program's"),
            found => refuse(found.map_or("something else", Format::noun)),
        }
    }

    /// Checks that a table (CSV) with this head may be written, where it has a path: an earlier output of another
    /// command is refused.
    ///
    /// # Errors
    /// Errors of [`Outputs::check`].
    pub fn check_csv(self, path: Option<&Path>, head: &str) -> Result<(), Failure> {
        let Some(path) = path else {
            return Ok(());
        };
        self.check(path, Format::Csv)?;
        let mut start = Vec::new();
        let Ok(file) = open(path, "a table") else {
            return Ok(()); // nothing there, or writing it will say why
        };
        let read = file.take(START).read_to_end(&mut start);
        if self.force || !is_ordinary(path) || read.is_err() || start.is_empty() {
            return Ok(());
        }
        match String::from_utf8_lossy(&start).starts_with(head) {
            true => Ok(()),
            false => Err(Failure::Input(format!(
                "{}: expected a new file, or an earlier output of this command (`{head}..`), found another table; --force replaces it",
                path.display()
            ))),
        }
    }

    /// [`write_file`] where nothing else is lost.
    ///
    /// # Errors
    /// As [`Outputs::check`] and [`write_file`].
    pub fn write(
        self,
        path: &Path,
        format: Format,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        self.check(path, format)?;
        write_file(path, content)
    }

    /// [`Outputs::check`] of an output that is wanted only where it has a path.
    ///
    /// # Errors
    /// Errors of [`Outputs::check`].
    pub fn check_some(self, path: Option<&Path>, format: Format) -> Result<(), Failure> {
        path.map_or(Ok(()), |path| self.check(path, format))
    }

    /// Writes a text that is wanted only where it has a path, where nothing else is lost.
    ///
    /// # Errors
    /// Errors of [`Outputs::write`].
    pub fn write_some(
        self,
        path: Option<&Path>,
        format: Format,
        text: impl FnOnce() -> String,
    ) -> Result<(), Failure> {
        let Some(path) = path else {
            return Ok(());
        };
        self.check(path, format)?;
        write_text(path, &text())
    }

    /// Opens a file that grows while its recording goes on, where nothing else is lost.
    ///
    /// # Errors
    /// Errors of [`Outputs::check`], and [`Failure::Write`] with the system's error.
    pub fn grow(self, path: &Path, format: Format) -> Result<fs::File, Failure> {
        self.check(path, format)?;
        fs::File::create(path).map_err(Failure::written(path))
    }

    /// Opens a file that grows and is there only once it is whole, where nothing else is lost.
    ///
    /// # Errors
    /// As [`Outputs::grow`].
    pub fn begin(self, path: &Path, format: Format) -> Result<(Unfinished, fs::File), Failure> {
        self.check(path, format)?;
        Unfinished::create(path).map_err(Failure::written(path))
    }

    /// Checks that a table of contacts and the schema beside it may be written.
    ///
    /// # Errors
    /// Errors of [`Outputs::check`].
    pub fn check_table(self, table: &Path) -> Result<(), Failure> {
        self.check(table, Format::Contacts)?;
        self.check(&table.with_extension("schema.json"), Format::Json)
    }
}

/// Writes a file through a neighbour of it that is renamed at the end, so that an error or a full disk
/// or a signal leaves nothing half-written behind. What is no ordinary file (a pipe, `/dev/stdout`) is written as it
/// stands: a rename would put a file in a device's place. A link keeps pointing where it points.
///
/// # Errors
/// [`Failure::Write`] with the path and the system's error.
pub fn write_file(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    fn written(path: &Path, content: Content<'_>) -> io::Result<()> {
        let (unfinished, file) = Unfinished::create(path)?;
        let mut out = io::BufWriter::new(file);
        content(&mut out)?;
        let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
        unfinished.finish(&file)
    }
    written(path, &mut once(content)).map_err(Failure::written(path))
}

/// [`write_file`] of a text.
///
/// # Errors
/// Errors of [`write_file`].
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    write_file(path, |out| out.write_all(text.as_bytes()))
}

/// Content as a function that is not generic takes it. Such a function is compiled once and not once per caller.
type Content<'c> = &'c mut dyn FnMut(&mut dyn Write) -> io::Result<()>;

/// Content that is written by the first call; later calls write nothing.
fn once(
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> impl FnMut(&mut dyn Write) -> io::Result<()> {
    let mut content = Some(content);
    move |out| content.take().map_or(Ok(()), |write| write(out))
}

/// An output that is not whole yet. Dropped, its file is gone.
#[derive(Debug)]
pub struct Unfinished {
    /// The neighbour, and the name that it will have; `None` for an output that is no ordinary file.
    partial: Option<(Partial, PathBuf)>,
}

impl Unfinished {
    /// Opens the file that [`write_file`] writes to.
    fn create(path: &Path) -> io::Result<(Self, fs::File)> {
        let whole = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        match fs::metadata(&whole) {
            Ok(there) if there.is_dir() => {
                return Err(io::Error::from(io::ErrorKind::IsADirectory));
            }
            Ok(there) if !there.is_file() || is_stream(path) => {
                let stream = fs::OpenOptions::new().append(true).open(path)?;
                return Ok((Self { partial: None }, stream));
            }
            _ => {}
        }
        let name = whole.file_name().map(|n| n.to_string_lossy().into_owned());
        let name = name.unwrap_or_default();
        // Two runs at once may write the same file: each has its own neighbour.
        let partial = whole.with_file_name(format!(".{name}.{}.partial", std::process::id()));
        let (partial, file) = Partial::create(&partial)?;
        let partial = Some((partial, whole));
        Ok((Self { partial }, file))
    }

    /// Gives the file its name, once it is on the disk.
    ///
    /// # Errors
    /// Error of the system; the file is gone then.
    pub fn finish(self, file: &fs::File) -> io::Result<()> {
        match self.partial {
            None => Ok(()),
            Some((partial, whole)) => {
                file.sync_all()?;
                partial.finish(&whole)
            }
        }
    }
}

/// Tells whether a path is or will be an ordinary file, which can have others beside it.
pub(crate) fn is_ordinary(path: &Path) -> bool {
    !is_stream(path) && fs::metadata(path).map_or(true, |there| there.is_file())
}

/// Tells whether a path names an open stream of this program, which may be a file elsewhere.
fn is_stream(path: &Path) -> bool {
    ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc/self/fd"]
        .iter()
        .any(|stream| path.starts_with(stream))
}

/// Writes the schema of a contacts table beside it: `contacts.csv` has its types and units in
/// `contacts.schema.json`. A table that goes down a pipe has nothing beside it.
///
/// # Errors
/// Errors of [`write_file`].
pub fn write_sidecar(table: &Path, header: Option<&Header>) -> Result<(), Failure> {
    if !is_ordinary(table) {
        return Ok(());
    }
    write_text(
        &table.with_extension("schema.json"),
        &contacts_schema(header),
    )
}

/// Makes a folder and those above it, where they are not there yet.
///
/// # Errors
/// [`Failure::Input`] where something else has that name, [`Failure::Write`] with the path and the system's error.
pub fn make_folder(path: &Path) -> Result<(), Failure> {
    check_folder(path)?;
    fs::create_dir_all(path).map_err(Failure::written(path))
}

/// Checks that a folder is there or may be made. Commands ask before they begin their work.
///
/// # Errors
/// [`Failure::Input`] where something else has that name.
pub fn check_folder(path: &Path) -> Result<(), Failure> {
    match path.exists() && !path.is_dir() {
        true => Err(Failure::Input(format!(
            "{}: expected a folder to write into, found a file",
            path.display()
        ))),
        false => Ok(()),
    }
}

/// Writes a remark on standard error, which may be closed.
pub fn note(text: &str) {
    let _ = aside(|| writeln!(io::stderr(), "note: {}", unnumbered(text)));
}

/// Names the files that a command wrote, below its result.
///
/// # Errors
/// Errors of `out`.
pub fn list_written<'p>(
    mut paths: impl Iterator<Item = &'p PathBuf>,
    out: &mut dyn Write,
) -> io::Result<()> {
    paths.try_for_each(|path| writeln!(out, "  wrote           {}", path.display()))
}

/// Writes to standard output. A reader that has gone away (`hil ... | head`) is no error.
///
/// # Errors
/// [`Failure::Write`] for anything else, such as a full disk behind a redirection.
pub fn print(content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    fn printed(content: Content<'_>) -> io::Result<()> {
        aside(|| {
            let mut out = io::BufWriter::new(io::stdout().lock());
            content(&mut out).and_then(|()| out.flush())
        })
    }
    match printed(&mut once(content)) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::written("standard output")(error))
        }
        _ => Ok(()),
    }
}

/// Writes a value to standard output, as JSON on one line.
///
/// # Errors
/// The errors of [`print()`].
pub fn print_json(value: &(impl Serialize + ?Sized)) -> Result<(), Failure> {
    print(|out| {
        write_json(value, &mut *out)?;
        writeln!(out)
    })
}

#[cfg(test)]
#[path = "output_tests.rs"]
mod tests;
