//! The cells between wires: where a contact lies among them, and how it is shared out.
//!
//! Cells are the polygons of the Delaunay tessellation of the unrolled display: triangles, and where wires
//! lie on one circle (the rectangles of a grid) the whole polygon, so that no arbitrary diagonal breaks the
//! array's symmetry. Inside a cell the shares are Wachspress's (1975) rational coordinates: barycentric in
//! a triangle, bilinear in a rectangle, linear along edges, and their mean of the corners is the place itself.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use crate::units::Point;

use super::display::Display;
use super::geometry::{foot, left_of};

/// Shares below this count as none: half a tick of 100 is still fifty times more, even after a square root.
const NONE: f32 = 1e-5;
/// Wires this close to a circle are on it, as a part of its radius.
const ON_CIRCLE: f64 = 1e-4;

/// A corner of a cell: its wire, the edge to the next corner as a signed distance `n . p + c` over the
/// cell's radius, and the factor of the wire's share.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    wire: u16,
    // In f64: in a thin cell the rounding of f32 is as large as the heights, and neighbours of a touched wire get a share.
    edge: [f64; 3],
    factor: f64,
}

/// The tessellation of a display.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// Corners of all cells, anticlockwise, cell after cell.
    corners: Box<[Corner]>,
    /// Index of each cell's first corner; one entry more than there are cells.
    starts: Box<[u32]>,
    /// Wires in line, sorted along it: place along it and index. Empty for a display with an area.
    line: Box<[(f32, u16)]>,
    /// Direction of that line.
    direction: (f32, f32),
    places: Box<[Point]>,
    hull: Box<[Point]>,
}

impl Cells {
    /// The cells of a display; `None` for a single wire, which has nothing between it and another.
    pub fn new(display: &Display) -> Option<Self> {
        let places: Vec<Point> = display.wires().iter().map(|w| w.place).collect();
        if places.len() < 2 {
            return None;
        }
        let hull: Box<[Point]> = display.hull().into();
        let mut cells = Self {
            corners: Box::default(),
            starts: Box::default(),
            line: Box::default(),
            direction: (0.0, 0.0),
            places: places.into(),
            hull,
        };
        let polygons = tessellate(&cells.places);
        if polygons.is_empty() {
            cells.line_up();
        } else {
            cells.cut(&polygons);
        }
        Some(cells)
    }

    /// Tells whether the wires lie in one line, so that no cell has an area.
    pub(super) const fn in_line(&self) -> bool {
        !self.line.is_empty()
    }

    fn line_up(&mut self) {
        let first = self.places[0];
        let far = |p: &&Point| first.distance2(**p);
        let last = self.places.iter().max_by(|a, b| far(a).total_cmp(&far(b)));
        let last = last.copied().unwrap_or(first);
        let length = first.distance(last);
        let mut direction = ((last.x - first.x) / length, (last.y - first.y) / length);
        // One sense for a line, whatever the order of its wires.
        if direction.0 < 0.0 || (direction.0 <= 0.0 && direction.1 < 0.0) {
            direction = (-direction.0, -direction.1);
        }
        self.direction = direction;
        let along = self.places.iter().map(|p| self.along(*p));
        let mut line: Vec<(f32, u16)> = along.zip(0..).collect();
        line.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.line = line.into();
    }

    fn cut(&mut self, polygons: &[Vec<usize>]) {
        let (mut corners, mut starts) = (Vec::new(), vec![0]);
        for polygon in polygons {
            let n = polygon.len();
            let at = |i: usize| {
                let p = self.places[polygon[i % n]];
                (f64::from(p.x), f64::from(p.y))
            };
            let radius = (0..n).map(|i| apart(at(0), at(i))).fold(0.0, f64::max);
            for (i, &wire) in polygon.iter().enumerate() {
                let (before, here, after) = (at(i + n - 1), at(i), at(i + 1));
                let length = apart(here, after);
                let normal = (-(after.1 - here.1) / length, (after.0 - here.0) / length);
                let offset = -(normal.0 * here.0 + normal.1 * here.1);
                let factor = cross(before, here, after) / (apart(before, here) * length);
                corners.push(Corner {
                    wire: wire as u16, // a display has at most 256 wires
                    edge: [normal.0, normal.1, offset].map(|v| v / radius),
                    factor,
                });
            }
            starts.push(corners.len() as u32);
        }
        self.corners = corners.into();
        self.starts = starts.into();
    }

