//! Files and streams that are either whole or not there.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use crate::failure::Failure;

/// Writes a file through a neighbour of it that is renamed at the end, so that an error or a full disk
/// leaves nothing half-written behind.
///
/// # Errors
/// [`Failure::Write`] with the path and what the system said.
pub fn write_file(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    let name = path
        .file_name()
        .map(|n| n.to_string_lossy().into_owned())
        .unwrap_or_default();
    let partial = path.with_file_name(format!(".{name}.partial"));
    let written = fs::File::create(&partial).and_then(|file| {
        let mut out = io::BufWriter::new(file);
        content(&mut out)?;
        out.into_inner()
            .map_err(io::IntoInnerError::into_error)?
            .sync_all()
    });
    written
        .and_then(|()| fs::rename(&partial, path))
        .map_err(|error| {
            // Best effort: the error to tell is the first one.
            let _ = fs::remove_file(&partial);
            Failure::Write {
                path: path.display().to_string(),
                error,
            }
        })
}

/// Writes to standard output. A reader that has gone away (`hil ... | head`) is no error.
///
/// # Errors
/// [`Failure::Write`] for anything else, such as a full disk behind a redirection.
pub fn print(content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    match content(&mut out).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::Write {
            path: "standard output".into(),
            error,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_half_written_stays() {
        let folder = std::env::temp_dir().join(format!("palpate-output-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("schedule.jsonl");
        let failed = write_file(&path, |out| {
            out.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert_eq!(failed.unwrap_err().status(), 3);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
        write_file(&path, |out| out.write_all(b"whole")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "whole");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
        let nowhere = write_file(&folder.join("x"), |_| Ok(())).unwrap_err();
        assert!(
            nowhere.to_string().contains("cannot be written"),
            "{nowhere}"
        );
    }
}
