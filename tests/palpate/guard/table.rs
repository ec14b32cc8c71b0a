//! The guard's checked-in table is what its generator makes.
//!
//! `PALPATE_WRITE_GUARD=1 cargo test -p palpate-tests -- guard::table` writes it anew.

use super::kernel::{DECAYS, corners, envelope, fit, rates, sum, times};

const PATH: &str = "../core/src/guard/table.rs";

/// What released latent heat adds at most to what is predicted without any: at 0.1 mm, to its mean over 10 s, at
/// 0.4 mm, K. `latent.rs` searches for it.
pub const LATENT_K: [f64; 3] = [0.2, 0.1, 0.05];

fn row(name: &str, about: &str, values: &[f64; DECAYS]) -> String {
    let lines = values.chunks(3).map(|chunk| {
        let words: Vec<String> = chunk.iter().map(|v| format!("{v:.6}")).collect();
        format!("    {},\n", words.join(", "))
    });
    let rows: String = lines.collect();
    format!(
        "\n/// {about}\n#[rustfmt::skip]\npub(super) const {name}: [f64; {DECAYS}] = [\n{rows}];\n"
    )
}

#[test]
fn the_table_is_the_generators() {
    let (corners, times) = (corners(), times());
    let rates = rates(&corners);
    let fitted = [0, 1].map(|depth| {
        let target = envelope(&corners, depth, &times);
        let c = fit(&rates, &times, &target).map(|c| c * 1.0001); // more than rounding takes away
        let over = |(t, v): (&f64, &f64)| sum(&rates, &c, *t) / v;
        let within = times.iter().zip(&target).take_while(|(t, _)| **t < 100.0);
        let (low, high) = within
            .map(over)
            .fold((9.0f64, 0.0f64), |m, x| (m.0.min(x), m.1.max(x)));
        println!("depth {depth}: {low:.4} to {high:.4} of the largest response, up to 100 s");
        assert!(low >= 1.0 && high < 1.1);
        c
    });
    let text = format!(
        "//! Constants of the thermal budget. Written by `tests/palpate/guard/table.rs`, which says how; do not edit.\n\n\
        /// Temperature of resting skin, degrees C.\n\
        pub(super) const REST_C: f64 = 33.0;\n\n\
        /// Rate of the slowest decay, 1/s; each is twice as fast as the one before.\n\
        pub(super) const SLOWEST: f64 = {:.9};\n{}{}\n\
        /// What released latent heat may add at 0.1 mm, to its mean over 10 s, and at 0.4 mm, K.\n\
        pub(super) const LATENT_K: [f64; 3] = {LATENT_K:?};\n",
        rates[0],
        row(
            "SHALLOW",
            "What each decay of a joule makes at 0.1 mm, K/J.",
            &fitted[0]
        ),
        row(
            "DEEP",
            "What each decay of a joule makes at 0.4 mm, K/J.",
            &fitted[1]
        ),
    );
    if std::env::var_os("PALPATE_WRITE_GUARD").is_some() {
        std::fs::write(PATH, &text).unwrap();
    }
    let written = std::fs::read_to_string(PATH).unwrap();
    assert!(
        written == text,
        "{PATH} is not what its generator makes: write it anew"
    );
}
