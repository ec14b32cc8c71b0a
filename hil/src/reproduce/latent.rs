//! Rows of the latent space: what the model that learned by reconstruction alone rebuilds, where it puts textures, and
//! what z1 drives.

use palpate_emulators::sensor::surface::spearman;
use palpate_files::{
    DrivenBy, Rated, TextureDecoder, TextureEntry, TextureModel, load_activation, load_textures,
};
use palpate_run::Failure;
use palpate_texture::draw::drawing;
use palpate_texture::explore::{encode, explore};
use palpate_texture::map::{Axis, View, place};
use palpate_texture::rebuild::{Part, Rebuilder};
use serde_json::json;

use super::panel::Panel;
use super::row::{Answer, Mark, Row, broken};
use super::texture::THESIS;

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "claim-3.4.1-error",
        says: "Networks are compared by the mean squared error of what they rebuild of test and cross-validation set.",
        assumed: "Emulated strokes, every test window and one in ten of the others. The thesis prints no error: what agrees is the decoder that ships with its training, within 0.1 %.",
        compute: error,
    },
    Row {
        id: "fig-3.5-A",
        says: "Along z2, catalogue and shoe sole lie between wood and cardboard; along z1, the handkerchief lies far right.",
        assumed: "Twenty emulated strokes over each texture. Far right: among the three that lie furthest towards high ratings.",
        compute: places,
    },
    Row {
        id: "fig-3.5-B",
        says: "z2 goes with rated hardness.",
        assumed: "Ratings: the thesis prints a picture. A rank correlation of 0.7 over the eight textures, of either sign.",
        compute: || goes_with(1, "hardness", |r| r.hardness),
    },
    Row {
        id: "fig-3.5-C",
        says: "z1 goes with rated roughness and friction, less consistently.",
        assumed: "Those of fig-3.5-B; 0.5 is enough.",
        compute: || goes_with(0, "roughness and friction", |r| r.roughness + r.friction),
    },
    Row {
        id: "fig-3.5-D",
        says: "z1 alone sets mean, deviation and frequency of the wires.",
        assumed: "Limits of mu, sigma and f_PWM: those of the activation `assumed`. A scene says `driver = \"z1\"` in [texture].",
        compute: driver,
    },
];

/// Strokes over each texture, as in the thesis.
const STROKES: u32 = 20;
/// Seed of the strokes that the model learned from.
const SEED: u64 = 1;

fn error() -> Result<Answer, Failure> {
    let model = TextureModel::open(THESIS)?;
    let decoder = TextureDecoder::open(THESIS, &model)?;
    let rebuilder = Rebuilder::new(&model, &decoder)?;
    let table = load_textures("thesis")?.value;
    let strokes = explore(&table, STROKES, SEED, |_| ());
    let split = model.split().unwrap_or_default();
    let over = |part: Part| rebuilder.part(&strokes, &split, part);
    let (test, validation) = (over(Part::Test)?, over(Part::Validation)?);
    let unseen = over(Part::Unseen)?;
    let losses = model.metadata().get("losses").map_or("", String::as_str);
    let losses: serde_json::Value = serde_json::from_str(losses).unwrap_or_default();
    let trained = losses["test"].as_f64().unwrap_or(f64::NAN);
    let near = (test.error / trained - 1.0).abs() < 1e-3;
    Ok(Answer::new(
        Mark::new(near, || {
            "the decoder rebuilds other windows than in training".into()
        }),
        format!(
            "{:.5} over test strokes, {:.5} over cross-validation, {:.5} over textures that it never met; training measured {trained:.5} over every test window.",
            test.error, validation.error, unseen.error
        ),
        json!({
            "test": test.error, "validation": validation.error, "unseen": unseen.error,
            "trained": trained, "windows": test.windows,
        }),
    ))
}

/// A stroke in the latent space.
struct Seen {
    entry: TextureEntry,
    /// Mean of every coordinate.
    z: Vec<f64>,
    /// Mean normal reading less that of the first row, counts.
    load: f64,
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    palpate_core::statistics::mean(values).unwrap_or(0.0)
}

