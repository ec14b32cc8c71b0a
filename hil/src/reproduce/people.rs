//! Rows of the studies: what a protocol can give, and what only people can.

use palpate_core::statistics::mean;
use palpate_emulators::person::panel::Dimension;
use palpate_files::{Overrides, Setup, TaskKind, TextureModel, load_protocol, load_textures};
use palpate_run::Failure;
use palpate_texture::panel::draw::drawing;
use palpate_texture::panel::{self, Study};
use serde_json::json;

use super::row::{Answer, Mark, Row};

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "claim-3.4.2-trials",
        says: "Four subjects rate eight textures three times each.",
        assumed: "Nothing.",
        compute: ratings,
    },
    Row {
        id: "claim-5.4-trials",
        says: "Two users draw four trajectories five times each: 40 trials.",
        assumed: "Nothing.",
        compute: drawings,
    },
    Row {
        id: "fig-3.4",
        says: "Hardness is rated most alike, friction least, among real textures.",
        assumed: "A simulated panel of four under the bare finger; each person's bias is largest for friction.",
        compute: bare,
    },
    Row {
        id: "fig-3.6-A",
        says: "Roughness on the display is rated roughly as the real textures', but for the handkerchief's, which is rated higher.",
        assumed: "The same panel on the emulated display, by `thesis` and z1 and by `default`; different is p < 0.05 by Mann and Whitney, as in the thesis.",
        compute: || display(Dimension::Roughness),
    },
    Row {
        id: "fig-3.6-B",
        says: "Friction on the display is rated roughly as the real textures', but for the handkerchief's, which is rated higher.",
        assumed: "Those of fig-3.6-A.",
        compute: || display(Dimension::Friction),
    },
];

/// Ratings of the eight textures by the panel of `hil texture panel MODEL --driver DRIVER`.
fn panel(model: &str, driver: &str) -> Result<Study, Failure> {
    let model = TextureModel::open(model)?;
    let mut overrides = Overrides::default();
    overrides.scene("hil reproduce", "texture.driver", driver);
    let setup = Setup::load("texture-wood", "emulated")?.with(&overrides)?;
    let table = load_textures("thesis")?.value;
    panel::emulated(&model, &table, panel::taped, (&setup, PANEL), |_| ())
}

/// Seed of the panel, that of `hil texture panel`.
const PANEL: u64 = 2;

/// Standard deviation of ratings.
fn deviation(ratings: &[u8]) -> f64 {
    let count = ratings.len().max(2) as f64;
    let mean = ratings.iter().map(|r| f64::from(*r)).sum::<f64>() / count;
    let squares = ratings.iter().map(|r| (f64::from(*r) - mean).powi(2));
    (squares.sum::<f64>() / (count - 1.0)).sqrt()
}

fn bare() -> Result<Answer, Failure> {
    let mut study = panel("default", "meaning")?;
    // The first study has the finger alone.
    for rated in &mut study.textures {
        rated.display = [const { Vec::new() }; 2];
        rated.shown.clear();
    }
    let panels = Dimension::ALL.map(|dimension| {
        let title = format!("Figure 3.4: {} of real textures", dimension.name());
        drawing(&study, &[dimension], &title).finish()
    });
    let mut spread = [0.0; 3];
    for rated in &study.textures {
        let ratings = rated.bare.iter().flatten();
        let each = ratings.map(|r| deviation(r) / study.textures.len() as f64);
        spread
            .iter_mut()
            .zip(each)
            .for_each(|(sum, one)| *sum += one);
    }
    Ok(Answer::new(
        Mark::Unknown("people rate, and none has taken part here".into()),
        format!(
            "Ratings of a texture deviate by {:.2} points for hardness, {:.2} for roughness and {:.2} for friction: ratings end at 1 and 6, and surfaces lie at different distances from these.",
            spread[0], spread[1], spread[2]
        ),
        json!({ "hardness_roughness_friction": spread }),
    )
    .drawn(panels))
}

/// Textures whose ratings of a dimension differ between display and finger, each with `higher` or `lower` on the display.
fn differing(study: &Study, dimension: usize) -> Vec<String> {
    let middle = |ratings: &[u8]| mean(ratings.iter().map(|r| f64::from(*r)));
    let textures = study.textures.iter().filter_map(|rated| {
        let tests = rated.against_bare();
        let test = tests.get(dimension).filter(|test| test.p < 0.05)?;
        let is_higher = middle(&test.a) > middle(&test.b);
        let word = if is_higher { "higher" } else { "lower" };
        Some(format!("{} {word}", rated.name))
    });
    textures.collect()
}

fn display(of: Dimension) -> Result<Answer, Failure> {
    let (dimension, name) = (usize::from(of == Dimension::Friction), of.name());
    let told = |names: &[String]| match names {
        [] => "none".to_owned(),
        names => names.join(", "),
    };
    let studies = [panel("thesis", "z1")?, panel("default", "meaning")?];
    let [thesis, default] = [0, 1].map(|n| differing(&studies[n], dimension));
    let models = studies.iter().zip(["`thesis` and z1", "`default`"]);
    let panels = models.map(|(study, model)| {
        let title = format!("Figure 3.6: {name} on the display by {model}");
        drawing(study, &[of], &title).finish()
    });
    let panels: Vec<String> = panels.collect();
    Ok(Answer::new(
        Mark::Unknown("people rate, and none has taken part here".into()),
        format!(
            "Rated otherwise for {name} on the display: by `thesis` and z1 {}; by `default` {}.",
            told(&thesis),
            told(&default)
        ),
        json!({ "thesis": thesis, "default": default }),
    )
    .drawn(panels))
}

/// Trials of one participant in a task of a protocol.
fn trials(protocol: &str, task: TaskKind) -> Result<u64, Failure> {
    let file = load_protocol(protocol)?.value;
    let own = file.tasks().into_iter().filter(|(kind, ..)| *kind == task);
    Ok(own
        .map(|(_, things, each)| things as u64 * u64::from(each))
        .sum())
}

fn ratings() -> Result<Answer, Failure> {
    let each = trials("textures-by-hand", TaskKind::Rating)?;
    Ok(Answer::new(
        Mark::new(each == 24, || "the protocol has other trials".into()),
        format!(
            "Protocol `textures-by-hand`: {each} trials for each participant, {} for four.",
            4 * each
        ),
        json!({ "trials": each }),
    ))
}

fn drawings() -> Result<Answer, Failure> {
    let each = trials("felt-paths", TaskKind::Drawing)?;
    Ok(Answer::new(
        Mark::new(2 * each == 40, || "the protocol has other trials".into()),
        format!(
            "Protocol `felt-paths`: {each} trials for each participant, {} for two.",
            2 * each
        ),
        json!({ "trials": each }),
    ))
}
