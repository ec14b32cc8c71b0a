//! Rows of chapter 4: both stages of K-means, from seeds to levels.

use palpate_core::contact::kmeans::weighted_mean;
use palpate_core::contact::{
    Compressor, Contact, KMeans, LevelTable, Levels, Points, Settings, Stop, VectorTable,
};
use palpate_core::random::RandomStream;
use palpate_core::skin::{Axes, RelativeFrame};
use palpate_core::units::Point;
use palpate_run::Failure;
use serde_json::json;

use super::frame::{Sequence, module};
use super::row::{Answer, Mark, Row, broken};

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "eq-4.4",
        says: "K-means++ draws K_C seeds that lie far from one another from the taxels in contact.",
        assumed: "The twelve taxels of eq-4.5 to 4.8, K_C = 2, 200 draws.",
        compute: seeds,
    },
    Row {
        id: "eq-4.5-to-4.8",
        says: "Taxels go to the nearest centroid, centroids to the weighted mean of theirs, until half the summed moves are at most zeta_C.",
        assumed: "zeta_C = 0.001 mm: the thesis prints none. Two presses on twelve taxels, weights in counts.",
        compute: means,
    },
    Row {
        id: "eq-4.7-as-printed",
        says: "A centroid is 1/N times the sum of the places of its N taxels, each times its weight ||s||^p.",
        assumed: "The taxels of eq-4.5 to 4.8, as one cluster; p = 1.",
        compute: printed,
    },
    Row {
        id: "eq-4.9",
        says: "The intensity at a contact is found by simple interpolation.",
        assumed: "Bilinear between the four taxels around the contact; the thesis names no rule.",
        compute: intensity,
    },
    Row {
        id: "eq-4.10-to-4.14",
        says: "A second K-means finds K_I intensity levels.",
        assumed: "Thirty intensities, K_I = 4. Here the levels are the exact optimum, not one K-means run.",
        compute: levels,
    },
    Row {
        id: "eq-4.15",
        says: "A contact gets the intensity of its nearest level.",
        assumed: "The levels of eq-4.10 to 4.14; the lower of two equally near.",
        compute: nearest,
    },
    Row {
        id: "eq-4.9-to-4.15-vectors",
        says: "Intensities are vectors of a reading's axes: interpolated, clustered and replaced by the nearest of K_I vectors.",
        assumed: "Sixteen taxels under a press with shear, K_C = 10, K_I = 3; each axis as in eq-4.9. The best of sixteen K-means runs; levels count from the weakest. The thesis itself took magnitudes.",
        compute: vectors,
    },
    Row {
        id: "claim-4.6-jnd",
        says: "Levels by just noticeable differences would leave out steps that nobody notices.",
        assumed: "Weber fractions of 0.1 to 0.3 over 20 dB; the thesis prints none and did not build it.",
        compute: noticeable,
    },
];

/// Twelve taxels of the module under two presses.
struct Taxels {
    x: Vec<f32>,
    y: Vec<f32>,
    w: Vec<f32>,
}

impl Taxels {
    fn new() -> Result<Self, Failure> {
        let layout = module()?;
        let places = &layout.modules()[0].points()[..12];
        let near = |x: f32, y: f32, at: [f32; 2]| {
            let (dx, dy) = (x - at[0], y - at[1]);
            (-(dx * dx + dy * dy) / 15.0).exp()
        };
        let weight = |x: f32, y: f32| {
            (300.0 * near(x, y, [-5.0, 5.5]) + 200.0 * near(x, y, [6.0, 0.0])).round() + 20.0
        };
        Ok(Self {
            x: places.iter().map(|p| p.x).collect(),
            y: places.iter().map(|p| p.y).collect(),
            w: places.iter().map(|p| weight(p.x, p.y)).collect(),
        })
    }

    fn points(&self) -> Points<'_> {
        Points {
            x: &self.x,
            y: &self.y,
            w: &self.w,
        }
    }
}

