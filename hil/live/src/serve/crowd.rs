//! Bounded crowds of connections: strangers, whose request is read or answered, and pages, which have shown that they
//! may look. So strangers keep no page out, however many they are, and a newcomer always has a place.

use std::collections::VecDeque;
use std::io;
use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Mutex};

use crate::lock::held;

/// The connection that makes room for a newcomer where a crowd is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leaves {
    /// The first one that came: it had the most time.
    First,
    /// The last one that came: those before it stay, and the last place is always the newest's.
    Last,
}

/// Connections up to a bound.
#[derive(Debug)]
pub(super) struct Crowd {
    most: usize,
    leaves: Leaves,
    inside: Mutex<Inside>,
}

#[derive(Debug, Default)]
struct Inside {
    /// Connections so far: the number of the next one.
    came: u64,
    /// Connections in the order in which they came.
    streams: VecDeque<(u64, TcpStream)>,
}

/// A place in a crowd, given back when this is dropped.
#[derive(Debug)]
pub(super) struct Place {
    crowd: Arc<Crowd>,
    number: u64,
}

impl Crowd {
    /// An empty crowd, for so many connections.
    pub(super) fn new(most: usize, leaves: Leaves) -> Arc<Self> {
        Arc::new(Self {
            most,
            leaves,
            inside: Mutex::default(),
        })
    }

    /// Gives a connection a place. Where the crowd is full, another one is shut down for it.
    pub(super) fn enter(self: &Arc<Self>, stream: &TcpStream) -> io::Result<Place> {
        let own = stream.try_clone()?;
        let mut inside = held(&self.inside);
        if inside.streams.len() >= self.most {
            let left = match self.leaves {
                Leaves::First => inside.streams.pop_front(),
                Leaves::Last => inside.streams.pop_back(),
            };
            // Its thread finds the connection at its end, as when a browser goes away.
            left.iter().for_each(|(_, stream)| {
                let _ = stream.shutdown(Shutdown::Both);
            });
        }
        let number = inside.came;
        inside.came += 1;
        inside.streams.push_back((number, own));
        Ok(Place {
            crowd: Arc::clone(self),
            number,
        })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut inside = held(&self.crowd.inside);
        inside.streams.retain(|(number, _)| *number != self.number);
    }
}

#[cfg(test)]
#[path = "crowd_tests.rs"]
mod tests;