/// Every stroke in the latent space, texture by texture, and the map of it.
fn seen() -> Result<(Vec<Seen>, String), Failure> {
    let model = TextureModel::open(THESIS)?;
    let table = load_textures("thesis")?.value;
    let strokes = explore(&table, STROKES, SEED, |_| ());
    let encoded = encode(&model, &strokes, |_| ())?;
    // The coordinates that the thesis shows, whatever the model's file names.
    let [x, y] = [0, 1].map(|coordinate| Axis {
        coordinate,
        sign: 1,
        stands_for: "",
    });
    let view = View { x, y };
    let title = "Figure 3.5-A: strokes in the latent space, with ellipses of one deviation";
    let map = drawing(&place(&encoded, &model, view), view, title).finish();
    let normal = |row: &Vec<_>| mean(row.iter().map(normal_counts));
    let all = strokes
        .iter()
        .zip(encoded)
        .map(|((entry, stroke), own)| Seen {
            entry: (*entry).clone(),
            z: (0..model.latents())
                .map(|c| mean(own.latents.iter().map(|z| f64::from(z[c]))))
                .collect(),
            load: mean(stroke.rows.iter().map(normal)) - stroke.rows.first().map_or(0.0, normal),
        });
    Ok((all.collect(), map))
}

fn normal_counts(reading: &palpate_core::codec::uskin::Reading) -> f64 {
    f64::from(reading.z)
}

/// Mean coordinate of each texture, in the table's order.
fn of_textures(seen: &[Seen], coordinate: usize) -> Vec<(&TextureEntry, f64)> {
    let textures = seen.chunk_by(|a, b| a.entry.name == b.entry.name);
    textures
        .map(|own| (&own[0].entry, mean(own.iter().map(|s| s.z[coordinate]))))
        .collect()
}

/// Rank correlation of a coordinate with ratings over textures.
fn rank(seen: &[Seen], coordinate: usize, rated: fn(&Rated) -> f64) -> f64 {
    let pairs = of_textures(seen, coordinate).into_iter();
    let pairs = pairs.filter_map(|(entry, z)| Some((z, rated(entry.rated.as_ref()?))));
    let (z, ratings): (Vec<f64>, Vec<f64>) = pairs.unzip();
    spearman(&z, &ratings)
}

