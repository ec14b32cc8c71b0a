//! The per-frame stage: taxels in contact in, at most K_C contacts per scope out.
//!
//! N_C <= K_C passes through, K_C = 1 is a weighted mean, anything else is weighted K-means from the last frame's
//! centroids; k-means++ seeds only after contact was lost or the number of clusters grew. While the number of
//! clusters stays, a cluster's index is its identity; when it changes, and wherever taxels pass through,
//! [`super::identity`] matches. Allocates in [`Compressor::new`] only.

use alloc::format;
use alloc::vec::Vec;

use super::identity::{Matcher, born};
use super::interpolate::intensity;
use super::kmeans::{KMeans, Points, Stop, weighted_mean};
use super::levels::LevelSolver;
use super::settings::{Levels, Scope, Settings, SettingsError};
use super::weights;
use crate::random::Stream;
use crate::skin::layout::Layout;
use crate::skin::relative::{FrameError, RelativeFrame};
use crate::units::Point;

/// A contact: one place where the skin is touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Identity, from 1; the same as long as the contact lasts, never given twice.
    pub id: u32,
    /// Module, zero-based; with [`Scope::Skin`] that of the member taxel nearest to the place.
    pub module: u16,
    /// Where, mm: module coordinates, with [`Scope::Skin`] the skin's.
    pub place: Point,
    /// Magnitude of the relative frame there (4.9), raw counts; finite, never negative.
    pub intensity: f32,
    /// Intensity level, 1 ..= K_I; 1 without levels.
    pub level: u16,
    /// Taxels in the cluster.
    pub members: u16,
}

/// What the compressor did so far: its work, and what it could skip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Scopes without contact.
    pub untouched: u64,
    /// Scopes passed through (N_C <= K_C).
    pub passed: u64,
    /// Scopes solved by the weighted mean (K_C = 1).
    pub means: u64,
    /// K-means solves.
    pub solves: u64,
    /// Of these, seeded by k-means++.
    pub seeded: u64,
    /// Assignment passes of all solves.
    pub iterations: u64,
}

/// What is carried from frame to frame, per scope.
#[derive(Clone, Debug)]
struct Group {
    places: Vec<(f32, f32)>,
    ids: Vec<u32>,
    stream: Stream,
}

/// The compressor of one skin.
#[derive(Clone, Debug)]
pub struct Compressor {
    layout: Layout,
    settings: Settings,
    groups: Vec<Group>,
    next_id: u32,
    /// Taxel places in the coordinates of the scope.
    px: Vec<f32>,
    py: Vec<f32>,
    x: Vec<f32>,
    y: Vec<f32>,
    w: Vec<f32>,
    kmeans: KMeans,
    matcher: Matcher,
    old_places: Vec<(f32, f32)>,
    old_ids: Vec<u32>,
    solver: LevelSolver,
    intensities: Vec<f32>,
    closest: Vec<(f32, u32)>,
    contacts: Vec<Contact>,
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
        let per_module = modules.iter().map(|m| m.points().len());
        let (groups, most) = match settings.scope {
            Scope::Module => (modules.len(), per_module.max().unwrap_or(0)),
            Scope::Skin => (1, layout.taxels()),
        };
        let k = usize::from(settings.clusters).min(most);
        let group = |g: usize| Group {
            places: Vec::with_capacity(k),
            ids: Vec::with_capacity(k),
            stream: match settings.scope {
                Scope::Module => Stream::new(settings.seed, &format!("clusters of module {g}")),
                Scope::Skin => Stream::new(settings.seed, "clusters of the skin"),
            },
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
        let dynamic = match settings.levels {
            Levels::Dynamic(levels) => usize::from(levels).min(k),
            _ => 0,
        };
        Ok(Self {
            layout: layout.clone(),
            groups: (0..groups).map(group).collect(),
            next_id: 1,
            px,
            py,
            x: alloc::vec![0.0; most],
            y: alloc::vec![0.0; most],
            w: alloc::vec![0.0; most],
            kmeans: KMeans::new(most, k),
            matcher: Matcher::new(k),
            old_places: Vec::with_capacity(k),
            old_ids: Vec::with_capacity(k),
            solver: LevelSolver::new(if dynamic > 0 { k } else { 0 }, dynamic),
            intensities: Vec::with_capacity(k),
            closest: Vec::with_capacity(k),
            contacts: Vec::with_capacity(k * groups),
            work: Work::default(),
            settings,
        })
    }

    /// The contacts of a frame, scope after scope.
    ///
    /// # Errors
    /// A frame of another layout; the contacts are as before then.
    pub fn compress(&mut self, frame: &RelativeFrame) -> Result<&[Contact], FrameError> {
        if frame.starts() != self.layout.starts() {
            return Err(FrameError::OtherLayout {
                got: frame.magnitude().len(),
                expected: self.layout.taxels(),
            });
        }
        self.contacts.clear();
        for g in 0..self.groups.len() {
            let indices = match self.settings.scope {
                Scope::Module => frame.contacts_of(g),
                Scope::Skin => frame.contacts(),
            };
            if indices.is_empty() {
                self.groups[g].places.clear();
                self.groups[g].ids.clear();
                self.work.untouched += 1;
                continue;
            }
            let first = self.contacts.len();
            self.locate(g, frame, indices);
            self.quantise(first);
        }
        Ok(&self.contacts)
    }

