//! Contacts along folded skins against geometry, and against the plane where nothing is folded.

use crate::contact::{Compressor, Contact, Scope, Settings};
use crate::random::RandomStream;
use crate::skin::{Axes, Layout, Module, RelativeFrame, Seam};
use crate::units::Point;
use alloc::vec::Vec;

fn at(x: f32, y: f32) -> Point {
    Point::new(x, y)
}

/// Edges of two pads of 4 x 4 taxels, 20 mm wide: the right one of the first and the left one of the second.
const SIDES: [[Point; 2]; 2] = [
    [Point::new(10.0, -10.0), Point::new(10.0, 10.0)],
    [Point::new(-10.0, -10.0), Point::new(-10.0, 10.0)],
];

/// Pads of 4 x 4 taxels, 5 mm apart, at these places of the plane.
fn pads(places: &[Point]) -> Layout {
    let pad = |(n, place): (usize, &Point)| {
        let pad = Module::grid(&alloc::format!("pad {n}"), 4, 4, 5.0).unwrap();
        pad.with_origin(*place).unwrap()
    };
    Layout::new(places.iter().enumerate().map(pad).collect()).unwrap()
}

fn joined(layout: Layout, pairs: &[[usize; 2]]) -> Layout {
    let seam = |modules: &[usize; 2]| Seam {
        modules: *modules,
        edges: SIDES,
    };
    let seams: Vec<Seam> = pairs.iter().map(seam).collect();
    layout.with_seams(&seams).unwrap()
}

fn frame(layout: &Layout, touched: &[(usize, f32)]) -> RelativeFrame {
    let mut frame = RelativeFrame::new(layout);
    let mut d = alloc::vec![[0.0; 3]; layout.taxels()];
    for (taxel, counts) in touched {
        d[*taxel][2] = *counts;
    }
    frame.load(&d, Axes::Z, 1.0).unwrap();
    frame
}

fn compressor(layout: &Layout, clusters: u16) -> Compressor {
    let settings = Settings {
        clusters,
        scope: Scope::Skin,
        ..Settings::default()
    };
    Compressor::new(layout, settings).unwrap()
}

/// One press over an edge: the plane's drawing has both sides 100 mm apart, the skin has them 5 mm apart.
#[test]
fn a_press_over_a_fold_is_one_contact_at_the_fold() {
    let flat = pads(&[at(0.0, 0.0), at(100.0, 0.0)]);
    let folded = joined(flat.clone(), &[[0, 1]]);
    // The right column of one side, the left column of the other, 2.5 mm from the fold each.
    let press = [(7, 100.0), (11, 100.0), (16 + 4, 300.0), (16 + 8, 300.0)];
    let one = compressor(&folded, 1)
        .compress(&frame(&folded, &press))
        .unwrap()[0];
    // Weighed 1 to 3 over 5 mm, 1.25 mm from the further side.
    assert_eq!((one.module, one.members), (1, 4));
    assert!((one.place.x - (100.0 - 10.0 + 1.25)).abs() < 1e-3 && one.place.y.abs() < 1e-3);
    assert!((one.intensity - 300.0).abs() < 1e-2);
    // Over the plane the mean lies where there is no skin.
    let plane = compressor(&flat, 1)
        .compress(&frame(&flat, &press))
        .unwrap()[0];
    assert!(plane.place.x > 20.0 && plane.place.x < 80.0, "{plane:?}");
}

