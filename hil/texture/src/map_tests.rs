//! Axes say what a model's file says, ellipses lie along their points.

use super::*;

#[test]
fn an_axis_says_only_what_the_file_names() {
    let labels = |latent: &str, width| {
        let view = View::named_by(latent, width);
        (view.x.label(), view.y.label())
    };
    let of = |rough: &str, hard: &str| format!("{{\"roughness\":{rough},\"hardness\":{hard}}}");
    let (first, third) = (
        r#"{"coordinate":0,"sign":1}"#,
        r#"{"coordinate":2,"sign":-1}"#,
    );
    let says = |latent: &str| labels(latent, 3);
    let pair = |x: &str, y: &str| (x.to_owned(), y.to_owned());
    assert_eq!(
        says(&of(first, third)),
        pair("z1 (roughness and friction)", "-z3 (hardness)")
    );
    let apart = format!("{{\"roughness\":{first},\"friction\":{third}}}");
    assert_eq!(says(&apart), pair("z1 (roughness)", "z2"));
    assert_eq!(
        says(&of(third, third)),
        pair("-z3 (roughness, friction and hardness)", "z1")
    );
    assert_eq!(says(&of("null", first)), pair("z2", "z1 (hardness)"));
    assert_eq!(
        says(&of(first, "null")),
        pair("z1 (roughness and friction)", "z2")
    );
    for nothing in [
        "",
        "{}",
        "[",
        &of("{\"coordinate\":3}", "{\"coordinate\":-1}"),
    ] {
        assert_eq!(says(nothing), pair("z1", "z2"));
    }
    assert_eq!(labels("", 1), pair("z1", "z1"));
}

#[test]
fn an_ellipse_lies_along_its_points() {
    // on a line along (3, 4), two of four at a distance of 5: a variance of 12.5
    let points = [(3.0, 4.0), (-3.0, -4.0), (0.0, 0.0), (0.0, 0.0)];
    let spot = Spot::around(&points);
    assert!(spot.mean.0.abs() < 1e-12 && spot.mean.1.abs() < 1e-12);
    assert!((spot.half.0 - 12.5f64.sqrt()).abs() < 1e-9 && spot.half.1.abs() < 1e-6);
    assert!((spot.turn - (4.0f64).atan2(3.0)).abs() < 1e-9);
    assert_eq!(Spot::around(&[]).half, (0.0, 0.0));
}
