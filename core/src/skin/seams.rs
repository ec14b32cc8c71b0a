//! Seams: edges at which modules join, and the ways along the skin from module to module.
//!
//! A fold bends the skin and stretches nothing: unfolded around a seam, the next module lies in the plane of the one
//! before, and the shortest way through a row of seams is a line that bends at their ends only. So distances need no
//! angle of a fold, nor the places at which a drawing has the modules.

use alloc::vec::Vec;

use super::layout_error::LayoutError;
use crate::units::Point;

/// An edge that two modules share, folded or flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// Both modules.
    pub modules: [usize; 2],
    /// Ends of the edge in the coordinates of each module, mm, in one order.
    pub edges: [[Point; 2]; 2],
}

/// Most ways from module to module: a hand's fingers need a few hundred.
const MOST_WAYS: usize = 1 << 14;
/// Most seams of a way.
const MOST_STEPS: usize = 16;
/// Largest difference of an edge's two lengths, mm.
const SAME_MM: f32 = 0.01;

/// Twice the area of a triangle; positive where `c` lies to the left of the way from `a` to `b`.
fn area(a: Point, b: Point, c: Point) -> f32 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// A turn of the plane about its origin, and a shift after that.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Motion {
    cos: f32,
    sin: f32,
    shift: Point,
}

impl Motion {
    const STILL: Self = Self {
        cos: 1.0,
        sin: 0.0,
        shift: Point::new(0.0, 0.0),
    };

    /// The motion that lays one edge on another of the same length.
    fn between(from: [Point; 2], to: [Point; 2]) -> Self {
        let (u, v) = (
            Point::new(from[1].x - from[0].x, from[1].y - from[0].y),
            Point::new(to[1].x - to[0].x, to[1].y - to[0].y),
        );
        let size = libm::sqrtf((u.x * u.x + u.y * u.y) * (v.x * v.x + v.y * v.y));
        let mut motion = Self {
            cos: (u.x * v.x + u.y * v.y) / size,
            sin: (u.x * v.y - u.y * v.x) / size,
            ..Self::STILL
        };
        let middle = |[a, b]: [Point; 2]| Point::new((a.x + b.x) / 2.0, (a.y + b.y) / 2.0);
        let (at, goal) = (motion.apply(middle(from)), middle(to));
        motion.shift = Point::new(goal.x - at.x, goal.y - at.y);
        motion
    }

    fn apply(&self, p: Point) -> Point {
        Point::new(
            self.cos * p.x - self.sin * p.y + self.shift.x,
            self.sin * p.x + self.cos * p.y + self.shift.y,
        )
    }

    /// The motion that does `first` and then this one.
    fn after(&self, first: &Self) -> Self {
        Self {
            cos: self.cos * first.cos - self.sin * first.sin,
            sin: self.sin * first.cos + self.cos * first.sin,
            shift: self.apply(first.shift),
        }
    }
}

/// An edge as it is met on the way out of a module: its left and its right end.
type Gate = (Point, Point);

/// A seam as one of its modules has it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Exit {
    from: usize,
    to: usize,
    gate: Gate,
    /// Coordinates of the module beyond as coordinates of this one, and the other way.
    unfold: Motion,
    enter: Motion,
}

/// A way from module to module through seams.
#[derive(Clone, Debug, PartialEq)]
struct Way {
    ends: (usize, usize),
    /// The seams in their order, in the first module's coordinates.
    gates: Vec<Gate>,
    /// The last module's coordinates as the first's.
    unfold: Motion,
}

/// The seams of a skin and all ways through them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Seams {
    exits: Vec<Exit>,
    /// By their ends, ascending.
    ways: Vec<Way>,
}

