//! Contacts between frames: carried on to the instant of an onset.

use alloc::boxed::Box;
use alloc::vec;

use crate::units::{Duration, Instant, Point};

/// State of one contact.
#[derive(Clone, Copy, Debug)]
struct Track {
    id: u32,
    /// Place and time of the newest frame.
    place: Point,
    at: Instant,
    /// Velocity, mm/us.
    velocity: (f32, f32),
    /// `true` for a contact of the newest frame.
    seen: bool,
}

/// The contacts of the driving module.
///
/// Onsets do not wait for frames: 58.5 ms are 5.85 frames at 100 Hz. A contact is carried on with its
/// velocity, so that what is felt at an onset is where the contact is then.
#[derive(Clone, Debug)]
pub(crate) struct Tracks {
    slots: Box<[Option<Track>]>,
    ahead: Duration,
}

/// Longest time for which a contact is carried on unless stated: two frames at 100 Hz.
pub const AHEAD: Duration = Duration::from_millis(20);

/// Part of a new difference that goes into the velocity: noise of frames counts a quarter.
const SMOOTHING: f32 = 0.25;

impl Tracks {
    /// Tracks of at most `most` contacts, carried on for `ahead` at most: an older one stands still. The last time it allocates.
    pub fn new(most: usize, ahead: Duration) -> Self {
        Self {
            slots: vec![None; most].into(),
            ahead,
        }
    }

    /// Forgets all contacts: what comes next comes for the first time.
    pub fn clear(&mut self) {
        self.slots.fill(None);
    }

    /// Takes the contacts of a frame, by identity and place in display mm, at the frame's time. The same
    /// frame again changes nothing.
    pub fn observe(&mut self, at: Instant, contacts: impl Iterator<Item = (u32, Point)>) {
        for track in self.slots.iter_mut().flatten() {
            track.seen = false;
        }
        for (id, place) in contacts {
            let known = self.slots.iter_mut().flatten().find(|t| t.id == id);
            if let Some(track) = known {
                track.seen = true;
                let passed = at.since(track.at).as_micros();
                if passed > 0 {
                    let per = SMOOTHING / passed as f32;
                    let keep = 1.0 - SMOOTHING;
                    track.velocity = (
                        keep * track.velocity.0 + per * (place.x - track.place.x),
                        keep * track.velocity.1 + per * (place.y - track.place.y),
                    );
                    (track.place, track.at) = (place, at);
                }
                continue;
            }
            let free = self.slots.iter_mut().find(|s| s.is_none_or(|t| !t.seen));
            if let Some(slot) = free {
                *slot = Some(Track {
                    id,
                    place,
                    at,
                    velocity: (0.0, 0.0),
                    seen: true,
                });
            }
        }
        for slot in &mut self.slots {
            if slot.is_some_and(|t| !t.seen) {
                *slot = None;
            }
        }
    }

    /// Place of a contact at `now`, display mm; `None` for a contact that the newest frame did not have.
    pub fn place(&self, id: u32, now: Instant) -> Option<Point> {
        let track = self.slots.iter().flatten().find(|t| t.id == id)?;
        let ahead = now.since(track.at).min(self.ahead).as_micros() as f32;
        Some(Point::new(
            track.place.x + ahead * track.velocity.0,
            track.place.y + ahead * track.velocity.1,
        ))
    }
}

#[cfg(test)]
#[path = "track_tests.rs"]
mod tests;
