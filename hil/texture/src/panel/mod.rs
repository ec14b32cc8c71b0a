//! A simulated panel rates textures with the bare finger and on the emulated display, as in the thesis's two studies
//! (figures 3.4 and 3.6). [`palpate_emulators::person::panel`] has the panel's people; here are their stimuli.

pub mod draw;
pub mod stage;
pub mod statistics;
mod trials;

use std::sync::Arc;

use palpate_core::statistics::mean;
use palpate_core::texture::Drivers;
use palpate_emulators::person::panel::{Dimension, Panel, ScaleEnds, TRIALS, bare_finger};
use palpate_emulators::sensor::surface::{Explorer, Habits, Recording, SurfaceTexture};
use palpate_files::{DrivenBy, Setup, TextureEntry, TextureModel, TextureTable};
use palpate_run::Failure;
use palpate_run::plan::surface;
use rayon::prelude::*;
use serde::Serialize;

use crate::explore::{STROKED_HZ, explore_as};
use stage::{Shown, Stage};
use statistics::mann_whitney;
pub use trials::Label;
use trials::{Source, Trial};

/// Dimensions that are rated on a display: hardness cannot be felt there.
pub const ON_DISPLAY: [Dimension; 2] = [Dimension::Roughness, Dimension::Friction];

/// Ratings of one texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Rated {
    /// Name of the texture.
    pub name: String,
    /// Mean roughness of its trials in the model's range, 0 to 1: the drive of (3.2).
    pub driven: f64,
    /// Ratings with the bare finger: hardness, roughness, friction. `None` for a recording, whose surface no panel has
    /// touched.
    pub bare: Option<[Vec<u8>; 3]>,
    /// Ratings on the display: roughness, friction.
    pub display: [Vec<u8>; 2],
    /// Sensation of each trial on the display.
    pub shown: Vec<Shown>,
}

/// One Mann-Whitney U test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Test {
    /// Dimension that was rated.
    pub dimension: &'static str,
    /// Ratings that the display's are compared with: the bare finger's, or another texture's on the display.
    pub against: String,
    /// The display's ratings.
    pub a: Vec<u8>,
    /// Ratings to compare with.
    pub b: Vec<u8>,
    /// U of the display's ratings.
    pub u: f64,
    /// Two-sided probability.
    pub p: f64,
}

impl Rated {
    /// Tests a dimension on the display against other ratings.
    fn test(&self, d: usize, against: &str, other: &[u8]) -> Option<Test> {
        let (u, p) = mann_whitney(&self.display[d], other)?;
        Some(Test {
            dimension: ON_DISPLAY[d].name(),
            against: against.to_owned(),
            a: self.display[d].clone(),
            b: other.to_vec(),
            u,
            p,
        })
    }

    /// The display against the bare finger: roughness, friction.
    pub fn against_bare(&self) -> Vec<Test> {
        let test = |d: usize| self.test(d, "bare finger", &self.bare.as_ref()?[d + 1]);
        (0..2).filter_map(test).collect()
    }

    /// The display against other textures on the display.
    pub fn against(&self, others: &[Self]) -> Vec<Test> {
        let pairs = others.iter().flat_map(|o| [(o, 0), (o, 1)]);
        pairs
            .filter_map(|(other, d)| self.test(d, &other.name, &other.display[d]))
            .collect()
    }
}

/// A panel's ratings.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Sensations at the ends of the scales.
    pub ends: ScaleEnds,
    /// Textures in the table's or the folder's order.
    pub textures: Vec<Rated>,
}

/// State that stays from trial to trial.
struct Session<'a> {
    stage: Stage<'a>,
    panel: Panel,
    ends: ScaleEnds,
    seed: u64,
}

impl<'a> Session<'a> {
    fn new(drivers: Drivers, setup: &'a Setup, seed: u64) -> Result<Self, Failure> {
        let stage = Stage::new(setup, drivers)?;
        Ok(Self {
            ends: stage.ends(seed)?,
            stage,
            panel: Panel::new(seed),
            seed,
        })
    }

