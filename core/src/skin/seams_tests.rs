//! Ways along folded skins against folded boxes, a finely cut sheet, and hostile seams.

use super::*;
use crate::random::RandomStream;

fn at(x: f32, y: f32) -> Point {
    Point::new(x, y)
}

/// The middle of a square of 20 mm by 20 mm in its own coordinates.
const MIDDLE: Point = Point::new(0.0, 0.0);

/// The right edge of one square on the left edge of the next.
fn right_to_left(a: usize, b: usize) -> Seam {
    Seam {
        modules: [a, b],
        edges: [
            [at(10.0, -10.0), at(10.0, 10.0)],
            [at(-10.0, -10.0), at(-10.0, 10.0)],
        ],
    }
}

fn length(seams: &Seams, from: (usize, Point), to: (usize, Point)) -> f32 {
    let (dx, dy) = seams.step(from, to).unwrap();
    libm::hypotf(dx, dy)
}

/// A square tube of four sides: the way round it is the shorter of two, whatever the fold's angle.
#[test]
fn round_a_tube_the_shorter_way_counts() {
    let tube: Vec<Seam> = (0..4).map(|n| right_to_left(n, (n + 1) % 4)).collect();
    let seams = Seams::new(&[MIDDLE; 4], &tube).unwrap();
    let mut stream = RandomStream::new(3, "tube");
    let mut draw = || (stream.uniform() * 20.0 - 10.0) as f32;
    for case in 0..500 {
        let (from, to) = (case % 4, case / 4 % 4);
        let (p, q) = (at(draw(), draw()), at(draw(), draw()));
        if from == to {
            continue;
        }
        let along = |side: usize, p: Point| 20.0 * side as f32 + p.x;
        let round = (along(to, q) - along(from, p)).rem_euclid(80.0);
        let want = libm::hypotf(round.min(80.0 - round), q.y - p.y);
        let found = length(&seams, (from, p), (to, q));
        assert!((found - want).abs() < 1e-3, "case {case}: {found}, {want}");
    }
}

/// The least way over a sheet that is cut finely at every seam: from each point of one edge to each of the next.
fn finely(p: Point, gates: &[Gate], q: Point) -> f32 {
    const CUTS: usize = 400;
    let cut = |(left, right): Gate, n: usize| {
        let part = n as f32 / CUTS as f32;
        at(
            left.x + part * (right.x - left.x),
            left.y + part * (right.y - left.y),
        )
    };
    let mut ways = alloc::vec![(p, 0.0)];
    for gate in gates {
        let reach = |to: Point| {
            let each = ways.iter().map(|(from, so_far)| so_far + from.distance(to));
            each.fold(f32::INFINITY, f32::min)
        };
        ways = (0..=CUTS)
            .map(|n| (cut(*gate, n), reach(cut(*gate, n))))
            .collect();
    }
    let each = ways.iter().map(|(from, so_far)| so_far + from.distance(q));
    each.fold(f32::INFINITY, f32::min)
}

/// Rows of squares that turn left, right or go on, with edges that are part of a side: the line bends where it must.
#[test]
fn lines_bend_as_over_a_finely_cut_sheet() {
    let mut stream = RandomStream::new(4, "sheets");
    let (mut bent, mut straight) = (0, 0);
    for case in 0..60 {
        let count = 2 + case % 4;
        let seams: Vec<Seam> = (0..count - 1)
            .map(|n| {
                let low = (stream.uniform() * 12.0 - 10.0) as f32;
                let high = low + 8.0;
                let near = match stream.next_u64() % 3 {
                    0 => [at(10.0, low), at(10.0, high)],
                    1 => [at(-low, 10.0), at(-high, 10.0)],
                    _ => [at(low, -10.0), at(high, -10.0)],
                };
                let start = (stream.uniform() * 12.0 - 10.0) as f32;
                let far = [at(-10.0, start), at(-10.0, start + 8.0)];
                Seam {
                    modules: [n, n + 1],
                    edges: [near, far],
                }
            })
            .collect();
        let built = Seams::new(&alloc::vec![MIDDLE; count], &seams).unwrap();
        let mut draw = || (stream.uniform() * 20.0 - 10.0) as f32;
        let (p, q) = (at(draw(), draw()), at(draw(), draw()));
        let way = built
            .ways
            .iter()
            .find(|way| way.ends == (0, count - 1))
            .unwrap();
        let want = finely(p, &way.gates, way.unfold.apply(q));
        let found = length(&built, (0, p), (count - 1, q));
        assert!(
            found <= want + 1e-3 && found > want - 0.02,
            "case {case}: {found}, {want}"
        );
        let back = length(&built, (count - 1, q), (0, p));
        assert!((found - back).abs() < 1e-3, "case {case}: {found}, {back}");
        let direct = p.distance(way.unfold.apply(q));
        match found > direct + 1e-3 {
            true => bent += 1,
            false => straight += 1,
        }
    }
    assert!(bent > 10 && straight > 10, "{bent} {straight}");
}

