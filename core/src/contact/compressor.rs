//! The per-frame stage: taxels in contact in, at most K_C contacts per scope out.
//!
//! N_C <= K_C passes through, K_C = 1 is a weighted mean, anything else is weighted K-means from the last frame's
//! centroids; k-means++ seeds only after contact was lost or the number of clusters grew. While the number of
//! clusters stays, a cluster's index is its identity; when it changes, and wherever taxels pass through,
//! [`super::identity`] matches. Scopes are found one by one, or in parallel ([`Compressor::compress_with`]);
//! names and levels follow in their order, so the contacts are the same. Allocates in [`Compressor::new`] only.

use alloc::vec::Vec;

use super::found::{Contact, Work};
use super::group::{Group, Shared, Step};
use super::identity::{Matcher, born};
use super::levels::LevelSolver;
use super::passes::square;
use super::settings::{Levels, Scope, Settings, SettingsError};
use super::vectors::VectorSolver;
use crate::skin::layout::Layout;
use crate::skin::relative::{FrameError, RelativeFrame};
use crate::units::Point;

/// The compressor of one skin.
#[derive(Clone, Debug)]
pub struct Compressor {
    shared: Shared,
    groups: Vec<Group>,
    next_id: u32,
    matcher: Matcher,
    solver: LevelSolver,
    intensities: Vec<f32>,
    vector_solver: VectorSolver,
    vectors: Vec<[f32; 3]>,
    contacts: Vec<Contact>,
    /// `true` where every group would find the same contacts again in the same frame.
    settled: bool,
    /// `true` where the last frame had no taxel in contact.
    resting: bool,
    work: Work,
}