/// A property of a stroke, by its name.
type Property = (&'static str, fn(&Seen) -> f64);

/// Rank correlations of a coordinate with what a stroke has, over all strokes, the strongest first.
fn follows(seen: &[Seen], coordinate: usize) -> Vec<(&'static str, f64)> {
    let of: [Property; 4] = [
        ("the load", |s| s.load),
        ("friction", |s| s.entry.friction),
        ("relief", |s| s.entry.relief_um),
        ("stiffness", |s| s.entry.stiffness_n_per_mm),
    ];
    let z: Vec<f64> = seen.iter().map(|s| s.z[coordinate]).collect();
    let rank = |(name, of): Property| {
        let with: Vec<f64> = seen.iter().map(of).collect();
        (name, spearman(&z, &with))
    };
    let mut all = of.map(rank).to_vec();
    all.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    all
}

/// A sweep over what the coordinates follow, in words.
fn cause(seen: &[Seen], width: usize) -> String {
    let each = (0..width).map(|c| {
        let all = follows(seen, c).into_iter();
        let all: Vec<String> = all.map(|(name, r)| format!("{name} {r:.2}")).collect();
        format!("z{}: {}", c + 1, all.join(", "))
    });
    let each: Vec<String> = each.collect();
    format!(
        "reconstruction alone ties no coordinate to a surface. Rank correlations over {} strokes: {}",
        seen.len(),
        each.join("; ")
    )
}

fn goes_with(coordinate: usize, what: &str, rated: fn(&Rated) -> f64) -> Result<Answer, Failure> {
    let (seen, _) = seen()?;
    let width = seen.first().map_or(0, |s| s.z.len());
    let along = of_textures(&seen, coordinate);
    let named: Vec<(&str, f64, f64)> = along
        .iter()
        .filter_map(|(entry, z)| Some((entry.name.as_str(), *z, rated(entry.rated.as_ref()?))))
        .collect();
    let panel = Panel {
        title: &format!("Ratings of {what} by z{}", coordinate + 1),
        axes: [&format!("z{}", coordinate + 1), &format!("{what}, assumed")],
        up: None,
    };
    let drawn = panel.places(&named);
    let ranks: Vec<f64> = (0..width).map(|c| rank(&seen, c, rated)).collect();
    let least = if coordinate == 0 { 0.5 } else { 0.7 };
    let own = ranks.get(coordinate).map_or(0.0, |r| r.abs());
    let told: Vec<String> = (1..)
        .zip(&ranks)
        .map(|(n, r)| format!("{r:.2} for z{n}"))
        .collect();
    Ok(Answer::new(
        Mark::new(own >= least, || cause(&seen, width)),
        format!(
            "Rank correlation with {what} over the eight textures: {}.",
            told.join(", ")
        ),
        json!({ "ranks": ranks }),
    )
    .drawn([drawn]))
}

fn places() -> Result<Answer, Failure> {
    let (seen, map) = seen()?;
    let width = seen.first().map_or(0, |s| s.z.len());
    let (first, second) = (of_textures(&seen, 0), of_textures(&seen, 1));
    let at = |all: &[(&TextureEntry, f64)], name: &str| {
        let found = all.iter().find(|(entry, _)| entry.name == name);
        found.map_or(f64::NAN, |(_, z)| *z)
    };
    let [wood, cardboard] = ["wood", "cardboard"].map(|name| at(&second, name));
    let (low, high) = (wood.min(cardboard), wood.max(cardboard));
    let inside = ["catalogue", "shoe-sole"].map(|name| at(&second, name));
    let between = inside.iter().all(|z| (low..=high).contains(z));
    let right = rank(&seen, 0, |r| r.roughness + r.friction).signum();
    let mut order: Vec<(&str, f64)> = first
        .iter()
        .map(|(entry, z)| (entry.name.as_str(), right * z))
        .collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let is_right = order
        .iter()
        .take(3)
        .any(|(name, _)| *name == "handkerchief");
    let names: Vec<&str> = order.iter().map(|(name, _)| *name).collect();
    Ok(Answer::new(
        Mark::new(between && is_right, || cause(&seen, width)),
        format!(
            "z2 of wood {wood:.2} and cardboard {cardboard:.2}, of catalogue {:.2} and shoe sole {:.2}. From right to left along z1: {}.",
            inside[0],
            inside[1],
            names.join(", ")
        ),
        json!({
            "z2": { "wood": wood, "cardboard": cardboard, "catalogue": inside[0], "shoe-sole": inside[1] },
            "z1_from_the_right": names,
        }),
    )
    .drawn([map]))
}

fn driver() -> Result<Answer, Failure> {
    let model = TextureModel::open(THESIS)?;
    let drivers = model.drivers(DrivenBy::First)?;
    let z1 = drivers.roughness;
    let file = load_activation("assumed")?.value;
    let map = file.map(drivers).map_err(broken)?;
    let at = |z: f32| {
        let control = map.control(&[z, 0.9, -0.9]);
        let ms = |time: palpate_core::units::Duration| time.as_micros() as f64 * 1e-3;
        let hz = f64::from(control.rate_mhz) * 1e-3;
        [ms(control.delta_mu), ms(control.sigma), hz]
    };
    let ends = [z1.low, z1.high].map(at);
    let steps = (0..=40).map(|n| z1.low + (z1.high - z1.low) * (n as f32 / 32.0 - 0.125));
    let steps: Vec<f32> = steps.collect();
    let names = ["delta mu [ms]", "sigma [ms]", "f_PWM [Hz]"];
    let panels = (0..).zip(names).map(|(of, name): (usize, &str)| {
        let points: Vec<_> = steps.iter().map(|z| (f64::from(*z), at(*z)[of])).collect();
        let panel = Panel {
            title: &format!("Figure 3.5-D: {name} by z1"),
            axes: ["z1", name],
            up: Some((0.0, points.iter().map(|p| p.1).fold(0.0, f64::max))),
        };
        panel.line(&points)
    });
    let panels: Vec<String> = panels.collect();
    let [smooth, rough] = if z1.falls { [ends[1], ends[0]] } else { ends };
    let limits = [file.delta_mu_ms, file.sigma_ms, file.rate_hz];
    let is_end = |found: [f64; 3], of: fn(&palpate_files::Both) -> f64| {
        let mut pairs = found.iter().zip(&limits);
        pairs.all(|(found, limit)| (found - of(limit)).abs() < 1e-3)
    };
    let all = is_end(smooth, |l| l.smooth) && is_end(rough, |l| l.rough);
    Ok(Answer::new(
        Mark::new(all && z1.coordinate == 0, || "z1 misses an end".into()),
        format!(
            "z1 from {:.2} to {:.2}: delta mu {:.0} to {:.0} ms, sigma {:.0} to {:.0} ms, f_PWM {:.0} to {:.0} Hz, whatever z2 and z3 are.",
            z1.low, z1.high, ends[0][0], ends[1][0], ends[0][1], ends[1][1], ends[0][2], ends[1][2]
        ),
        json!({ "z1": [z1.low, z1.high], "falls": z1.falls, "ends": ends }),
    )
    .drawn(panels))
}
