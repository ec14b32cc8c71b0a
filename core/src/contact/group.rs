//! One scope of the compressor: a module, or the skin as a whole. The first stage, with all the memory it needs,
//! so that scopes can be worked on one after another or all at once.
//!
//! What a scope can leave out, each with the same result: everything, where no taxel is in contact or where its
//! taxels repeat and the last result was a fixed point; iteration, where N_C <= K_C or K_C = 1; passes over the
//! points, where the set of taxels in contact stays (see [`super::kmeans::KMeans::resume`]).

use alloc::format;
use alloc::vec::Vec;

use super::along::Along;
use super::found::{Contact, Work};
use super::interpolate::intensity;
use super::kmeans::{KMeans, Points, Stop, weighted_mean};
use super::settings::{Norm, Scope, Settings};
use super::weights;
use crate::random::RandomStream;
use crate::skin::layout::Layout;
use crate::skin::relative::RelativeFrame;
use crate::units::Point;

/// State that every scope reads and none changes.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    pub layout: Layout,
    pub settings: Settings,
    /// K_C now.
    pub clusters: usize,
    /// Taxel places in the coordinates of the scope, mm.
    pub px: Vec<f32>,
    pub py: Vec<f32>,
}

impl Shared {
    /// The taxels of a scope in contact.
    fn indices<'a>(&self, scope: usize, frame: &'a RelativeFrame) -> &'a [u32] {
        match self.settings.scope {
            Scope::Module => frame.contacts_of(scope),
            Scope::Skin => frame.contacts(),
        }
    }

    fn module_of(&self, scope: usize, taxel: u32) -> usize {
        match self.settings.scope {
            Scope::Module => scope,
            Scope::Skin => self.layout.locate(taxel as usize).map_or(0, |at| at.0),
        }
    }
}

/// Origin of a frame's contacts, which decides how they are named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// No taxel in contact.
    Untouched,
    /// The frame before once more.
    Repeated,
    /// Taxels passed through; their order says nothing about who they were.
    Passed,
    /// Clusters: a cluster's index is its identity as long as their number stays.
    Clustered,
}

/// The values of a scope's taxels in the last frame.
#[derive(Clone, Debug, Default)]
struct Memory {
    indices: Vec<u32>,
    usable: Vec<bool>,
    /// Magnitudes; with a norm other than l2, and with vectors, the axes too.
    values: [Vec<f32>; 4],
}

/// The intensity at a place of a module, in its coordinates, and its parts along the axes (4.9).
#[inline(always)] // in every frame: vectors are the rare case, and out of its way
fn between(shared: &Shared, frame: &RelativeFrame, m: usize, place: Point) -> (f32, [f32; 3]) {
    if shared.settings.vectors {
        return vector_between(shared, frame, m, place);
    }
    let (module, range) = (&shared.layout.modules()[m], frame.range(m));
    let (values, usable) = (&frame.magnitude()[range.clone()], &frame.usable()[range]);
    (intensity(module, values, usable, place), [0.0; 3])
}

#[inline(never)]
fn vector_between(
    shared: &Shared,
    frame: &RelativeFrame,
    m: usize,
    place: Point,
) -> (f32, [f32; 3]) {
    let (module, range) = (&shared.layout.modules()[m], frame.range(m));
    let usable = &frame.usable()[range.clone()];
    let along = |axis| intensity(module, &frame.axis(axis)[range.clone()], usable, place);
    let vector @ [x, y, z] = core::array::from_fn(along);
    (libm::sqrtf(x * x + y * y + z * z), vector)
}

/// Returns true where contacts follow from the axes, and not from magnitudes alone.
fn reads_axes(settings: &Settings) -> bool {
    settings.norm != Norm::L2 || settings.vectors
}

/// Makes `kept` the same as `now` and says whether it was.
fn keep<T: Copy + PartialEq>(kept: &mut Vec<T>, now: &[T]) -> bool {
    let same = kept == now;
    if !same {
        kept.clear();
        kept.extend_from_slice(now); // within capacity
    }
    same
}

/// A scope: its contacts and what is carried from frame to frame.
#[derive(Clone, Debug)]
pub struct Group {
    scope: usize,
    pub(super) step: Step,
    pub(super) places: Vec<(f32, f32)>,
    pub(super) ids: Vec<u32>,
    pub(super) old_places: Vec<(f32, f32)>,
    pub(super) old_ids: Vec<u32>,
    pub(super) contacts: Vec<Contact>,
    /// `true` where the same frame would give the same contacts.
    pub(super) settled: bool,
    pub(super) work: Work,
    memory: Memory,
    /// `true` where the places are the K-means solver's centroids.
    clustered: bool,
    stream: RandomStream,
    x: Vec<f32>,
    y: Vec<f32>,
    w: Vec<f32>,
    kmeans: KMeans,
    /// Places on a skin whose modules join.
    pub(super) along: Option<Along>,
    closest: Vec<(f32, u32)>,
}