#[test]
fn a_walk_ends_where_the_step_points() {
    // The third module is drawn upside down.
    let turned = Seam {
        modules: [1, 2],
        edges: [
            [at(10.0, -10.0), at(10.0, 10.0)],
            [at(10.0, 10.0), at(10.0, -10.0)],
        ],
    };
    let seams = Seams::new(&[MIDDLE; 3], &[right_to_left(0, 1), turned]).unwrap();
    let (p, q) = (at(3.0, -4.0), at(2.0, 7.0));
    let (dx, dy) = seams.step((0, p), (2, q)).unwrap();
    // Unfolded, the third module's (2, 7) lies at 40 - 2, -7.
    assert!((dx - 35.0).abs() < 1e-3 && (dy + 3.0).abs() < 1e-3);
    let (module, place) = seams.walk(0, p, at(p.x + dx, p.y + dy));
    assert!(
        module == 2 && place.distance(q) < 1e-3,
        "{module} {place:?}"
    );
    // Beyond an edge without a seam the place stays in its module's plane.
    assert_eq!(seams.walk(0, p, at(0.0, 30.0)), (0, at(0.0, 30.0)));
    assert_eq!(seams.walk(0, p, at(f32::NAN, 0.0)).0, 0);
}

#[test]
fn modules_without_a_way_have_none_and_bad_seams_are_refused() {
    let seams = Seams::new(&[MIDDLE; 3], &[right_to_left(0, 1)]).unwrap();
    assert_eq!(seams.step((0, at(0.0, 0.0)), (2, at(0.0, 0.0))), None);
    assert_eq!(
        seams.step((0, at(1.0, 2.0)), (0, at(4.0, 6.0))),
        Some((3.0, 4.0))
    );
    let refused = |seam: Seam| Seams::new(&[MIDDLE; 3], &[right_to_left(0, 1), seam]).unwrap_err();
    for modules in [[0, 0], [0, 3], [usize::MAX, 0]] {
        let seam = Seam {
            modules,
            ..right_to_left(0, 1)
        };
        assert_eq!(refused(seam), LayoutError::SeamModules { index: 1 });
    }
    let good = right_to_left(1, 2).edges;
    let point = [at(1.0, 1.0); 2];
    let longer = [at(0.0, 0.0), at(0.0, 20.1)];
    for edges in [
        [point, point],
        [good[0], longer],
        [[at(f32::NAN, 0.0), at(1.0, 1.0)], good[1]],
    ] {
        let seam = Seam {
            edges,
            ..right_to_left(1, 2)
        };
        assert_eq!(refused(seam), LayoutError::SeamEdges { index: 1 });
    }
    // Twelve modules, each joined with each: more ways than anyone could go through.
    let all = (0..12).flat_map(|a| (0..a).map(move |b| right_to_left(a, b)));
    let all: Vec<Seam> = all.collect();
    let error = Seams::new(&[MIDDLE; 12], &all).unwrap_err();
    assert_eq!(error, LayoutError::SeamWays { most: MOST_WAYS });
}
