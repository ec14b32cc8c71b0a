//! Readings that another machine sends over TCP: lines of text, as in a recording of taxels, one per scan of the whole
//! skin. A line's time of arrival is that of its readings.

use std::fmt;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use palpate_files::{Columns, FileError, Rows, SensorLayout, Take, Text};
use palpate_run::{Failure, NextRow, RowSource};

use crate::lock::held;

/// Time after which a machine that is not reached, or sends nothing, counts as gone.
const PATIENCE: Duration = Duration::from_secs(5);
/// Most bytes of a line, where the skin's own need no more.
const LONGEST: usize = 1 << 20;

/// Readings over a connection, which can be read once.
pub struct ReadingStream {
    rows: Mutex<Option<Rows<TcpStream>>>,
    columns: usize,
    /// Error of a line, once one was wrong.
    wrong: Mutex<Option<FileError>>,
}

impl fmt::Debug for ReadingStream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ReadingStream")
            .field("columns", &self.columns)
            .finish_non_exhaustive()
    }
}

impl ReadingStream {
    /// Connects, and reads the header or first line.
    ///
    /// # Errors
    /// [`Failure::Input`] for a text that is no address, [`Failure::Device`] for a machine that is not reached,
    /// [`Failure::File`] for lines that are not of this skin.
    pub fn open(address: &str, skin: &SensorLayout) -> Result<Arc<Self>, Failure> {
        let columns = &Columns::of_skin(skin);
        let is_port = |port: &str| port.parse::<u16>().is_ok();
        let whole = |(host, port): (&str, &str)| !host.is_empty() && is_port(port);
        let known = address.rsplit_once(':').is_some_and(whole);
        if !known {
            let expected = format!("--stream: expected HOST:PORT, found `{address}`");
            return Err(Failure::Input(expected));
        }
        let label = format!("tcp://{address}");
        let lost = |e: std::io::Error| Failure::Device(format!("{label}: {e}"));
        let mut reached = Err(std::io::Error::other("no such address"));
        for to in address.to_socket_addrs().map_err(lost)? {
            reached = TcpStream::connect_timeout(&to, PATIENCE);
            if reached.is_ok() {
                break;
            }
        }
        let stream = reached.map_err(lost)?;
        stream.set_read_timeout(Some(PATIENCE)).map_err(lost)?;
        let text = Text::new(label, stream, (40 * columns.count()).max(LONGEST));
        let rows = Rows::over(text, Take::Taxels(columns), None)?;
        Ok(Arc::new(Self {
            rows: Mutex::new(Some(rows)),
            columns: columns.count(),
            wrong: Mutex::new(None),
        }))
    }
}

impl RowSource for ReadingStream {
    fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the largest number: the length of a stream is unknown.
    fn frames(&self) -> usize {
        usize::MAX
    }

    /// Returns the largest number: the length of a stream is unknown.
    fn span_us(&self) -> u64 {
        u64::MAX
    }

    fn rows(&self) -> Result<Box<dyn NextRow + '_>, Failure> {
        let mut rows = held(&self.rows);
        let again = || Failure::Input("a stream can be read once".into());
        Ok(Box::new(Coming {
            rows: rows.take().ok_or_else(again)?,
            began: None,
            stream: self,
        }))
    }

    fn wrong(&self) -> Option<FileError> {
        let wrong = held(&self.wrong);
        wrong.clone()
    }
}

/// Lines in the order in which they come.
struct Coming<'a> {
    rows: Rows<TcpStream>,
    began: Option<Instant>,
    stream: &'a ReadingStream,
}

impl NextRow for Coming<'_> {
    fn next_row(&mut self, counts: &mut Vec<u16>) -> Result<Option<u64>, Failure> {
        let row = self.rows.advance(counts).inspect_err(|error| {
            *held(&self.stream.wrong) = Some(error.clone());
        })?;
        let now = crate::clock::now();
        let began = *self.began.get_or_insert(now);
        Ok(row.map(|_| now.duration_since(began).as_micros() as u64))
    }
}