fn seeds() -> Result<Answer, Failure> {
    let taxels = Taxels::new()?;
    let mut kmeans = KMeans::new(12, 2);
    let mut stream = RandomStream::new(4, "hil reproduce");
    let (draws, mut sum) = (200_u32, 0.0);
    for _ in 0..draws {
        kmeans.seed(taxels.points(), 2, &mut stream);
        let seeds: Vec<(f32, f32)> = kmeans.centroids().collect();
        let (dx, dy) = (seeds[0].0 - seeds[1].0, seeds[0].1 - seeds[1].1);
        sum += f64::from(dx.hypot(dy));
    }
    let apart = sum / f64::from(draws);
    let mut pairs = 0.0;
    for i in 0..12 {
        for j in 0..12 {
            let (dx, dy) = (taxels.x[i] - taxels.x[j], taxels.y[i] - taxels.y[j]);
            pairs += f64::from(dx.hypot(dy)) / 144.0;
        }
    }
    Ok(Answer::new(
        Mark::new(apart > pairs, || {
            "seeds are no further apart than any two taxels".into()
        }),
        format!(
            "Seeds are {apart:.1} mm apart in the mean, two taxels drawn evenly {pairs:.1} mm."
        ),
        json!({ "draws": draws, "seeds_apart_mm": apart, "any_apart_mm": pairs }),
    ))
}

fn means() -> Result<Answer, Failure> {
    let taxels = Taxels::new()?;
    let begin = [(taxels.x[0], taxels.y[0]), (taxels.x[11], taxels.y[11])];
    let mut kmeans = KMeans::new(12, 2);
    kmeans.set_centroids(begin.into_iter());
    let stop = Stop {
        tolerance: Settings::default().tolerance,
        max_iterations: 32,
    };
    let end = kmeans.solve(taxels.points(), stop);
    let found: Vec<(f32, f32)> = kmeans.centroids().collect();
    Ok(Answer::new(
        Mark::new(end.converged, || "32 iterations are too few".into()),
        format!(
            "({:.2}, {:.2}) and ({:.2}, {:.2}) mm after {} iterations.",
            found[0].0, found[0].1, found[1].0, found[1].1, end.iterations
        ),
        json!({
            "x_mm": taxels.x, "y_mm": taxels.y, "weights": taxels.w, "seeds_mm": begin,
            "zeta_c_mm": stop.tolerance, "centroids_mm": found, "assigned": kmeans.assigned(),
        }),
    ))
}

fn printed() -> Result<Answer, Failure> {
    let taxels = Taxels::new()?;
    let as_printed = |scale: f64| {
        let n = taxels.w.len() as f64;
        let sum = |v: &[f32]| -> f64 {
            let each = v.iter().zip(&taxels.w);
            each.map(|(v, w)| f64::from(*v) * f64::from(*w) * scale)
                .sum::<f64>()
                / n
        };
        (sum(&taxels.x), sum(&taxels.y))
    };
    let here = weighted_mean(taxels.points());
    let mean = taxels.w.iter().map(|w| f64::from(*w)).sum::<f64>() / taxels.w.len() as f64;
    let sweep = [1.0, 0.1, 0.01, 1.0 / mean].map(|scale| (scale, as_printed(scale)));
    let told: Vec<String> = sweep
        .iter()
        .map(|(scale, at)| format!("x {scale:.4}: ({:.2}, {:.2})", at.0, at.1))
        .collect();
    let cause = format!(
        "the sum of weights is missing in print. Weights {} mm; only weights of mean 1 give a place on the module",
        told.join(", ")
    );
    let raw = sweep[0].1;
    Ok(Answer::new(
        Mark::Differs(cause),
        format!(
            "The sum over the sum of weights: ({:.2}, {:.2}) mm. As printed, ({:.0}, {:.0}) mm.",
            here.0, here.1, raw.0, raw.1
        ),
        json!({
            "x_mm": taxels.x, "y_mm": taxels.y, "weights": taxels.w,
            "centroid_mm": here, "as_printed_mm": raw,
        }),
    ))
}

fn intensity() -> Result<Answer, Failure> {
    let sequence = Sequence::new()?;
    let (_, frame) = sequence.pressed()?;
    let mut compressor = Compressor::new(sequence.layout(), Settings::default()).map_err(broken)?;
    let contacts = compressor.compress(&frame).map_err(broken)?;
    let contact = contacts.first().ok_or_else(|| broken("no contact"))?;
    Ok(Answer::new(
        Mark::Agrees,
        format!(
            "{:.1} counts at ({:.2}, {:.2}) mm.",
            contact.intensity, contact.place.x, contact.place.y
        ),
        json!({
            "magnitude": frame.magnitude(), "pitch_mm": super::frame::PITCH_MM,
            "place_mm": [contact.place.x, contact.place.y], "intensity": contact.intensity,
        }),
    ))
}

/// Thirty intensities, counts.
fn intensities() -> Vec<f32> {
    let mut stream = RandomStream::new(3, "hil reproduce");
    let one = |n: u8| (f64::from(n % 4) * 90.0 + 60.0 * stream.uniform()).round() as f32 + 20.0;
    (0..30).map(one).collect()
}

