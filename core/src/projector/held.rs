//! Contacts that another loop found: a robot's machine compresses its skin, and this one has only the display.

use super::{Observer, Projector};
use crate::contact::Contact;
use crate::units::{Duration, Instant};

/// Reasons for which contacts cannot belong to this loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ForeignContacts {
    /// More contacts than compression can find here, with that number.
    #[error("expected at most {0} contacts")]
    TooMany(usize),
    /// A contact of a module that the layout lacks, with the number of modules that it has.
    #[error("expected a module below {0}")]
    NoSuchModule(usize),
    /// A contact whose place or intensity is not a number, or whose intensity is negative.
    #[error("expected places and intensities that are numbers")]
    NoNumber,
    /// A contact of a level outside 1 to this.
    #[error("expected a level from 1 to {0}")]
    Level(u16),
    /// Contacts not newer than the newest ones.
    #[error("expected contacts newer than the newest")]
    Old,
}

impl Projector {
    /// Takes the contacts of a frame of this skin that another loop compressed, in place of scans: all that there are
    /// as of `at`, in module coordinates, with their identities. [`Self::turn`] then does what they make due. The guard
    /// counts the age of its input from `at`, the earliest time at which the contacts may have been there. Places are
    /// extrapolated from `at` + `later`, when the contacts likely were there; staleness ignores `later`. From the first
    /// call on taxels are not looked at: their health is the other loop's.
    ///
    /// # Errors
    /// Contacts that are not of the loop's layout and levels, or not newer; nothing has changed then.
    pub fn hold(
        &mut self,
        at: Instant,
        later: Duration,
        contacts: &[Contact],
        observer: &mut impl Observer,
    ) -> Result<(), ForeignContacts> {
        let most = self.sensing.compressor().room();
        let modules = self.layout.modules().len();
        let top = self.sensing.compressor().settings().levels.count();
        let is_number = |c: &Contact| {
            c.place.x.is_finite()
                && c.place.y.is_finite()
                && c.intensity.is_finite()
                && c.intensity >= 0.0
        };
        if contacts.len() > most {
            return Err(ForeignContacts::TooMany(most));
        }
        for contact in contacts {
            if usize::from(contact.module) >= modules {
                return Err(ForeignContacts::NoSuchModule(modules));
            }
            if !is_number(contact) {
                return Err(ForeignContacts::NoNumber);
            }
            if !(1..=top).contains(&contact.level) {
                return Err(ForeignContacts::Level(top));
            }
        }
        if self
            .sensing
            .newest_frame()
            .is_some_and(|newest| newest >= at)
        {
            return Err(ForeignContacts::Old);
        }
        self.later = later;
        self.sensing.hold(at, contacts, observer);
        Ok(())
    }
}

#[cfg(test)]
#[path = "held_tests.rs"]
mod tests;