    /// Everybody's ratings of one texture.
    fn rate(&self, name: &str, bare: Option<[f64; 3]>, trials: &[Trial]) -> Result<Rated, Failure> {
        let show = |(number, trial): (usize, &Trial)| {
            // Each trial has draws of its own.
            let seed = self.seed.wrapping_add(1 + number as u64);
            let shown = (trial.controls.as_slice(), trial.hardness);
            self.stage.show(shown, stage::SHOWN, seed)
        };
        let shown: Vec<Shown> = trials
            .par_iter()
            .enumerate()
            .map(show)
            .collect::<Result<_, _>>()?;
        let mut display = [Vec::new(), Vec::new()];
        for (number, shown) in (0..).zip(&shown) {
            let ratings = self
                .panel
                .display(name, number, shown.sensation, &self.ends);
            display.iter_mut().zip(ratings).for_each(|(d, r)| d.push(r));
        }
        let bare = bare.map(|felt| {
            let mut bare = [const { Vec::new() }; 3];
            for number in 0..TRIALS {
                let ratings = self.panel.bare(name, number, felt);
                bare.iter_mut().zip(ratings).for_each(|(d, r)| d.push(r));
            }
            bare
        });
        let driven = mean(trials.iter().map(|t| t.driven)).unwrap_or(0.0);
        Ok(Rated {
            name: name.to_owned(),
            driven,
            bare,
            display,
            shown,
        })
    }
}

/// Rates emulated textures: twelve strokes each, pushed through the model. `pairing` gives the surface of each texture
/// to the module that strokes it. `passed` takes the part that is done, 0 to 1.
///
/// # Errors
/// A model or bench that does not fit.
pub fn emulated(
    model: &TextureModel,
    table: &TextureTable,
    pairing: fn(&TextureEntry) -> SurfaceTexture,
    (setup, seed): (&Setup, u64),
    passed: impl Fn(f64),
) -> Result<Study, Failure> {
    model.check_rate(STROKED_HZ)?;
    let mut explorer = Explorer::new(Habits::default(), table.dead_taxel, seed);
    let strokes = explore_as((table, pairing), TRIALS, &mut explorer, |_| ());
    let of_texture = |(entry, strokes): (&TextureEntry, &[(&TextureEntry, Recording)])| {
        let source = |(_, stroke): &_| Source::of_stroke(model, &entry.name, stroke);
        Ok(Shows {
            name: entry.name.clone(),
            bare: Some(bare_finger(&bare(entry))),
            sources: strokes.iter().map(source).collect::<Result<_, _>>()?,
        })
    };
    let all = table.texture.iter().zip(strokes.chunks(TRIALS as usize));
    study(model, all.map(of_texture), (setup, seed), passed)
}

/// Rates recordings, which no finger has touched: on the display only. `passed` hears the part that is done, 0 to 1.
///
/// # Errors
/// A model or bench that does not fit, a recording that cannot be read or is shorter than a window.
pub fn recorded(
    model: &TextureModel,
    labels: &[Label],
    rate_hz: f64,
    (setup, seed): (&Setup, u64),
    passed: impl Fn(f64),
) -> Result<Study, Failure> {
    model.check_rate(rate_hz)?;
    let of_label = |label: &Label| {
        Ok(Shows {
            name: label.name.clone(),
            bare: None,
            sources: label.pieces(model, rate_hz, TRIALS)?,
        })
    };
    study(model, labels.iter().map(of_label), (setup, seed), passed)
}

/// Strokes of one texture for the display, and its properties under the bare finger.
struct Shows {
    name: String,
    bare: Option<[f64; 3]>,
    sources: Vec<Source>,
}

fn study(
    model: &TextureModel,
    all: impl ExactSizeIterator<Item = Result<Shows, Failure>>,
    (setup, seed): (&Setup, u64),
    passed: impl Fn(f64),
) -> Result<Study, Failure> {
    let count = all.len() as f64;
    // The participants wear wires as after a hot pass, where the bench has one.
    let (setup, _) = palpate_run::passed(setup, seed)?;
    let felt = setup.scene.value.texture.as_ref();
    let by = felt.map_or(DrivenBy::Meaning, |felt| felt.driver);
    let session = Session::new(model.drivers(by)?, &setup, seed)?;
    let encoder = Arc::new(model.encoder()?);
    let rate = |(done, shows): (u32, Result<Shows, Failure>)| {
        passed(f64::from(done) / count);
        let shows = shows?;
        let trial = |source| Trial::new(&encoder, &session.stage.map, source);
        let trials: Result<Vec<_>, _> = shows.sources.iter().map(trial).collect();
        session.rate(&shows.name, shows.bare, &trials?)
    };
    Ok(Study {
        textures: (0..).zip(all).map(rate).collect::<Result<_, _>>()?,
        ends: session.ends,
    })
}

/// A surface to the thesis's module, which is covered with gripping tape.
pub fn taped(entry: &TextureEntry) -> SurfaceTexture {
    surface(entry)
}

/// A surface to a module that slides as a finger does.
pub fn bare(entry: &TextureEntry) -> SurfaceTexture {
    SurfaceTexture {
        friction: entry.finger_friction,
        ..surface(entry)
    }
}