impl Group {
    /// Room for all taxels of a scope. Distances go along the skin where its modules are `joined`.
    pub(super) fn new(scope: usize, taxels: usize, settings: &Settings, joined: bool) -> Self {
        let k = usize::from(settings.most_clusters()).min(taxels);
        let values = |wanted: bool| Vec::with_capacity(if wanted { taxels } else { 0 });
        let axes = reads_axes(settings);
        let solves = k > 1 && usize::from(settings.clusters) < taxels && !joined;
        Self {
            scope,
            step: Step::Untouched,
            places: Vec::with_capacity(k),
            ids: Vec::with_capacity(k),
            old_places: Vec::with_capacity(k),
            old_ids: Vec::with_capacity(k),
            contacts: Vec::with_capacity(k),
            settled: true,
            work: Work::default(),
            memory: Memory {
                indices: Vec::with_capacity(taxels),
                usable: Vec::with_capacity(taxels),
                values: [values(true), values(axes), values(axes), values(axes)],
            },
            clustered: false,
            stream: match settings.scope {
                Scope::Module => {
                    RandomStream::new(settings.seed, &format!("clusters of module {scope}"))
                }
                Scope::Skin => RandomStream::new(settings.seed, "clusters of the skin"),
            },
            x: alloc::vec![0.0; taxels],
            y: alloc::vec![0.0; taxels],
            w: alloc::vec![0.0; taxels],
            kmeans: KMeans::new(if solves { taxels } else { 0 }, k),
            along: joined.then(|| Along::new(taxels, k)),
            closest: Vec::with_capacity(k),
        }
    }

    /// Compares the scope with its last frame: whether the same taxels are in contact, and whether all is the same.
    fn compare(&mut self, shared: &Shared, frame: &RelativeFrame, indices: &[u32]) -> (bool, bool) {
        let range = match shared.settings.scope {
            Scope::Module => frame.range(self.scope),
            Scope::Skin => 0..frame.magnitude().len(),
        };
        let memory = &mut self.memory;
        let set = keep(&mut memory.indices, indices);
        let [magnitude, axes @ ..] = &mut memory.values;
        // All values are kept, even where the first comparison has decided already.
        let mut same = keep(magnitude, &frame.magnitude()[range.clone()]);
        same &= keep(&mut memory.usable, &frame.usable()[range.clone()]);
        if reads_axes(&shared.settings) {
            for (axis, kept) in axes.iter_mut().enumerate() {
                same &= keep(kept, &frame.axis(axis)[range.clone()]);
            }
        }
        (set, same && set)
    }

    /// Finds the scope's contacts in a frame. Identities and levels are given afterwards, over all scopes.
    pub(super) fn locate(&mut self, shared: &Shared, frame: &RelativeFrame) {
        let indices = shared.indices(self.scope, frame);
        if indices.is_empty() {
            self.forget();
            self.work.untouched += 1;
            return;
        }
        let (same_set, same) = self.compare(shared, frame, indices);
        if same && self.settled && !self.places.is_empty() {
            self.step = Step::Repeated;
            self.work.repeated += 1;
            return;
        }
        self.old_places.clone_from(&self.places);
        self.old_ids.clone_from(&self.ids);
        self.places.clear();
        self.contacts.clear();
        if let Some(along) = &mut self.along {
            along.begin();
            along.load(&shared.layout, indices);
        }
        if indices.len() <= shared.clusters {
            self.pass(shared, frame, indices);
        } else if self.along.is_some() {
            self.cluster_along(shared, frame, indices);
        } else {
            self.cluster(shared, frame, indices, same_set);
        }
    }

    /// The long way from here: nothing of the last frame counts as known but where its contacts were.
    #[cfg(test)]
    pub(super) fn distrust(&mut self) {
        self.memory = Memory::default();
        self.settled = false;
    }

    /// Looks for another number of clusters from now on: the last result is no fixed point of that.
    pub(super) fn unsettle(&mut self) {
        (self.settled, self.clustered) = (false, false);
    }

    /// Forgets its contacts.
    pub(super) fn forget(&mut self) {
        self.step = Step::Untouched;
        self.places.clear();
        self.ids.clear();
        self.contacts.clear();
        (self.settled, self.clustered) = (true, false);
    }

    /// N_C <= K_C: every taxel in contact is a contact.
    fn pass(&mut self, shared: &Shared, frame: &RelativeFrame, indices: &[u32]) {
        self.step = Step::Passed;
        self.work.passed += 1;
        (self.settled, self.clustered) = (true, false);
        if let Some(along) = &mut self.along {
            along.pass();
        }
        for &i in indices {
            let at = i as usize;
            let place = (shared.px[at], shared.py[at]);
            self.places.push(place);
            let vector = match shared.settings.vectors {
                true => core::array::from_fn(|axis| frame.axis(axis)[at]),
                false => [0.0; 3],
            };
            let module = shared.module_of(self.scope, i);
            self.emit(module, place, (frame.magnitude()[at], vector), 1);
        }
    }

