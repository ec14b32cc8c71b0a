//! The part of the skin that the display shows: one rectangle for good, or one that goes where most happens.

use super::Projector;
use super::weave::Texture;
use crate::contact::Contact;
use crate::illusion::{Map, MapError, Rect};
use crate::units::Point;

/// A rectangle on a skin larger than the display that goes where most happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Width and height, mm.
    pub size: (f32, f32),
    /// A contact outside moves the window when it is stronger than all inside together by this share. 0: at once.
    pub hysteresis: f32,
}

/// Settings of a window that moves.
#[derive(Clone, Copy, Debug)]
struct Moving {
    window: Window,
    skin: Rect,
    display: Rect,
}

/// The part of the skin that is shown. Contacts outside it are not felt.
#[derive(Debug)]
pub struct View {
    map: Map,
    moving: Option<Moving>,
    /// `true` where nothing is shown.
    hidden: bool,
}

impl Projector {
    /// The sensor-to-display map, as it is now.
    pub const fn map(&self) -> &Map {
        self.view.map()
    }

    /// Number of newest contacts that may drive the display, and number of those on the part of the skin that it shows.
    pub fn found(&self) -> (usize, usize) {
        let found = Self::ours(&self.sensing, self.drives);
        let shown = found.clone().filter(|c| self.map().shows(c.place));
        (found.count(), shown.count())
    }

    /// Tells whether contacts are felt: the skin is shown, and no texture has the display to itself.
    pub fn renders_contacts(&self) -> bool {
        !self.view.hidden && !self.plays_texture_alone()
    }

    /// Tells whether a texture has the display to itself.
    pub fn plays_texture_alone(&self) -> bool {
        self.output.texture().is_some_and(Texture::is_alone)
    }

    /// Shows the skin on the display, or hides it: contacts of a skin that is hidden are found and reported, and not felt.
    pub const fn show(&mut self, shown: bool) {
        self.view.hidden = !shown;
    }
}

impl View {
    /// A view of one rectangle for good.
    pub const fn fixed(map: Map) -> Self {
        Self {
            map,
            moving: None,
            hidden: false,
        }
    }

    /// A window that goes where most happens on a `skin` (mm), shown on `display` (mm); in the middle, as long as
    /// nothing happens.
    ///
    /// # Errors
    /// [`MapError`] for a window that is larger than the skin, or cannot be mapped.
    pub fn following(window: Window, skin: Rect, display: Rect) -> Result<Self, MapError> {
        let moving = Moving {
            window,
            skin,
            display,
        };
        Ok(Self {
            map: moving.around(skin.centre())?,
            moving: Some(moving),
            hidden: false,
        })
    }

    /// Sensor to display, as it is now.
    pub(super) const fn map(&self) -> &Map {
        &self.map
    }

    /// Place of a contact on the display, mm; `None` for one that is not shown.
    pub(super) fn place(&self, contact: &Contact) -> Option<Point> {
        let shown = !self.hidden && self.map.shows(contact.place);
        shown.then(|| self.map.apply(contact.place))
    }

    /// Moves the window to where most happens in a frame; returns whether it moved.
    pub(super) fn frame<'a>(
        &mut self,
        contacts: impl Iterator<Item = &'a Contact> + Clone,
    ) -> bool {
        let Some(moving) = &self.moving else {
            return false;
        };
        let shown = |c: &&Contact| self.map.shows(c.place);
        let inside: f32 = contacts.clone().filter(shown).map(|c| c.intensity).sum();
        let outside = contacts.filter(|c| !shown(c));
        let strongest = outside.max_by(|a, b| a.intensity.total_cmp(&b.intensity));
        let stronger = |c: &&Contact| c.intensity > inside * (1.0 + moving.window.hysteresis);
        let moved = strongest
            .filter(stronger)
            .and_then(|c| moving.around(c.place).ok())
            .filter(|map| *map != self.map);
        if let Some(map) = moved {
            self.map = map;
        }
        moved.is_some()
    }
}

impl Moving {
    /// The window around a place, as far as the skin reaches.
    fn around(&self, place: Point) -> Result<Map, MapError> {
        let along = |at: f32, size: f32, low: f32, high: f32| {
            let from = (at - 0.5 * size).min(high - size).max(low);
            (from, from + size)
        };
        let (skin, (width, height)) = (self.skin, self.window.size);
        let (left, right) = along(place.x, width, skin.min.x, skin.max.x);
        let (bottom, top) = along(place.y, height, skin.min.y, skin.max.y);
        let window = Rect {
            min: Point::new(left, bottom),
            max: Point::new(right, top),
        };
        Map::new(self.skin, Some(window), self.display)
    }
}

#[cfg(test)]
#[path = "view_tests.rs"]
mod tests;
