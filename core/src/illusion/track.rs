//! Contacts between frames: carried on to the instant of an onset, and held until a step can be felt.

use alloc::boxed::Box;
use alloc::vec;

use crate::units::{Instant, Point};

/// What is known of one contact.
#[derive(Clone, Copy, Debug)]
struct Track {
    id: u32,
    /// Place and time of the newest frame.
    place: Point,
    at: Instant,
    /// Velocity, mm/us.
    velocity: (f32, f32),
    /// The place last given out.
    shown: Option<Point>,
    /// Whether the newest frame had it.
    seen: bool,
}

/// The contacts of the driving module.
///
/// Onsets do not wait for frames: 58.5 ms are 5.85 frames at 100 Hz. A contact is carried on with its
/// velocity, so that what is felt at an onset is where the contact is then.
#[derive(Clone, Debug)]
pub struct Tracks {
    slots: Box<[Option<Track>]>,
    /// Smallest step, mm; 0 gives every step.
    step: f32,
}

/// Part of a new difference that goes into the velocity: noise of frames counts a quarter.
const SMOOTHING: f32 = 0.25;
/// A contact is carried on for this long at most, us: two frames at 100 Hz. What is older stands still.
const LONGEST_US: u64 = 20_000;

impl Tracks {
    /// For at most `most` contacts; the last time it allocates. A step of `step` mm or more is given out.
    pub fn new(most: usize, step: f32) -> Self {
        Self {
            slots: vec![None; most].into(),
            step,
        }
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
                    shown: None,
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

    /// Where a contact is at `now`; with a smallest step, where it was last given out until it has gone
    /// that far. `None` for a contact that the newest frame did not have.
    pub fn place(&mut self, id: u32, now: Instant) -> Option<Point> {
        let step = self.step;
        let track = self.slots.iter_mut().flatten().find(|t| t.id == id)?;
        let ahead = now.since(track.at).as_micros().min(LONGEST_US) as f32;
        let here = Point::new(
            track.place.x + ahead * track.velocity.0,
            track.place.y + ahead * track.velocity.1,
        );
        let shown = track.shown.filter(|s| s.distance(here) < step);
        let place = shown.unwrap_or(here);
        track.shown = Some(place);
        Some(place)
    }
}

#[cfg(test)]
#[path = "track_tests.rs"]
mod tests;