    /// The first stage for one scope in contact.
    fn locate(&mut self, g: usize, frame: &RelativeFrame, indices: &[u32]) {
        let n = indices.len();
        let clusters = usize::from(self.settings.clusters);
        let group = &mut self.groups[g];
        self.old_places.clone_from(&group.places);
        self.old_ids.clone_from(&group.ids);
        group.places.clear();
        if n <= clusters {
            self.work.passed += 1;
            let places = indices
                .iter()
                .map(|&i| (self.px[i as usize], self.py[i as usize]));
            group.places.extend(places);
            self.name(g, true);
            for (slot, &i) in indices.iter().enumerate() {
                let value = frame.magnitude()[i as usize];
                self.emit(g, slot, self.module_of(g, i), value, 1);
            }
            return;
        }
        for ((x, y), &i) in self.x.iter_mut().zip(&mut self.y).zip(indices) {
            (*x, *y) = (self.px[i as usize], self.py[i as usize]);
        }
        let Settings { norm, exponent, .. } = self.settings;
        weights::fill(frame, indices, norm, exponent, &mut self.w[..n]);
        let points = Points {
            x: &self.x[..n],
            y: &self.y[..n],
            w: &self.w[..n],
        };
        if clusters == 1 {
            self.work.means += 1;
            group.places.push(weighted_mean(points));
        } else {
            self.work.solves += 1;
            if self.old_places.len() == clusters {
                self.kmeans.set_centroids(self.old_places.iter().copied());
            } else {
                self.work.seeded += 1;
                self.kmeans.seed(points, clusters, &mut group.stream);
            }
            let stop = Stop {
                tolerance: self.settings.tolerance,
                max_iterations: self.settings.max_iterations,
            };
            self.work.iterations += u64::from(self.kmeans.solve(points, stop).iterations);
            group.places.extend(self.kmeans.centroids());
        }
        self.name(g, false);
        self.find_closest(g, n);
        for slot in 0..self.groups[g].places.len() {
            let members = if clusters == 1 {
                n as u32
            } else {
                self.kmeans.members(slot)
            };
            let nearest = indices.get(self.closest[slot].1 as usize).copied();
            let m = self.module_of(g, nearest.unwrap_or(indices[0]));
            let module = &self.layout.modules()[m];
            let (x, y) = self.groups[g].places[slot];
            let local = match self.settings.scope {
                Scope::Module => Point::new(x, y),
                Scope::Skin => Point::new(x - module.origin().x, y - module.origin().y),
            };
            let range = frame.range(m);
            let (values, usable) = (&frame.magnitude()[range.clone()], &frame.usable()[range]);
            self.emit(
                g,
                slot,
                m,
                intensity(module, values, usable, local),
                members,
            );
        }
    }

    /// Identities of a scope's new places. `moved_freely`: their order says nothing about who they were.
    fn name(&mut self, g: usize, moved_freely: bool) {
        let group = &mut self.groups[g];
        let same = group.places == self.old_places;
        if same || (!moved_freely && group.places.len() == self.old_places.len()) {
            return;
        }
        if self.old_ids.is_empty() {
            group.ids.clear();
            group
                .ids
                .extend(group.places.iter().map(|_| born(&mut self.next_id)));
            return;
        }
        self.matcher.match_up(
            &self.old_places,
            &self.old_ids,
            &group.places,
            &mut group.ids,
            &mut self.next_id,
        );
    }

    /// The member nearest to every centroid, which tells the module of a cluster that spans several.
    fn find_closest(&mut self, g: usize, n: usize) {
        let places = &self.groups[g].places;
        self.closest.clear();
        self.closest.resize(places.len(), (f32::INFINITY, 0)); // within capacity
        if self.settings.scope == Scope::Module {
            return; // there is only one
        }
        for i in 0..n {
            let k = if places.len() == 1 {
                0
            } else {
                self.kmeans.assigned()[i] as usize
            };
            let (dx, dy) = (self.x[i] - places[k].0, self.y[i] - places[k].1);
            let d = dx * dx + dy * dy;
            if d < self.closest[k].0 {
                self.closest[k] = (d, i as u32);
            }
        }
    }

    fn module_of(&self, g: usize, index: u32) -> usize {
        match self.settings.scope {
            Scope::Module => g,
            Scope::Skin => self.layout.locate(index as usize).map_or(0, |at| at.0),
        }
    }

    fn emit(&mut self, g: usize, slot: usize, module: usize, intensity: f32, members: u32) {
        let group = &self.groups[g];
        let (x, y) = group.places[slot];
        self.contacts.push(Contact {
            id: group.ids[slot],
            module: module as u16, // at most 4096 modules
            place: Point::new(x, y),
            intensity,
            level: 1,
            members: members.min(u32::from(u16::MAX)) as u16,
        });
    }

    /// The second stage for the contacts of one scope, `first` and after.
    fn quantise(&mut self, first: usize) {
        let contacts = &mut self.contacts[first..];
        match &self.settings.levels {
            Levels::Off => {}
            Levels::Table(table) => {
                for c in contacts {
                    c.level = table.level(c.intensity);
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
        }
    }

    /// Forgets all contacts; identities go on.
    pub fn reset(&mut self) {
        for group in &mut self.groups {
            group.places.clear();
            group.ids.clear();
        }
        self.contacts.clear();
    }

    /// The contacts of the last frame.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }
    /// What was done and skipped so far.
    pub fn work(&self) -> Work {
        self.work
    }
    /// The settings it was made with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
}

#[cfg(test)]
#[path = "compressor_tests.rs"]
mod tests;
