//! What a program that serves clients says on standard output while it does: words for people, or JSON Lines.

use std::io::{self, BufWriter, Stdout, Write};

use palpate_run::Failure;
use serde::Serialize;

/// How a program speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Telling {
    /// For people.
    Words,
    /// JSON Lines.
    Json,
    /// Not at all.
    Nothing,
}

impl Telling {
    /// The form that the options `--json` and `--quiet` ask for.
    pub const fn of(json: bool, quiet: bool) -> Self {
        match (json, quiet) {
            (true, _) => Self::Json,
            (_, true) => Self::Nothing,
            _ => Self::Words,
        }
    }
}

/// Something that happened: an object of JSON, or words.
pub trait Say: Serialize {
    /// For people; nothing where it does not matter to them.
    ///
    /// # Errors
    /// What the stream says.
    fn words(&self, out: &mut dyn Write) -> io::Result<()>;
}

/// Standard output, in the form that the command line chose.
#[derive(Debug)]
pub struct Teller {
    form: Telling,
    out: Option<BufWriter<Stdout>>,
}

impl Teller {
    /// Speaks in this form.
    pub fn new(form: Telling) -> Self {
        let out = (form != Telling::Nothing).then(|| BufWriter::new(io::stdout()));
        Self { form, out }
    }

    /// Says what happened.
    ///
    /// # Errors
    /// [`Failure::Write`] for a full disk; a reader that went away is no error.
    pub fn tell(&mut self, told: &impl Say) -> Result<(), Failure> {
        let form = self.form;
        self.write(|out| match form {
            Telling::Json => {
                serde_json::to_writer(&mut *out, told)?;
                writeln!(out)
            }
            _ => told.words(out),
        })
    }

    /// Lets readers have what was said so far.
    ///
    /// # Errors
    /// As [`Self::tell`].
    pub fn flush(&mut self) -> Result<(), Failure> {
        self.write(Write::flush)
    }

    fn write(
        &mut self,
        work: impl FnOnce(&mut BufWriter<Stdout>) -> io::Result<()>,
    ) -> Result<(), Failure> {
        match self.out.as_mut().map_or(Ok(()), work) {
            Ok(()) => Ok(()),
            Err(e) if e.kind() == io::ErrorKind::BrokenPipe => {
                self.out = None; // served on, unheard
                Ok(())
            }
            Err(error) => Err(Failure::written("standard output")(error)),
        }
    }
}