impl Compressor {
    /// Makes room for everything a frame of `layout` can need.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(layout: &Layout, settings: Settings) -> Result<Self, SettingsError> {
        settings.check()?;
        let modules = layout.modules();
        let groups: Vec<Group> = match settings.scope {
            Scope::Module => modules
                .iter()
                .enumerate()
                .map(|(m, module)| Group::new(m, module.points().len(), &settings, false))
                .collect(),
            Scope::Skin => {
                let is_joined = !layout.seams().is_empty();
                alloc::vec![Group::new(0, layout.taxels(), &settings, is_joined)]
            }
        };
        let (mut px, mut py) = (Vec::new(), Vec::new());
        for module in modules {
            let origin = match settings.scope {
                Scope::Module => Point::default(),
                Scope::Skin => module.origin(),
            };
            px.extend(module.points().iter().map(|p| p.x + origin.x));
            py.extend(module.points().iter().map(|p| p.y + origin.y));
        }
        let rooms = || groups.iter().map(|g| g.places.capacity());
        let (k, all) = (rooms().max().unwrap_or(0), rooms().sum());
        let dynamic = match settings.levels {
            Levels::Dynamic(levels) => usize::from(levels).min(k),
            _ => 0,
        };
        let (on_line, in_space) = match (dynamic, settings.vectors) {
            (0, _) => (0, 0),
            (_, false) => (k, 0),
            (_, true) => (0, k),
        };
        Ok(Self {
            next_id: 1,
            matcher: Matcher::new(k),
            solver: LevelSolver::new(on_line, dynamic),
            intensities: Vec::with_capacity(on_line),
            vector_solver: VectorSolver::new(in_space, dynamic),
            vectors: Vec::with_capacity(in_space),
            contacts: Vec::with_capacity(all),
            settled: groups.iter().all(|g| g.settled),
            resting: true,
            work: Work::default(),
            groups,
            shared: Shared {
                clusters: settings.clusters.into(),
                layout: layout.clone(),
                settings,
                px,
                py,
            },
        })
    }

    /// Compresses a frame into contacts, scope after scope.
    ///
    /// # Errors
    /// [`FrameError`] for a frame of another layout; the contacts are as before then.
    pub fn compress(&mut self, frame: &RelativeFrame) -> Result<&[Contact], FrameError> {
        self.compress_with(frame, |groups, locate| groups.iter_mut().for_each(locate))
    }

    /// Compresses a frame with the same result as [`Compressor::compress`], to the
    /// bit, on the threads of `spread`. It calls the function that it gets once for
    /// every group, in any order. A skin that stays untouched needs no call of it.
    ///
    /// # Errors
    /// The errors of [`Compressor::compress`].
    pub fn compress_with(
        &mut self,
        frame: &RelativeFrame,
        spread: impl FnOnce(&mut [Group], &(dyn Fn(&mut Group) + Sync)),
    ) -> Result<&[Contact], FrameError> {
        if frame.starts() != self.shared.layout.starts() {
            return Err(FrameError::OtherLayout {
                got: frame.magnitude().len(),
                expected: self.shared.layout.taxels(),
            });
        }
        self.work.frames += 1;
        if self.resting && frame.contacts().is_empty() {
            // Skin that is not touched stays so, most of the time.
            self.work.untouched += self.groups.len() as u64;
            return Ok(&self.contacts);
        }
        let shared = &self.shared;
        spread(&mut self.groups, &|group| group.locate(shared, frame));
        self.settled = self.groups.iter().all(|g| g.settled);
        self.resting = frame.contacts().is_empty();
        self.contacts.clear();
        for g in 0..self.groups.len() {
            match self.groups[g].step {
                Step::Untouched => continue,
                Step::Repeated => {}
                step => {
                    self.name(g, step == Step::Passed);
                    self.quantise(g);
                }
            }
            self.contacts.extend_from_slice(&self.groups[g].contacts); // within capacity
        }
        Ok(&self.contacts)
    }

    /// Says that the frame compressed last has come again. Where that would give the same contacts once more, it
    /// is counted and `true`; else, because iteration stopped short of a fixed point, it has to be compressed.
    pub fn repeat(&mut self) -> bool {
        self.work.repeats += u64::from(self.settled);
        self.settled
    }

    /// Gives identities to a scope's new places. With `moved_freely` their order says nothing about who they were.
    fn name(&mut self, g: usize, moved_freely: bool) {
        let group = &mut self.groups[g];
        let count_stays = group.places.len() == group.old_places.len();
        if group.places != group.old_places && (moved_freely || !count_stays) {
            if group.old_ids.is_empty() {
                group.ids.clear();
                let births = group.places.iter().map(|_| born(&mut self.next_id));
                group.ids.extend(births);
            } else {
                let (ids, count) = (&mut group.ids, group.places.len());
                let (old, new, along) = (&group.old_places, &group.places, group.along.as_ref());
                let distance2 = |o: usize, n: usize| match along {
                    Some(along) => along.moved2(&self.shared.layout, o, n),
                    None => square(new[n].0, new[n].1, old[o].0, old[o].1),
                };
                self.matcher
                    .match_up(&group.old_ids, count, &distance2, ids, &mut self.next_id);
            }
        }
        for (contact, id) in group.contacts.iter_mut().zip(&group.ids) {
            contact.id = *id;
        }
    }

    /// The second stage for the contacts of one scope.
    fn quantise(&mut self, g: usize) {
        let contacts = &mut self.groups[g].contacts;
        match &self.shared.settings.levels {
            Levels::Dynamic(_) if self.shared.settings.vectors => {
                self.vectors.clear();
                self.vectors.extend(contacts.iter().map(|c| c.vector));
                if self.vector_solver.solve(&self.vectors).is_ok() {
                    for c in contacts {
                        c.level = self.vector_solver.level(c.vector);
                    }
                }
            }
            Levels::Dynamic(_) => {
                self.intensities.clear();
                self.intensities
                    .extend(contacts.iter().map(|c| c.intensity));
                if self.solver.solve(&self.intensities).is_ok() {
                    for c in contacts {
                        c.level = self.solver.level(c.intensity);
                    }
                }
            }
            table => contacts.iter_mut().for_each(|c| c.level = table.level(c)),
        }
    }

    /// Finds so many contacts per scope from the next frame on, within [`Settings::clusters`] and [`Settings::growth`].
    pub fn allow(&mut self, clusters: usize) {
        let settings = &self.shared.settings;
        let (least, most) = (settings.clusters, settings.most_clusters());
        let clusters = clusters.clamp(least.into(), most.into());
        if clusters != self.shared.clusters {
            self.shared.clusters = clusters;
            self.settled = false;
            self.groups.iter_mut().for_each(Group::unsettle);
        }
    }

    /// Forgets all contacts; identities go on.
    pub fn reset(&mut self) {
        self.groups.iter_mut().for_each(Group::forget);
        self.settled = self.groups.iter().all(|g| g.settled);
        self.contacts.clear();
    }

    /// The most contacts of a frame.
    #[cfg(target_has_atomic = "ptr")]
    pub(crate) fn room(&self) -> usize {
        self.groups.iter().map(|g| g.places.capacity()).sum()
    }

    /// Takes contacts that another compressor found in place of a frame, [`Self::room`] at most.
    #[cfg(target_has_atomic = "ptr")]
    pub(crate) fn hold(&mut self, contacts: &[Contact]) {
        self.contacts.clear();
        let most = contacts.len().min(self.room());
        self.contacts.extend_from_slice(&contacts[..most]);
    }

    /// The contacts of the last frame.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }
    /// Work that was done and left out so far.
    pub fn work(&self) -> Work {
        let mut work = self.work;
        self.groups.iter().for_each(|g| work.add(&g.work));
        work
    }
    /// The settings it was made with.
    pub fn settings(&self) -> &Settings {
        &self.shared.settings
    }
}

#[cfg(test)]
#[path = "compressor_tests.rs"]
mod tests;
