//! Reading a recording for its run: what its topics say, from any place on.

use std::collections::{BTreeMap, VecDeque};
use std::io;

use super::super::told::{Told, Topic};
use super::{Contents, Counted, McapReader, Read, Unreadable};

/// Topics of a run and their messages that wait.
#[derive(Clone, Debug, Default)]
pub(super) struct Waiting {
    pub(super) topics: BTreeMap<u16, Topic>,
    pub(super) told: VecDeque<Told>,
}

impl<R: io::Read> McapReader<R> {
    /// Begins to read a recording of a run for what happened in it.
    ///
    /// # Errors
    /// The errors of [`McapReader::new`].
    pub fn of_run(input: R) -> Result<Self, Unreadable> {
        let mut reader = Self::new(input)?;
        reader.contents.run = Some(Waiting::default());
        Ok(reader)
    }

    /// Next message of the run, in the order of the file; `None` at the run's end, and where frames are read.
    ///
    /// # Errors
    /// The errors of [`super::read`], and a record of more than 16 MiB.
    pub fn told(&mut self) -> Result<Option<Told>, Unreadable> {
        loop {
            let Some(run) = &mut self.contents.run else {
                return Ok(None);
            };
            if let Some(told) = run.told.pop_front() {
                return Ok(Some(told));
            }
            if self.ended {
                return Ok(None);
            }
            self.step()?;
        }
    }

    /// The byte at which the next record begins, while nothing that was read of those before it waits.
    #[must_use]
    pub fn between(&self) -> Option<u64> {
        let waits = |run: &Waiting| !run.told.is_empty();
        let waits = self.contents.run.as_ref().is_some_and(waits);
        (!waits && !self.ended).then_some(self.input.offset)
    }

    /// Content of the file beside frames, so far.
    #[must_use]
    pub const fn so_far(&self) -> &Read {
        &self.contents.read
    }

    /// Reads the same recording on through another input, whose next byte
    /// is `offset`, between two records. The topics learnt so far stay.
    #[must_use]
    pub fn resumed<S: io::Read>(&self, input: S, offset: u64) -> McapReader<S> {
        let run = self.contents.run.as_ref().map(|run| Waiting {
            topics: run.topics.clone(),
            told: VecDeque::new(),
        });
        McapReader {
            input: Counted { input, offset },
            record: Vec::new(),
            contents: Contents {
                schemas: self.contents.schemas.clone(),
                channels: self.contents.channels.clone(),
                run,
                ..Contents::default()
            },
            ended: false,
        }
    }
}