    /// Place of a wire, display mm.
    pub(super) fn place(&self, wire: usize) -> Point {
        self.places[wire]
    }

    fn cell(&self, index: usize) -> &[Corner] {
        &self.corners[self.starts[index] as usize..self.starts[index + 1] as usize]
    }

    /// The cell in which a place lies, or lies the least outside of.
    fn find(&self, at: Point) -> &[Corner] {
        let mut best = (f64::NEG_INFINITY, 0);
        for index in 0..self.starts.len() - 1 {
            let inner = self
                .cell(index)
                .iter()
                .map(|c| c.height(at))
                .fold(f64::INFINITY, f64::min);
            if inner >= 0.0 {
                return self.cell(index);
            }
            if inner > best.0 {
                best = (inner, index);
            }
        }
        self.cell(best.1)
    }

    /// The nearest place inside the array's hull, and how far away it is, mm.
    pub fn nearest(&self, at: Point) -> (Point, f32) {
        let n = self.hull.len();
        let inside = |i: usize| left_of(self.hull[i], self.hull[(i + 1) % n], at) >= 0.0;
        if n >= 3 && (0..n).all(inside) {
            return (at, 0.0);
        }
        let mut best = (at, f32::INFINITY);
        for i in 0..n {
            let foot = foot(self.hull[i], self.hull[(i + 1) % n], at);
            let distance = foot.distance(at);
            if distance < best.1 {
                best = (foot, distance);
            }
        }
        best
    }

    /// Writes every wire's share of a contact at `at` (display mm, inside the hull; others count as the
    /// nearest place inside). Shares lie in [0, 1] and sum to 1; at most those of one cell are not zero.
    pub fn shares(&self, at: Point, out: &mut [f32]) {
        out.fill(0.0);
        if self.in_line() {
            return self.shares_in_line(at, out);
        }
        let cell = self.find(at);
        let n = cell.len();
        let mut sum = 0.0;
        for (i, corner) in cell.iter().enumerate() {
            let mut share = corner.factor;
            for (j, other) in cell.iter().enumerate() {
                // The edges that do not end in this corner: j is the edge from corner j to the next.
                if j != i && (j + 1) % n != i {
                    share *= other.height(at).max(0.0);
                }
            }
            out[usize::from(corner.wire)] = share as f32;
            sum += share as f32;
        }
        let least = NONE * sum;
        let wires = || cell.iter().map(|c| usize::from(c.wire));
        let kept: f32 = wires().map(|w| out[w]).filter(|s| *s >= least).sum();
        for wire in wires() {
            out[wire] = if out[wire] >= least && kept > 0.0 {
                out[wire] / kept
            } else {
                0.0
            };
        }
    }

    /// Place along the line, and the neighbours there: where they are along it, and which they are.
    fn neighbours(&self, at: Point) -> (f32, [(f32, u16); 2]) {
        let along = self.along(at);
        let after = self.line.partition_point(|stop| stop.0 <= along);
        let right = after.clamp(1, self.line.len() - 1);
        (along, [self.line[right - 1], self.line[right]])
    }

    fn along(&self, p: Point) -> f32 {
        p.x * self.direction.0 + p.y * self.direction.1
    }

    fn shares_in_line(&self, at: Point, out: &mut [f32]) {
        let (along, [(x0, left), (x1, right)]) = self.neighbours(at);
        let b = ((along - x0) / (x1 - x0)).clamp(0.0, 1.0);
        let b = if b < NONE {
            0.0
        } else if b > 1.0 - NONE {
            1.0
        } else {
            b
        };
        out[usize::from(left)] = 1.0 - b;
        out[usize::from(right)] = b;
    }

    /// The wires at the corners of the cell around `at`, anticlockwise. In line: the two neighbours.
    pub(super) fn corners(&self, at: Point, each: &mut impl FnMut(usize)) {
        if self.in_line() {
            for (_, wire) in self.neighbours(at).1 {
                each(usize::from(wire));
            }
            return;
        }
        for corner in self.find(at) {
            each(usize::from(corner.wire));
        }
    }

