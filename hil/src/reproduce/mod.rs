//! Figures, tables and numbered claims of the thesis, computed from this program: one row each, with an honest mark.

mod compression;
mod felt;
mod frame;
mod hand;
mod illusion;
mod latent;
mod panel;
mod people;
mod row;
pub mod setups;
mod sphere;
mod texture;

pub use row::{Answer, Mark, Row};

/// Every row, in the order of the thesis.
pub fn rows() -> impl Iterator<Item = &'static Row> {
    let chapters: [&'static [Row]; 9] = [
        texture::ROWS,
        latent::ROWS,
        frame::ROWS,
        compression::ROWS,
        sphere::ROWS,
        hand::ROWS,
        illusion::ROWS,
        felt::ROWS,
        people::ROWS,
    ];
    chapters.into_iter().flatten()
}

#[cfg(test)]
mod tests;