impl Seams {
    /// Finds the ways through the seams of modules with these middles.
    pub(super) fn new(middles: &[Point], seams: &[Seam]) -> Result<Self, LayoutError> {
        let mut exits = Vec::with_capacity(2 * seams.len());
        for (index, seam) in seams.iter().enumerate() {
            let [a, b] = seam.modules;
            if a == b || a.max(b) >= middles.len() {
                return Err(LayoutError::SeamModules { index });
            }
            let lengths = seam.edges.map(|[from, to]| from.distance(to));
            let same = (lengths[0] - lengths[1]).abs() <= SAME_MM;
            // NaN is no length either.
            if !(same && lengths.iter().all(|l| *l > SAME_MM && l.is_finite())) {
                return Err(LayoutError::SeamEdges { index });
            }
            for (near, far) in [(0, 1), (1, 0)] {
                let edge = seam.edges[near];
                let gate = match area(middles[seam.modules[near]], edge[0], edge[1]) > 0.0 {
                    true => (edge[1], edge[0]),
                    false => (edge[0], edge[1]),
                };
                exits.push(Exit {
                    from: seam.modules[near],
                    to: seam.modules[far],
                    gate,
                    unfold: Motion::between(seam.edges[far], edge),
                    enter: Motion::between(edge, seam.edges[far]),
                });
            }
        }
        let mut ways = Vec::new();
        for start in 0..middles.len() {
            let mut found = alloc::vec![Way {
                ends: (start, start),
                gates: Vec::new(),
                unfold: Motion::STILL,
            }];
            let mut passed = alloc::vec![alloc::vec![start]];
            // Each way is followed by those that go one seam further; a module is met once on a way.
            let mut next = 0;
            while next < found.len() {
                let (way, met) = (found[next].clone(), passed[next].clone());
                next += 1;
                if way.gates.len() == MOST_STEPS {
                    continue;
                }
                let onward = exits.iter().filter(|exit| exit.from == way.ends.1);
                for exit in onward.filter(|exit| !met.contains(&exit.to)) {
                    let (left, right) = exit.gate;
                    let mut gates = way.gates.clone();
                    gates.push((way.unfold.apply(left), way.unfold.apply(right)));
                    found.push(Way {
                        ends: (start, exit.to),
                        gates,
                        unfold: way.unfold.after(&exit.unfold),
                    });
                    passed.push([&met[..], &[exit.to]].concat());
                }
                if ways.len() + found.len() > MOST_WAYS + middles.len() {
                    return Err(LayoutError::SeamWays { most: MOST_WAYS });
                }
            }
            ways.extend(found.drain(1..));
        }
        ways.sort_by_key(|way| way.ends);
        Ok(Self { exits, ways })
    }

    /// True where the skin has no seam.
    pub fn is_empty(&self) -> bool {
        self.exits.is_empty()
    }

    /// The shortest way along the skin between places of modules: its length in the direction in which it sets out, in the
    /// first module's coordinates, mm. `None` where no way joins the modules.
    pub fn step(&self, (from, p): (usize, Point), (to, q): (usize, Point)) -> Option<(f32, f32)> {
        if from == to {
            return Some((q.x - p.x, q.y - p.y));
        }
        let first = self.ways.partition_point(|way| way.ends < (from, to));
        let ways = self.ways[first..].iter();
        let mut best: Option<(f32, Point)> = None;
        for way in ways.take_while(|way| way.ends == (from, to)) {
            let found = shortest(p, &way.gates, way.unfold.apply(q));
            if best.is_none_or(|best| found.0 < best.0) {
                best = Some(found);
            }
        }
        let (length, towards) = best?;
        let straight = p.distance(towards);
        let scale = if straight > 0.0 {
            length / straight
        } else {
            0.0
        };
        Some(((towards.x - p.x) * scale, (towards.y - p.y) * scale))
    }

    /// The module and the place that are reached from a place of a module on a straight line, across seams, to a place in
    /// its plane.
    pub fn walk(&self, mut module: usize, mut from: Point, mut to: Point) -> (usize, Point) {
        for _ in 0..MOST_STEPS {
            let leaves = |exit: &&Exit| {
                let (left, right) = exit.gate;
                exit.from == module
                    && area(right, left, from) >= 0.0
                    && area(right, left, to) < 0.0
                    && area(from, to, left) >= 0.0
                    && area(from, to, right) <= 0.0
            };
            let Some(exit) = self.exits.iter().find(leaves) else {
                break;
            };
            (module, from, to) = (exit.to, exit.enter.apply(from), exit.enter.apply(to));
        }
        (module, to)
    }
}

/// Length of the shortest line from `p` through all gates to `q`, and its first bend, or `q` where it has none.
///
/// The funnel of all straight lines from the last bend narrows gate by gate; where it closes, the line bends at its side.
fn shortest(p: Point, gates: &[Gate], q: Point) -> (f32, Point) {
    let last = gates.len();
    let gate = |n: usize| if n == last { (q, q) } else { gates[n] };
    let (mut apex, mut length, mut bend) = (p, 0.0, None);
    let mut at = 0;
    'bends: loop {
        // A gate is passed by a line that bends at its end.
        let passed = |(left, right): Gate| left.distance(apex).min(right.distance(apex)) < SAME_MM;
        at += (at..last).take_while(|n| passed(gate(*n))).count();
        let ((mut left, mut right), mut sides) = (gate(at), (at, at));
        for n in at + 1..=last {
            let (l, r) = gate(n);
            if area(apex, right, r) >= 0.0 {
                if area(apex, left, r) > 0.0 {
                    length += apex.distance(left);
                    bend = bend.or(Some(left));
                    (apex, at) = (left, sides.0 + 1);
                    continue 'bends;
                }
                (right, sides.1) = (r, n);
            }
            if area(apex, left, l) <= 0.0 {
                if area(apex, right, l) < 0.0 {
                    length += apex.distance(right);
                    bend = bend.or(Some(right));
                    (apex, at) = (right, sides.1 + 1);
                    continue 'bends;
                }
                (left, sides.0) = (l, n);
            }
        }
        return (length + apex.distance(q), bend.unwrap_or(q));
    }
}

#[cfg(test)]
#[path = "seams_tests.rs"]
mod tests;
