//! Layouts that are, and layouts that are refused.

use super::*;

#[test]
fn a_flat_module_has_its_first_taxel_top_left() {
    let m = Module::grid("pad", 4, 4, 4.7).unwrap();
    let p = m.points();
    assert!(p[0].distance(Point::new(-7.05, 7.05)) < 1e-5);
    assert!(p[3].distance(Point::new(7.05, 7.05)) < 1e-5);
    assert!(p[12].distance(Point::new(-7.05, -7.05)) < 1e-5);
    assert!((m.spacing() - 4.7).abs() < 1e-5);
    let (low, high) = m.bounds();
    assert!(low.distance(p[12]) < 1e-5 && high.distance(p[3]) < 1e-5);
}

#[test]
fn modules_are_numbered_through() {
    let tip = Module::grid("tip", 6, 4, 4.0).unwrap();
    let pad = Module::grid("pad", 4, 4, 4.7).unwrap();
    let l = Layout::new(alloc::vec![tip, pad]).unwrap();
    assert_eq!(l.taxels(), 40);
    assert_eq!(l.range(1), 24..40);
    assert_eq!(l.range(2), 0..0);
    assert_eq!(l.locate(23), Some((0, 23)));
    assert_eq!(l.locate(24), Some((1, 0)));
    assert_eq!(l.locate(40), None);
}

#[test]
fn bad_layouts_are_refused_with_their_place() {
    use LayoutError as E;
    let p = Point::new;
    let bad = |points: &[Point]| Module::scattered("s", points).unwrap_err();
    assert_eq!(bad(&[]), E::NoTaxels);
    assert_eq!(
        bad(&[p(0., 0.), p(f32::NAN, 0.)]),
        E::NotFinite { taxel: 1 }
    );
    assert_eq!(
        bad(&[p(0., 1.), p(2., 2.), p(-0., 1.)]),
        E::Duplicate {
            first: 0,
            second: 2
        }
    );
    assert!(matches!(
        Module::grid("g", 4, 4, 0.0),
        Err(E::BadPitch { .. })
    ));
    assert_eq!(Module::grid("g", 0, 4, 1.0).unwrap_err(), E::NoTaxels);
    let g = || Module::grid("g", 1, 2, 1.0).unwrap();
    assert_eq!(g().with_axes(2).unwrap_err(), E::BadAxes { axes: 2 });
    assert_eq!(Layout::new(alloc::vec![]).unwrap_err(), E::NoModules);
    let off = g().with_active(&[false, false]).unwrap();
    assert_eq!(Layout::single(off).unwrap_err(), E::NothingActive);
    assert_eq!(
        Layout::new(alloc::vec![g(), g()]).unwrap_err(),
        E::SameName {
            first: 0,
            second: 1
        }
    );
}

#[test]
fn spacing_of_scattered_points_is_the_median_nearest_distance() {
    let points: Vec<Point> = (0..9)
        .map(|i| Point::new((i % 3) as f32 * 2.0, (i / 3) as f32 * 3.0))
        .collect();
    let m = Module::scattered("s", &points).unwrap();
    assert!((m.spacing() - 2.0).abs() < 1e-6);
    assert!((Module::scattered("s", &points[..1]).unwrap().spacing() - 1.0).abs() < 1e-6);
}