/// Four sides of a tube, pressed at two places: by the drawing the first and the last side are far apart, round the tube
/// they are neighbours.
#[test]
fn clusters_join_round_a_tube() {
    let strip = pads(&[at(0.0, 0.0), at(20.0, 0.0), at(40.0, 0.0), at(60.0, 0.0)]);
    let tube = joined(strip.clone(), &[[0, 1], [1, 2], [2, 3], [3, 0]]);
    // A press over the edge between the last side and the first, another in the middle of the second.
    let seam = [(48 + 7, 90.0), (48 + 11, 90.0), (4, 90.0), (8, 90.0)];
    let middle = [
        (16 + 5, 80.0),
        (16 + 6, 80.0),
        (16 + 9, 80.0),
        (16 + 10, 80.0),
    ];
    let press = frame(&tube, &[&seam[..], &middle[..]].concat());
    let found = |layout: &Layout| {
        let mut contacts = compressor(layout, 2).compress(&press).unwrap().to_vec();
        contacts.sort_by(|a, b| a.place.x.total_cmp(&b.place.x));
        contacts
    };
    let round = found(&tube);
    assert!(round.iter().all(|c| c.members == 4), "{round:?}");
    let at_seam = |c: &Contact| (c.place.x + 10.0).abs() < 1e-2 || (c.place.x - 70.0).abs() < 1e-2;
    assert_eq!(round.iter().filter(|c| at_seam(c)).count(), 1, "{round:?}");
    assert!(
        round.iter().any(|c| (c.place.x - 20.0).abs() < 1e-2),
        "{round:?}"
    );
    // The drawing tears the first press apart.
    assert!(found(&strip).iter().any(|c| c.members != 4));
}

/// Contacts along a skin whose drawing is the unfolded skin are those of the plane.
#[test]
fn a_flat_skin_with_seams_gives_the_contacts_of_the_plane() {
    let flat = pads(&[at(0.0, 0.0), at(20.0, 0.0), at(40.0, 0.0)]);
    let seams = joined(flat.clone(), &[[0, 1], [1, 2]]);
    let mut stream = RandomStream::new(5, "flat skin");
    let (mut plane, mut along) = (compressor(&flat, 1), compressor(&seams, 1));
    for case in 0..200 {
        let mut touched: Vec<(usize, f32)> = Vec::new();
        for taxel in 0..48 {
            if stream.uniform() < 0.3 {
                touched.push((taxel, 2.0 + 400.0 * stream.uniform() as f32));
            }
        }
        let press = frame(&flat, &touched);
        let a = plane.compress(&press).unwrap().to_vec();
        let b = along.compress(&press).unwrap();
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert!(a.place.distance(b.place) < 5e-3, "case {case}: {a:?} {b:?}");
            assert_eq!((a.id, a.members), (b.id, b.members));
        }
    }
}

/// A contact that slides over a fold, with another beside it, keeps its identity although the drawing makes it leap.
#[test]
fn identities_go_over_a_fold() {
    let layout = joined(
        pads(&[at(0.0, 0.0), at(100.0, 0.0), at(22.0, 0.0)]),
        &[[0, 1]],
    );
    let mut c = compressor(&layout, 4);
    // The third pad lies beside the first in the drawing, and is another finger.
    let before = c
        .compress(&frame(&layout, &[(7, 100.0), (32 + 5, 60.0)]))
        .unwrap()
        .to_vec();
    let after = c
        .compress(&frame(&layout, &[(16 + 4, 100.0)]))
        .unwrap()
        .to_vec();
    assert_eq!(after[0].id, before[0].id, "{before:?} {after:?}");
}

/// Random presses, few and many, on joined and on lone modules: sound contacts, and the same again.
#[test]
fn whatever_comes_contacts_are_sound() {
    let layout = joined(
        pads(&[at(0.0, 0.0), at(20.0, 0.0), at(300.0, 7.0)]),
        &[[0, 1]],
    );
    let mut stream = RandomStream::new(6, "along");
    let (mut one, mut other) = (compressor(&layout, 3), compressor(&layout, 3));
    for _ in 0..300 {
        let share = stream.uniform();
        let mut touched: Vec<(usize, f32)> = Vec::new();
        for taxel in 0..48 {
            let top = [1.5, 1e9][(stream.next_u64() % 2) as usize];
            if stream.uniform() < share {
                touched.push((taxel, top));
            }
        }
        let press = frame(&layout, &touched);
        let found = one.compress(&press).unwrap();
        assert_eq!(found, other.compress(&press).unwrap());
        assert_eq!(found.len(), touched.len().min(3));
        let members: u32 = found.iter().map(|c| c.members).sum();
        assert_eq!(members as usize, touched.len());
        for (i, c) in found.iter().enumerate() {
            assert!(c.place.x.is_finite() && c.place.y.is_finite() && c.intensity.is_finite());
            assert!(found[..i].iter().all(|o| o.id != c.id));
        }
    }
}