    /// Parts (0 ..= 1) of the segment from `from` to `to` at which it passes from one cell into the next,
    /// sorted, each once.
    pub(super) fn crossings(&self, from: Point, to: Point) -> Vec<f32> {
        let mut parts = Vec::new();
        if self.in_line() {
            let (a, b) = (self.along(from), self.along(to));
            parts.extend(self.line.iter().map(|stop| (stop.0 - a) / (b - a)));
        } else {
            for index in 0..self.starts.len() - 1 {
                let cell = self.cell(index);
                for (i, corner) in cell.iter().enumerate() {
                    let (h0, h1) = (corner.height(from), corner.height(to));
                    let part = (h0 / (h0 - h1)) as f32;
                    let at = Point::new(
                        from.x + part * (to.x - from.x),
                        from.y + part * (to.y - from.y),
                    );
                    let a = self.places[usize::from(corner.wire)];
                    let b = self.places[usize::from(cell[(i + 1) % cell.len()].wire)];
                    if at.distance(foot(a, b, at)) < 1e-3 {
                        parts.push(part);
                    }
                }
            }
        }
        parts.retain(|p| (-1e-4..=1.0 + 1e-4).contains(p));
        parts.iter_mut().for_each(|p| *p = p.clamp(0.0, 1.0));
        parts.sort_unstable_by(f32::total_cmp);
        parts.dedup_by(|a, b| (*a - *b).abs() < 1e-4);
        parts
    }
}

impl Corner {
    fn height(&self, at: Point) -> f64 {
        self.edge[0] * f64::from(at.x) + self.edge[1] * f64::from(at.y) + self.edge[2]
    }
}

/// The polygons between places, anticlockwise; none where all lie in one line.
fn tessellate(places: &[Point]) -> Vec<Vec<usize>> {
    let at = |i: usize| (f64::from(places[i].x), f64::from(places[i].y));
    let points: Vec<delaunator::Point> = (0..places.len())
        .map(|i| delaunator::Point {
            x: at(i).0,
            y: at(i).1,
        })
        .collect();
    let found = delaunator::triangulate(&points);
    let triangles: Vec<[usize; 3]> = found
        .triangles
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .collect();
    // Neighbours with one circumcircle are one cell: each triangle ends up in the group of its first one.
    let mut group: Vec<usize> = (0..triangles.len()).collect();
    for (edge, &twin) in found.halfedges.iter().enumerate() {
        if twin == delaunator::EMPTY || twin < edge {
            continue;
        }
        let (one, other) = (edge / 3, twin / 3);
        let Some((centre, radius)) = circle(triangles[one].map(at)) else {
            continue;
        };
        let opposite = found.triangles[delaunator::prev_halfedge(twin)];
        if (apart(centre, at(opposite)) - radius).abs() < ON_CIRCLE * radius {
            let (from, to) = (group[other].max(group[one]), group[other].min(group[one]));
            group
                .iter_mut()
                .filter(|g| **g == from)
                .for_each(|g| *g = to);
        }
    }
    let mut polygons = Vec::new();
    for first in 0..triangles.len() {
        let members = (0..triangles.len()).filter(|&t| group[t] == first);
        let mut corners: Vec<usize> = members.flat_map(|t| triangles[t]).collect();
        corners.sort_unstable();
        corners.dedup();
        let Some((centre, _)) = circle(triangles[first].map(at)) else {
            continue;
        };
        if corners.is_empty() || group[first] != first {
            continue;
        }
        let angle = |&i: &usize| libm::atan2(at(i).1 - centre.1, at(i).0 - centre.0);
        corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        polygons.push(corners);
    }
    polygons
}

/// Centre and radius of the circle through three places; `None` for a sliver without area.
fn circle([a, b, c]: [(f64, f64); 3]) -> Option<((f64, f64), f64)> {
    let area2 = cross(a, b, c);
    let longest = apart(a, b).max(apart(b, c)).max(apart(c, a));
    if area2.abs() < 1e-6 * longest * longest {
        return None;
    }
    let (b, c) = ((b.0 - a.0, b.1 - a.1), (c.0 - a.0, c.1 - a.1));
    let (b2, c2) = (b.0 * b.0 + b.1 * b.1, c.0 * c.0 + c.1 * c.1);
    let x = (c.1 * b2 - b.1 * c2) / (2.0 * area2);
    let y = (b.0 * c2 - c.0 * b2) / (2.0 * area2);
    Some(((a.0 + x, a.1 + y), apart((x, y), (0.0, 0.0))))
}

fn cross(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> f64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

fn apart(a: (f64, f64), b: (f64, f64)) -> f64 {
    libm::hypot(a.0 - b.0, a.1 - b.1)
}

#[cfg(test)]
#[path = "cells_tests.rs"]
mod tests;
