//! The guard's checked-in table is what its generator makes.
//!
//! `PALPATE_WRITE_GUARD=1 cargo test -p palpate-tests -- guard::table` writes it anew.

use std::fmt::Write;

use palpate_core::physics::TissueParameters;

use super::kernel::{DECAYS, corners, envelope, fit, rates, sized, sum, times};

const PATH: &str = "../core/src/guard/table.rs";

/// What released latent heat adds at most to what is predicted without any: at 0.1 mm, to its mean over 10 s, at
/// 0.4 mm, K. `latent.rs` searches for it.
pub const LATENT_K: [f64; 3] = [0.2, 0.1, 0.05];

/// Lengths of which each diameter has rows, mm. Between them the guard draws straight lines over one by the length squared.
const LENGTHS_MM: [f64; 3] = [f64::INFINITY, 5.0, 3.0];
/// The length that rows count a joule for, mm.
const UNIT_MM: f64 = 5.0;
/// The wire whose rows are exact, nm: most benches have it.
const EXACT_NM: u32 = 75_000;
/// Factor of the rows of other diameters: between two of them responses bend by half a percent.
const MARGIN: f64 = 1.006;
/// More than rounding takes away.
const ROUNDING: f64 = 1.0001;

/// Nodes of the finger whose tissue conducts better, under a wire of so many nm.
fn inner_nodes(diameter_nm: u32) -> usize {
    let finger = TissueParameters::DEFAULT;
    let r0 = f64::from(diameter_nm) * 0.5e-9;
    let step = libm::log(finger.outer_radius_m / r0) / 16.0;
    let depth = |node: i32| r0 * libm::exp(step * (f64::from(node) + 0.5)) - r0;
    (0..16).filter(|n| depth(*n) > finger.outer_depth_m).count()
}

/// The diameters of the table, nm. In the model tissue conducts by node: where one more node lies deep the response jumps, so
/// there stand two.
fn diameters_nm() -> Vec<u32> {
    let mut all = vec![50_000, EXACT_NM, 87_000, 100_000];
    for nm in 50_000..100_000 {
        if inner_nodes(nm) != inner_nodes(nm + 1) {
            all.extend([nm, nm + 1]);
        }
    }
    all.sort_unstable();
    all
}

/// Both depths' rows of a wire, K by a joule for 5 mm.
fn rows(diameter_nm: u32, length_mm: f64) -> [[f64; DECAYS]; 2] {
    let times = times();
    let corners = corners(&sized(f64::from(diameter_nm) * 1e-3, length_mm));
    let units = if length_mm.is_finite() {
        length_mm / UNIT_MM
    } else {
        1.0
    };
    let margin = if diameter_nm == EXACT_NM {
        ROUNDING
    } else {
        MARGIN
    };
    let rates = table_rates();
    [0, 1].map(|depth| {
        let target = envelope(&corners, depth, &times);
        let target: Vec<f64> = target.iter().map(|k| k * units).collect();
        let c = fit(&rates, &times, &target).map(|c| c * margin);
        let over = |(t, v): (&f64, &f64)| sum(&rates, &c, *t) / v;
        let within = times.iter().zip(&target).take_while(|(t, _)| **t < 100.0);
        let (low, high) = within
            .map(over)
            .fold((9.0f64, 0.0f64), |m, x| (m.0.min(x), m.1.max(x)));
        println!(
            "{diameter_nm} nm, {length_mm} mm, depth {depth}: {low:.4} to {high:.4} of the largest response, up to 100 s"
        );
        assert!(low >= 1.0 && high < 1.13);
        c
    })
}

/// The decays of the table: the slowest is the final module's.
pub fn table_rates() -> [f64; DECAYS] {
    rates(&corners(&sized(f64::from(EXACT_NM) * 1e-3, UNIT_MM)))
}

/// A row as the table prints it.
fn printed(text: &mut String, row: &[f64; DECAYS]) {
    text.push_str("            [\n");
    for chunk in row.chunks(7) {
        let words: Vec<String> = chunk.iter().map(|v| format!("{v:.6}")).collect();
        let _ = writeln!(text, "                {},", words.join(", "));
    }
    text.push_str("            ],\n");
}

fn text() -> String {
    let diameters = diameters_nm();
    let takes = LENGTHS_MM.map(|mm| {
        if mm.is_finite() {
            (UNIT_MM / mm).powi(2)
        } else {
            0.0
        }
    });
    let mut text = format!(
        "//! Constants of the thermal budget. Written by `tests/palpate/guard/table.rs`, which says how; do not edit.\n\n\
        /// Decays of a wire's tissue.\n\
        pub(super) const DECAYS: usize = {DECAYS};\n\n\
        /// Rate of the slowest decay, 1/s; each is twice as fast as the one before.\n\
        pub(super) const SLOWEST: f64 = {:.9};\n\n\
        /// Most that released latent heat adds at 0.1 mm, to its mean over 10 s, and at 0.4 mm, K.\n\
        pub(super) const LATENT_K: [f64; 3] = {LATENT_K:?};\n\n\
        /// Diameters of the rows, nm.\n\
        pub(super) const DIAMETERS_NM: [u32; {}] = {diameters:?};\n\n\
        /// Lengths of the rows, as (5 mm / length) squared: what the ends take. The first is a wire without ends.\n\
        pub(super) const LENGTHS: [f64; {}] = {takes:?};\n\n\
        /// Temperature that a joule makes in each decay for 5 mm of wire, K: by diameter, by length, at 0.1 and at 0.4 mm.\n\
        #[rustfmt::skip]\n\
        pub(super) const ROWS: [[[[f64; DECAYS]; 2]; {}]; {}] = [\n",
        table_rates()[0],
        diameters.len(),
        takes.len(),
        takes.len(),
        diameters.len(),
    );
    for nm in diameters {
        text.push_str("    [\n");
        for mm in LENGTHS_MM {
            text.push_str("        [\n");
            rows(nm, mm).iter().for_each(|row| printed(&mut text, row));
            text.push_str("        ],\n");
        }
        text.push_str("    ],\n");
    }
    text.push_str("];\n");
    text
}

#[test]
fn the_table_is_the_generators() {
    let text = text();
    if std::env::var_os("PALPATE_WRITE_GUARD").is_some() {
        std::fs::write(PATH, &text).unwrap();
    }
    let written = std::fs::read_to_string(PATH).unwrap();
    assert!(
        written == text,
        "{PATH} is not what its generator makes: write it anew"
    );
}
