//! The renderer's memory of contacts from onset to onset: how strong each is, and whether it rests.

use crate::units::{Duration, Instant, Point};

/// Contacts that are remembered; where there are more, the oldest are forgotten.
const SLOTS: usize = 16;
/// A contact that was not there for this long is a new one.
const LOST: Duration = Duration::from_millis(300);
/// A contact this far from where one was is another, mm.
const REACH: f32 = 10.0;
/// Slower than this a contact rests, faster than this it moves, mm/s; between, it goes on as it did.
const REST: (f32, f32) = (1.5, 4.0);
/// Part of a new difference that goes into the velocity.
const SMOOTHING: f32 = 0.3;
/// A new contact moves for this long.
const NEW: Duration = Duration::from_millis(500);

/// A contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    place: Point,
    velocity: (f32, f32),
    since: Instant,
    seen: Instant,
    /// Ratio of the contact's amplitude to the one that it wants; `None` before its first onset.
    pub(super) scale: Option<f32>,
    /// `true` for a contact that rests.
    pub(super) rests: bool,
}

impl Track {
    fn new(place: Point, at: Instant) -> Self {
        Self {
            place,
            velocity: (0.0, 0.0),
            since: at,
            seen: at,
            scale: None,
            rests: false,
        }
    }

    fn move_to(&mut self, place: Point, at: Instant) {
        let seconds = at.since(self.seen).as_micros() as f32 * 1e-6;
        if seconds > 0.0 {
            let toward = |old: f32, step: f32| old + SMOOTHING * (step / seconds - old);
            self.velocity.0 = toward(self.velocity.0, place.x - self.place.x);
            self.velocity.1 = toward(self.velocity.1, place.y - self.place.y);
        }
        let (x, y) = self.velocity;
        let speed = libm::sqrtf(x * x + y * y);
        let is_new = at.since(self.since) < NEW;
        self.rests = !is_new && speed < if self.rests { REST.1 } else { REST.0 };
        (self.place, self.seen) = (place, at);
    }
}

/// The contacts of a display.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracks {
    slots: [Option<Track>; SLOTS],
}

impl Tracks {
    /// The contact at `place`: the nearest one that this onset has not met yet, or a new one.
    pub(super) fn follow(&mut self, place: Point, at: Instant) -> &mut Track {
        let far = |track: &Track| track.place.distance(place);
        let known =
            |track: &Track| track.seen < at && at.since(track.seen) <= LOST && far(track) <= REACH;
        let candidates = self.slots.iter().enumerate();
        let candidates = candidates.filter_map(|(i, t)| t.filter(known).map(|t| (i, far(&t))));
        let nearest = candidates.min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, _)) = nearest {
            let track = self.slots[index].get_or_insert(Track::new(place, at));
            track.move_to(place, at);
            return track;
        }
        let mut oldest = 0;
        for (index, slot) in self.slots.iter().enumerate() {
            let seen = |slot: &Option<Track>| slot.map_or(Instant::ZERO, |t| t.seen);
            if slot.is_none() || seen(slot) < seen(&self.slots[oldest]) {
                oldest = index;
            }
            if slot.is_none() {
                break;
            }
        }
        self.slots[oldest].insert(Track::new(place, at))
    }
}

#[cfg(test)]
#[path = "tracks_tests.rs"]
mod tests;
