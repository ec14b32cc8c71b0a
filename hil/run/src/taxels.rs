//! The raw readings of a scene's emulated skin, as a recording of them would be.

use palpate_core::units::Instant;
use palpate_files::Setup;

use crate::failure::Failure;
use crate::plan;
use crate::policy::TICK;
use crate::replay::TaxelTable;
use crate::runner::{part, scene_end};
use crate::skin;
use crate::skin_end::{SkinEnd, Tap};
use crate::tape::Tape;

/// One table per module, as long as the scene. The tables have the scene's touches and noise, without its faults.
/// `passed` takes the part that is done, 0 to 1.
///
/// # Errors
/// [`Failure::Input`] for a layout whose modules no emulated board can carry.
pub fn taxels(setup: &Setup, seed: u64, passed: impl Fn(f64)) -> Result<Vec<TaxelTable>, Failure> {
    let layout = plan::layout(&setup.sensor.value)?;
    let axes = usize::from(setup.sensor.value.axes);
    let active: Vec<Vec<usize>> = layout
        .modules()
        .iter()
        .map(|m| (0..m.points().len()).filter(|&t| m.active()[t]).collect())
        .collect();
    let table = |taxels: &Vec<usize>| TaxelTable {
        time_us: Vec::new(),
        counts: Vec::new(),
        columns: taxels.len() * axes,
    };
    let mut tables: Vec<TaxelTable> = active.iter().map(table).collect();
    let into = (&active[..], &mut tables[..], axes);
    if skin::is_array(setup) {
        read(setup, &mut skin::scene(setup, seed, None)?, into, passed)?;
    } else {
        let boards = Tape::new(skin::emulated(setup, &layout, seed)?);
        let mut source = skin::source(setup, &layout, Tap::new(boards, false));
        read(setup, &mut source, into, passed)?;
    }
    Ok(tables)
}

/// Fills the tables with readings of so many axes until the scene ends.
fn read(
    setup: &Setup,
    source: &mut dyn SkinEnd,
    (active, tables, axes): (&[Vec<usize>], &mut [TaxelTable], usize),
    passed: impl Fn(f64),
) -> Result<(), Failure> {
    let end = scene_end(setup);
    let mut now = Instant::ZERO;
    while now < end {
        source.advance_to(now);
        let read = source.scans(now, &mut |scan| {
            let module = usize::from(scan.module);
            let (table, taxels) = (&mut tables[module], &active[module]);
            table.time_us.push(scan.at.as_micros());
            for &taxel in taxels {
                // One axis is the normal one, the last of three.
                table.counts.extend(&scan.counts[taxel][3 - axes..]);
            }
        });
        read.map_err(|e| Failure::Device(format!("sensor bus: {e}")))?;
        passed(part(now, end));
        now += TICK;
    }
    Ok(())
}

#[cfg(test)]
#[path = "taxels_tests.rs"]
mod tests;