    /// More taxels than contacts: the weighted mean, or K-means.
    fn cluster(&mut self, shared: &Shared, frame: &RelativeFrame, indices: &[u32], same_set: bool) {
        self.step = Step::Clustered;
        let n = indices.len();
        if !(same_set && self.clustered) {
            for ((x, y), &i) in self.x.iter_mut().zip(&mut self.y).zip(indices) {
                (*x, *y) = (shared.px[i as usize], shared.py[i as usize]);
            }
        }
        let Settings { norm, exponent, .. } = shared.settings;
        weights::fill(frame, indices, norm, exponent, &mut self.w[..n]);
        let points = Points {
            x: &self.x[..n],
            y: &self.y[..n],
            w: &self.w[..n],
        };
        let clusters = shared.clusters;
        if clusters == 1 {
            self.work.means += 1;
            self.places.push(weighted_mean(points));
            self.settled = true;
        } else {
            self.work.solves += 1;
            let stop = Stop {
                tolerance: shared.settings.tolerance,
                max_iterations: shared.settings.max_iterations,
            };
            let outcome = if self.clustered && same_set {
                self.kmeans.resume(points, stop)
            } else {
                if self.old_places.len() != clusters {
                    self.work.seeded += 1;
                    self.kmeans.seed(points, clusters, &mut self.stream);
                } else if !self.clustered {
                    self.kmeans.set_centroids(self.old_places.iter().copied());
                }
                self.kmeans.solve(points, stop)
            };
            self.work.iterations += u64::from(outcome.iterations);
            self.work.passes += u64::from(outcome.passes);
            self.settled = outcome.settled;
            self.places.extend(self.kmeans.centroids());
        }
        self.clustered = true;
        self.find_closest(shared, n);
        for slot in 0..self.places.len() {
            let members = if clusters == 1 {
                n as u32 // at most 2^22 taxels
            } else {
                self.kmeans.members(slot)
            };
            let nearest = indices.get(self.closest[slot].1 as usize).copied();
            let m = shared.module_of(self.scope, nearest.unwrap_or(indices[0]));
            let module = &shared.layout.modules()[m];
            let (x, y) = self.places[slot];
            let local = match shared.settings.scope {
                Scope::Module => Point::new(x, y),
                Scope::Skin => Point::new(x - module.origin().x, y - module.origin().y),
            };
            self.emit(m, (x, y), between(shared, frame, m, local), members);
        }
    }

    /// More taxels than contacts, on a skin whose modules join: K-means along the skin.
    #[inline(never)]
    fn cluster_along(&mut self, shared: &Shared, frame: &RelativeFrame, indices: &[u32]) {
        let Some(mut along) = self.along.take() else {
            return;
        };
        let layout = &shared.layout;
        let Settings { norm, exponent, .. } = shared.settings;
        let weights = &mut self.w[..indices.len()];
        weights::fill(frame, indices, norm, exponent, weights);
        if self.old_places.len() != shared.clusters {
            self.work.seeded += 1;
            along.seed(layout, weights, shared.clusters, &mut self.stream);
        }
        let stop = Stop {
            tolerance: shared.settings.tolerance,
            max_iterations: shared.settings.max_iterations,
        };
        let iterations = along.solve(layout, weights, stop);
        self.step = Step::Clustered;
        self.work.solves += 1;
        self.work.iterations += u64::from(iterations);
        self.work.passes += u64::from(iterations);
        // Places are means of ways, which a further pass moves by rounding: no fixed point to rely on.
        (self.settled, self.clustered) = (false, true);
        for ((m, local), members) in along.found() {
            let origin = layout.modules()[m].origin();
            let place = (origin.x + local.x, origin.y + local.y);
            self.places.push(place);
            self.emit(m, place, between(shared, frame, m, local), members);
        }
        self.along = Some(along);
    }

    /// The member nearest to every centroid, which tells the module of a cluster that spans several.
    fn find_closest(&mut self, shared: &Shared, n: usize) {
        self.closest.clear();
        self.closest.resize(self.places.len(), (f32::INFINITY, 0)); // within capacity
        if shared.settings.scope == Scope::Module || shared.layout.modules().len() == 1 {
            return; // there is only one
        }
        for i in 0..n {
            let k = if self.places.len() == 1 {
                0
            } else {
                self.kmeans.assigned()[i] as usize
            };
            let (dx, dy) = (self.x[i] - self.places[k].0, self.y[i] - self.places[k].1);
            let d = dx * dx + dy * dy;
            if d < self.closest[k].0 {
                self.closest[k] = (d, i as u32);
            }
        }
    }

    /// A contact, still without identity and level.
    fn emit(
        &mut self,
        module: usize,
        (x, y): (f32, f32),
        (intensity, vector): (f32, [f32; 3]),
        members: u32,
    ) {
        self.contacts.push(Contact {
            id: 0,
            module: module as u16, // at most 4096 modules
            place: Point::new(x, y),
            intensity,
            vector,
            level: 1,
            members,
        });
    }
}
