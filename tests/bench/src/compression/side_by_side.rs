//! Contacts of modules side by side on all cores, as the thesis proposes (section 4.6), beside one core in one run.
//!
//! Two ways: every frame's modules are shared out, and cores wait for one another after each frame; or each core has its
//! part of the skin for a whole recording, which only files allow. Contacts are the same bits; identities of the second way
//! count in each part.

use std::ops::Range;
use std::time::Duration;

use palpate_core::contact::{Compressor, Contact, Settings};
use palpate_core::skin::{Axes, FrameError, Layout, RelativeFrame};
use palpate_run::Failure;
use rayon::prelude::*;

use crate::findings::{Findings, NO_ERROR};
use crate::presses::{Presses, counts};
use crate::scenes::skin;
use crate::timing::Race;

const SAMPLES: usize = 100;
const BUDGET: Duration = Duration::from_millis(3000);
/// Differences above which a taxel counts as touched: above the noise of its counts, below the weakest press.
const THRESHOLD: f32 = 20.0;

fn failed(e: impl std::fmt::Display) -> Failure {
    Failure::Input(format!("bench: {e}"))
}

/// A compressor, and frames in which only its part of the skin is touched: the other modules cost next to nothing.
struct Part {
    compressor: Compressor,
    frames: Vec<RelativeFrame>,
}

impl Part {
    /// The part of some of a layout's taxels, of the whole skin's readings.
    fn new(
        layout: &Layout,
        taxels: &Range<usize>,
        readings: &[Vec<[f32; 3]>],
    ) -> Result<Self, Failure> {
        let settings = Settings {
            clusters: 4,
            exponent: 2.0,
            ..Settings::default()
        };
        let frame = |readings: &Vec<[f32; 3]>| {
            let mut own = vec![[0.0; 3]; readings.len()];
            own[taxels.clone()].copy_from_slice(&readings[taxels.clone()]);
            let mut frame = RelativeFrame::new(layout);
            frame.load(&own, Axes::XYZ, THRESHOLD)?;
            Ok(frame)
        };
        let frames: Result<_, FrameError> = readings.iter().map(frame).collect();
        Ok(Self {
            compressor: Compressor::new(layout, settings).map_err(failed)?,
            frames: frames.map_err(failed)?,
        })
    }

    /// Compresses every frame, with its modules on all cores if so wanted; the number of contacts.
    fn compress(&mut self, shared_out: bool) -> usize {
        let mut found = 0;
        let compressor = &mut self.compressor;
        for frame in &self.frames {
            let contacts = match shared_out {
                true => compressor.compress_with(frame, |modules, locate| {
                    modules.par_iter_mut().for_each(locate);
                }),
                false => compressor.compress(frame),
            };
            found += contacts.map_or(0, <[Contact]>::len);
        }
        found
    }

    /// The contacts of the last frame without identities, which count in each part.
    fn last(&self) -> impl Iterator<Item = Contact> {
        self.compressor
            .contacts()
            .iter()
            .map(|c| Contact { id: 0, ..*c })
    }
}

/// Compares one core with all cores on a skin, in turn.
fn case(findings: &mut Findings, name: &str, touched: usize, frames: usize) -> Result<(), Failure> {
    let layout = skin(name)?;
    let rest = counts(&layout, 0, None);
    let readings: Vec<Vec<[f32; 3]>> = (0..frames)
        .map(|frame| {
            let now = counts(&layout, frame, Some(Presses::EveryModule(touched)));
            let difference = |(now, rest): (&[u16; 3], &[u16; 3])| {
                std::array::from_fn(|axis| f32::from(now[axis]) - f32::from(rest[axis]))
            };
            now.iter().zip(&rest).map(difference).collect()
        })
        .collect();
    let modules = layout.modules().len();
    let cores = rayon::current_num_threads().min(modules);
    let start = |core: usize| layout.starts()[core * modules / cores] as usize;
    let whole = 0..layout.taxels();
    let mut one = Part::new(&layout, &whole, &readings)?;
    let mut shared = Part::new(&layout, &whole, &readings)?;
    let mut parts = (0..cores)
        .map(|core| Part::new(&layout, &(start(core)..start(core + 1)), &readings))
        .collect::<Result<Vec<_>, _>>()?;
    let found = one.compress(false);
    let same = found > 0
        && found == shared.compress(true)
        && one.compressor.contacts() == shared.compressor.contacts()
        && found
            == parts
                .iter_mut()
                .map(|part| part.compress(false))
                .sum::<usize>()
        && one.last().eq(parts.iter().flat_map(Part::last));
    if !same {
        return Err(failed(format!(
            "{name}: other contacts on all cores than on one"
        )));
    }
    let mut race = Race::default();
    race.enter(|| one.compress(false));
    race.enter(|| shared.compress(true));
    race.enter(|| {
        let each = parts.par_iter_mut().map(|part| part.compress(false));
        each.sum::<usize>()
    });
    let samples = race.run(SAMPLES, BUDGET);
    // On a machine with other work, half of the samples lack a core.
    let quick = |of: usize| samples[of].quantile(0.05) / frames as f64;
    let [alone, frame, recording] = [0, 1, 2].map(quick);
    let case = format!("modules side by side, {name}, {touched} in contact, K=4 a module");
    findings.row(&case, "one core", NO_ERROR, alone);
    findings.row(&case, "modules of each frame on all cores", NO_ERROR, frame);
    findings.row(
        &case,
        "a part of the skin for each core",
        NO_ERROR,
        recording,
    );
    findings.words.push(format!(
        "{case}: by the quickest twentieth of samples {:.2} times as fast with each frame's modules on {cores} cores, {:.2} times with a part of the skin for each.",
        alone / frame,
        alone / recording
    ));
    Ok(())
}

/// Measures a hand, a body and a skin of a million taxels.
///
/// # Errors
/// A skin that cannot be made, or contacts that depend on the number of cores.
pub fn measure(findings: &mut Findings) -> Result<(), Failure> {
    case(findings, "allegro", 125, 400)?;
    case(findings, "icub-body", 1224, 400)?;
    case(findings, "million", 100_000, 4)
}
