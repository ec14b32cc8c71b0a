//! K-means along a skin whose modules join at seams: (4.4) to (4.8) with distances over the skin in place of the plane.
//!
//! A mean on a folded skin is where the weighted ways to all members cancel. Each update lays the members out around the
//! centroid, each in the direction of its shortest way and as far, and moves the centroid to their mean, across seams
//! where it must. On a single module that is (4.7).

use alloc::vec::Vec;

use super::kmeans::Stop;
use crate::random::RandomStream;
use crate::skin::layout::Layout;
use crate::units::Point;

/// A place on a module, in its coordinates.
pub(super) type Spot = (usize, Point);

/// Taxels of a scope and their centroids, with memory made beforehand.
#[derive(Clone, Debug)]
pub(super) struct Along {
    taxels: Vec<Spot>,
    nearest: Vec<f32>,
    centroids: Vec<Spot>,
    /// Places of the frame before.
    old: Vec<Spot>,
    /// Sums of each cluster: weight, and weighted ways from its centroid.
    sums: Vec<[f64; 3]>,
    members: Vec<u32>,
}

/// The way from one place to another: along the skin, and in the plane between modules that no seams join.
fn step(layout: &Layout, from: Spot, to: Spot) -> (f32, f32) {
    let on_plane = |(module, place): Spot| {
        let origin = layout.modules()[module].origin();
        (origin.x + place.x, origin.y + place.y)
    };
    layout.seams().step(from, to).unwrap_or_else(|| {
        let ((ax, ay), (bx, by)) = (on_plane(from), on_plane(to));
        (bx - ax, by - ay)
    })
}

/// Squared length of [`step`], mm².
fn distance2(layout: &Layout, from: Spot, to: Spot) -> f32 {
    let (x, y) = step(layout, from, to);
    x * x + y * y
}

impl Along {
    /// Room for `taxels` and `k` centroids.
    pub fn new(taxels: usize, k: usize) -> Self {
        Self {
            taxels: Vec::with_capacity(taxels),
            nearest: Vec::with_capacity(taxels),
            centroids: Vec::with_capacity(k),
            old: Vec::with_capacity(k),
            sums: Vec::with_capacity(k),
            members: Vec::with_capacity(k),
        }
    }

    /// Lets the next frame begin.
    pub fn begin(&mut self) {
        self.old.clone_from(&self.centroids); // within capacity
    }

    /// Squared distance from a place of the frame before to one of this frame, mm².
    pub fn moved2(&self, layout: &Layout, old: usize, new: usize) -> f32 {
        distance2(layout, self.old[old], self.centroids[new])
    }

    /// Takes the taxels themselves as places.
    pub fn pass(&mut self) {
        self.centroids.clone_from(&self.taxels); // no more than K_C
    }

    /// Places, and the taxels of each.
    pub fn found(&self) -> impl Iterator<Item = (Spot, u32)> {
        self.centroids
            .iter()
            .copied()
            .zip(self.members.iter().copied())
    }

    /// Takes the taxels that are to be clustered.
    pub fn load(&mut self, layout: &Layout, indices: &[u32]) {
        let spot = |&i: &u32| {
            let (module, taxel) = layout.locate(i as usize)?;
            Some((module, layout.modules()[module].points()[taxel]))
        };
        self.taxels.clear();
        self.taxels.extend(indices.iter().filter_map(spot)); // within capacity
    }

    /// K-means++: the first seed by weight, each further one by weight and squared distance to the nearest before.
    pub fn seed(&mut self, layout: &Layout, weights: &[f32], k: usize, stream: &mut RandomStream) {
        self.centroids.clear();
        self.nearest.clear();
        self.nearest.resize(self.taxels.len(), 1.0); // within capacity
        while self.centroids.len() < k {
            let mass = |(w, near): (&f32, &f32)| f64::from(*w) * f64::from(*near);
            let mut left =
                stream.uniform() * weights.iter().zip(&self.nearest).map(mass).sum::<f64>();
            let mut drawn = 0;
            for (i, pair) in weights.iter().zip(&self.nearest).enumerate() {
                let mass = mass(pair);
                if mass > 0.0 {
                    drawn = i;
                    if left < mass {
                        break;
                    }
                    left -= mass;
                }
            }
            let seed = self.taxels[drawn];
            let is_first = self.centroids.is_empty();
            for (near, taxel) in self.nearest.iter_mut().zip(&self.taxels) {
                let d = distance2(layout, seed, *taxel);
                *near = if is_first { d } else { near.min(d) };
            }
            self.centroids.push(seed);
        }
    }

    /// Alternates assignments (4.6) and updates (4.7) until (4.8) holds; returns the iterations.
    pub fn solve(&mut self, layout: &Layout, weights: &[f32], stop: Stop) -> u32 {
        for iteration in 1..=stop.max_iterations {
            self.sums.clear();
            self.sums.resize(self.centroids.len(), [0.0; 3]); // within capacity
            self.members.clear();
            self.members.resize(self.centroids.len(), 0); // within capacity
            for (taxel, w) in self.taxels.iter().zip(weights) {
                let mut best = (f32::INFINITY, 0, (0.0, 0.0));
                for (c, centroid) in self.centroids.iter().enumerate() {
                    let (x, y) = step(layout, *centroid, *taxel);
                    let d = x * x + y * y;
                    if d < best.0 {
                        best = (d, c, (x, y));
                    }
                }
                let (_, c, (x, y)) = best;
                let w = f64::from(*w);
                let parts = [w, w * f64::from(x), w * f64::from(y)];
                for (sum, part) in self.sums[c].iter_mut().zip(parts) {
                    *sum += part;
                }
                self.members[c] += 1;
            }
            let mut moved = 0.0;
            for ((module, place), [w, x, y]) in self.centroids.iter_mut().zip(&self.sums) {
                // A cluster that lost every taxel stays where it is.
                if *w > 0.0 {
                    let (x, y) = ((x / w) as f32, (y / w) as f32);
                    let to = Point::new(place.x + x, place.y + y);
                    (*module, *place) = layout.seams().walk(*module, *place, to);
                    moved += 0.5 * libm::sqrtf(x * x + y * y);
                }
            }
            if moved <= stop.tolerance {
                return iteration;
            }
        }
        stop.max_iterations
    }
}

#[cfg(test)]
#[path = "along_tests.rs"]
mod tests;