fn levels() -> Result<Answer, Failure> {
    let all = intensities();
    let table = LevelTable::from_intensities(&all, 4).map_err(broken)?;
    let told: Vec<String> = table.values().iter().map(|v| format!("{v:.1}")).collect();
    Ok(Answer::new(
        Mark::Agrees,
        format!("Levels at {} counts.", told.join(", ")),
        json!({ "intensities": all, "k_i": 4, "levels": table.values() }),
    ))
}

fn nearest() -> Result<Answer, Failure> {
    let all = intensities();
    let table = LevelTable::from_intensities(&all, 4).map_err(broken)?;
    let given: Vec<f32> = all
        .iter()
        .map(|v| table.values()[usize::from(table.level(*v)) - 1])
        .collect();
    let off = all.iter().zip(&given).map(|(v, g)| (v - g).abs());
    let most = off.fold(0.0, f32::max);
    Ok(Answer::new(
        Mark::Agrees,
        format!("Thirty intensities become four; the largest change is {most:.1} counts."),
        json!({ "intensities": all, "levels": table.values(), "compressed": given }),
    ))
}

fn vectors() -> Result<Answer, Failure> {
    let layout = module()?;
    // Friction pulls outwards from the middle of the press, most at its rim.
    let reading = |p: &Point| {
        let (dx, dy) = (p.x - 1.0, p.y - 3.0);
        let press = (-(dx * dx + dy * dy) / 60.0).exp();
        [
            60.0 * dx.abs() * press,
            25.0 * dy.abs() * press,
            400.0 * press,
        ]
        .map(f32::round)
    };
    let readings: Vec<[f32; 3]> = layout.modules()[0].points().iter().map(reading).collect();
    let mut frame = RelativeFrame::new(&layout);
    frame.load(&readings, Axes::XYZ, 0.0).map_err(broken)?;
    let found = |vectors: bool| -> Result<Vec<Contact>, Failure> {
        let settings = Settings {
            clusters: 10,
            levels: Levels::Dynamic(3),
            vectors,
            ..Settings::default()
        };
        let mut compressor = Compressor::new(&layout, settings).map_err(broken)?;
        Ok(compressor.compress(&frame).map_err(broken)?.to_vec())
    };
    let (contacts, plain) = (found(true)?, found(false)?);
    let all: Vec<[f32; 3]> = contacts.iter().map(|c| c.vector).collect();
    let table = VectorTable::from_intensities(&all, 3).map_err(broken)?;
    let told = table
        .values()
        .iter()
        .map(|v| format!("({:.0}, {:.0}, {:.0})", v[0], v[1], v[2]));
    let pairs = contacts.iter().zip(&plain);
    let others = pairs.filter(|(c, plain)| c.level != plain.level).count();
    let off = |c: &Contact, level: &[f32; 3]| -> f32 {
        let axes = level.iter().zip(c.vector);
        axes.map(|(l, v)| (l - v) * (l - v)).sum()
    };
    let is_nearest = |c: &Contact| {
        let own = table.values().get(usize::from(c.level) - 1);
        own.is_some_and(|own| table.values().iter().all(|l| off(c, own) <= off(c, l)))
    };
    Ok(Answer::new(
        Mark::new(contacts.iter().all(is_nearest), || {
            "a contact has another level than the nearest one".into()
        }),
        format!(
            "Levels at {} counts; {others} of ten contacts get another level than by magnitude.",
            told.collect::<Vec<_>>().join(", ")
        ),
        json!({
            "readings": readings, "pitch_mm": super::frame::PITCH_MM, "k_i": 3, "vectors": all,
            "places_mm": contacts.iter().map(|c| [c.place.x, c.place.y]).collect::<Vec<_>>(),
            "levels": table.values(), "level": contacts.iter().map(|c| c.level).collect::<Vec<_>>(),
        }),
    ))
}

fn noticeable() -> Result<Answer, Failure> {
    let steps = |weber: f32| -> Result<usize, Failure> {
        let table = LevelTable::weber(20.0, 200.0, weber).map_err(broken)?;
        Ok(table.values().len())
    };
    let fractions = [0.1_f32, 0.2, 0.3];
    let found = fractions.map(steps);
    let [fine, middle, coarse] = found;
    let found = [fine?, middle?, coarse?];
    Ok(Answer::new(
        Mark::Unknown("the thesis only proposes it".into()),
        format!(
            "{}, {} and {} levels for Weber fractions of 0.1, 0.2 and 0.3; the thesis takes K_I = 10 at most.",
            found[0], found[1], found[2]
        ),
        json!({ "lowest": 20.0, "highest": 200.0, "fractions": fractions, "levels": found }),
    ))
}
