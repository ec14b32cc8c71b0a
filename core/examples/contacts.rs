//! Compression alone: rows of taxel counts in, contacts with place, intensity and identity out.

#![allow(clippy::print_stdout)] // its output is the point

use std::error::Error;

use palpate_core::contact::{Compressor, Settings};
use palpate_core::skin::{Baseline, BaselinePhase, BaselineSettings, Layout, Module, Scan};
use palpate_core::units::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let layout = Layout::single(Module::grid("pad", 4, 4, 4.7)?)?; // 4.7 mm apart
    let mut baseline = Baseline::new(&layout, BaselineSettings::default())?;
    let mut compressor = Compressor::new(&layout, Settings::default())?;
    let (mut scan, mut frame) = (Scan::new(&layout), baseline.frame(&layout));
    for row in 0..120_u64 {
        // At rest for half a second, then a touch that moves across two taxels.
        let mut counts = [[32_768, 32_768, 40_000]; 16];
        if let Some(step) = row.checked_sub(100) {
            counts[5][2] += 600 - 30 * step as u16;
            counts[6][2] += 30 * step as u16;
        }
        scan.load(Instant::from_micros(10_000 * row), &counts)?;
        if baseline.phase() != BaselinePhase::Ready && baseline.feed(&scan) != BaselinePhase::Ready
        {
            continue; // the skin at rest is not known yet
        }
        baseline.advance(&scan, &mut frame)?;
        for contact in compressor.compress(&frame)? {
            let (place, counts) = (contact.place, contact.intensity);
            println!(
                "{:>4} ms  contact {} at {:5.2}, {:5.2} mm, {counts:5.1} counts",
                10 * row,
                contact.id,
                place.x,
                place.y
            );
        }
    }
    Ok(())
}
