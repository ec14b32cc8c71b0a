//! Corners of labels are far from each other.

use super::*;

/// How many coordinates the two closest of so many labels differ in.
fn closest(labels: usize, latent: usize) -> usize {
    let labels: Vec<String> = (0..labels).map(|n| format!("label {n:02}")).collect();
    let codes = by_codes(&labels, latent);
    assert_eq!(codes.len(), labels.len());
    let all: Vec<_> = codes.values().collect();
    assert!(all.iter().all(|code| code.len() == latent.min(CODED)));
    let pairs = (0..all.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    let sides = |n: usize| all[n].iter().map(|z| z.is_sign_positive());
    let differ = |(a, b): (usize, usize)| sides(a).zip(sides(b)).filter(|(a, b)| a != b).count();
    pairs.map(differ).min().unwrap_or(0)
}

#[test]
fn each_label_has_a_corner_far_from_all_others() {
    // Seven fabrics on the corners of a cube, and twenty materials as far apart as a code of 32 words of 16 bits can be
    // (Reed and Muller's).
    assert_eq!(closest(7, 3), 1);
    assert_eq!(closest(20, 16), 8);
    assert_eq!(closest(2, 3), 3);
    // More coordinates than are coded.
    assert_eq!(closest(2, 20), 16);
    assert_eq!([1, 3, 16, 20].map(corners), [2, 8, 65_536, 65_536]);
}
