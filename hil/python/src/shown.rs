//! Pictures of a loop for a page in a notebook, apart from the steps that a caller gets.

use palpate_files::Setup;
use palpate_records::trace::Event;
use palpate_run::picture::{Head, Painter};
use palpate_run::{Failure, Live, header};
use pyo3::prelude::*;
use serde::Serialize;

/// Events that wait for a picture at most; before that they are looked through without one.
const MOST: usize = 1 << 16;

/// A loop's page.
pub struct Shown {
    head: Head,
    painter: Painter,
    /// Events that no picture has told yet.
    waiting: Vec<Event>,
    dropped: u64,
}

fn json<T: Serialize>(told: &T) -> Result<String, Failure> {
    serde_json::to_string(told).map_err(|e| Failure::Device(format!("the page: {e}")))
}

impl Shown {
    /// Begins pictures from now on.
    pub fn new(setup: &Setup, seed: u64, session: &mut dyn Live) -> Result<Self, Failure> {
        let header = header(setup, seed, session.projector())?;
        session.keep_counts();
        Ok(Self {
            head: Head::new(setup, &header, session.projector()),
            painter: Painter::new(setup, &header, session.projector()),
            waiting: Vec::new(),
            dropped: 0,
        })
    }

    /// Head of the pictures, as JSON.
    pub fn head(&self) -> Result<String, Failure> {
        json(&self.head)
    }

    /// Takes events for the next picture.
    pub fn add(&mut self, events: &[Event], dropped: u64) {
        self.dropped += dropped;
        if self.waiting.len() >= MOST {
            self.painter.pass(&self.waiting);
            self.dropped += self.waiting.len() as u64;
            self.waiting.clear();
        }
        self.waiting.extend_from_slice(events);
    }

    /// Picture of the events since the last one and of the state now, as JSON.
    pub fn picture(&mut self, session: &dyn Live) -> Result<String, Failure> {
        let now_us = session.now().as_micros();
        let state = session.state(self.painter.wants(now_us));
        let counts = session.counts();
        let mut picture = self.painter.picture(&self.waiting, counts, state);
        self.waiting.clear();
        picture.dropped = std::mem::take(&mut self.dropped);
        json(&picture)
    }
}

/// The page's own text, and the names and texts of its scripts.
#[pyfunction]
pub fn notebook() -> (String, Vec<(&'static str, &'static str)>) {
    palpate_live::serve::notebook()
}
