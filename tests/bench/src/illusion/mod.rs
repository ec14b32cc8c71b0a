//! Illusions: every law on every array by both centroids - where it is felt, how even, how often nothing is
//! - and what an onset costs. Figure 5.5 of the thesis, for (5.2) and for the default law.

mod figure;
pub mod laws;

use std::time::Duration;

use palpate_core::illusion::{
    Display, DisplayWire, IllusionModel, Mixer, ModelSettings, ShapeChoice, Sharing, Target, build,
};
use palpate_core::units::{Board, Channel, Milliamps, Point};
use palpate_emulators::person::channels::Person;
use palpate_run::Failure;
use palpate_tests::felt::{PATHS, PathScore, Worn, current, path_on, person};

use crate::findings::{Error, Findings, NO_ERROR};
use crate::plot::{Axis, Mark, Plot, Series};
use crate::scenes::display;
use crate::timing::Race;

/// The arrays, by layout.
const ARRAYS: [&str; 3] = ["three-in-line", "thimble-8", "tactile-brush-4x3"];
/// Wires of the largest driver unit: 16 boards of 8.
const MANY: usize = 128;
/// Contacts of a sample.
const TARGETS: u8 = 255;

/// Results of a law over the four paths on one array.
#[derive(Clone, Copy, Debug, Default)]
struct Total {
    /// Mean square of the felt error, by energy and by amplitude centroid, mm2, and onsets.
    squares: [f64; 2],
    onsets: [u64; 2],
    dip_db: f64,
    peak_db: f64,
}

impl Total {
    fn add(&mut self, score: &PathScore) {
        for (k, felt) in score.felt.iter().enumerate() {
            if let Some(errors) = felt.errors {
                let mm = errors.rmse_um as f64 * 1e-3;
                self.squares[k] += mm * mm * errors.count as f64;
                self.onsets[k] += errors.count;
            }
        }
        self.dip_db = self.dip_db.min(score.energy_db.0);
        self.peak_db = self.peak_db.max(score.energy_db.1);
    }

    /// Root mean square of the felt error by one of the centroids, mm; NaN where nothing was felt.
    fn rmse(&self, perceiver: usize) -> f64 {
        (self.squares[perceiver] / self.onsets[perceiver] as f64).sqrt()
    }
}

/// A law by name with its settings, as it stands in a table.
struct Method {
    name: String,
    settings: ModelSettings,
}

impl Method {
    fn new(name: &str, model: IllusionModel, shape: ShapeChoice) -> Self {
        Self {
            name: name.into(),
            settings: ModelSettings {
                model,
                shape,
                ..ModelSettings::default()
            },
        }
    }
}

/// Every law; the default one is called `default`, (5.2) also stands with flat midpoints.
fn methods() -> Vec<Method> {
    let name = |model: IllusionModel| match model == IllusionModel::default() {
        true => "default",
        false => model.name(),
    };
    let laws = IllusionModel::ALL.into_iter();
    let mut methods: Vec<Method> = laws
        .map(|model| Method::new(name(model), model, ShapeChoice::Model))
        .collect();
    let flat = Method::new("phantom, flat", IllusionModel::Phantom, ShapeChoice::Flat);
    methods.insert(1, flat);
    methods
}

/// Measures everything.
///
/// # Errors
/// [`Failure`] where a shipped file cannot be read.
pub fn measure() -> Result<Findings, Failure> {
    let (person, drive) = (person()?, current("thesis")?);
    let mut found = Findings::new("illusion");
    for name in ARRAYS {
        on_array(&mut found, name, person, drive)?;
    }
    costs(&mut found, "cost, 8 wires", &display("thimble-8")?)?;
    costs(&mut found, "cost, 128 wires", &many()?)?;
    trade_off(&mut found, person, drive)?;
    found.words.push(format!(
        "default is {}. Here every law has as many pulses on each wire, without guard and heat: `laws` has both. \
         Errors are of the place, felt or not, over the four sphere paths at the thesis's drive (180 mW, from which 1.97 A follows; no intensity), \
         contacts inside the array. A cost is that of one contact at an onset.",
        IllusionModel::default().name(),
    ));
    found.words.push(
        "The wires are taut, their bow and the person assumed (fixtures/persons/typical.toml): nothing is measured."
            .into(),
    );
    found.figures.push(figure::five_five()?);
    Ok(found)
}

/// Sixteen columns of eight wires, 9 mm apart.
pub fn many() -> Result<Display, Failure> {
    let wire = |i: usize| DisplayWire {
        place: Point::new(9.0 * (i / 8) as f32, 9.0 * (i % 8) as f32),
        board: Board((i / 8) as u8),
        channel: Channel((i % 8) as u8),
    };
    let wires: Vec<DisplayWire> = (0..MANY).map(wire).collect();
    Display::new(&wires).map_err(|e| Failure::Input(e.to_string()))
}

/// The four paths on a display.
fn paths(display: &Display) -> Result<Vec<Vec<Point>>, Failure> {
    PATHS.iter().map(|scene| path_on(scene, display)).collect()
}

/// Computes the results of a law over the paths.
fn total(
    display: &Display,
    settings: &ModelSettings,
    paths: &[Vec<Point>],
    (person, drive): (Person, Milliamps),
) -> Result<Total, Failure> {
    let worn = Worn::new(display, settings, person, drive);
    let mut worn = worn.map_err(|e| Failure::Input(e.to_string()))?;
    let mut total = Total::default();
    for path in paths {
        total.add(&worn.score(path)?);
    }
    Ok(total)
}

/// Figure that is read off a law's total.
type Value = fn(&Total) -> Error;

fn on_array(
    found: &mut Findings,
    name: &str,
    person: Person,
    drive: Milliamps,
) -> Result<(), Failure> {
    let display = display(name)?;
    let paths = paths(&display)?;
    // A law that does not fit this array (three-nearest on a line) has no row.
    let fits = methods().into_iter().filter_map(|method| {
        let total = total(&display, &method.settings, &paths, (person, drive));
        total.ok().map(|total| (method, total))
    });
    let results: Vec<(Method, Total)> = fits.collect();
    let values: [(&str, Value); 4] = [
        ("energy centroid", |t| (t.rmse(0), "mm RMSE")),
        ("amplitude centroid", |t| (t.rmse(1), "mm RMSE")),
        ("dip", |t| (t.dip_db, "dB")),
        ("peak", |t| (t.peak_db, "dB")),
    ];
    for (what, value) in values {
        for (method, total) in &results {
            let case = format!("{name}: {what}");
            found.row(&case, &method.name, value(total), f64::NAN);
        }
    }
    Ok(())
}

/// Costs of one contact at an onset by every law: at most 0.3 us for eight wires, 5 us for 128.
fn costs(found: &mut Findings, case: &str, display: &Display) -> Result<(), Failure> {
    let bounds = display.bounds();
    let (width, height) = (bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y);
    // Places that no branch predictor learns: golden-ratio steps over the whole display.
    let targets: Vec<Target> = (0..TARGETS)
        .map(|k| {
            let part = |step: f32| (f32::from(k) * step).fract();
            let (x, y) = (part(0.618_034), part(0.754_877_7));
            Target {
                place: Point::new(bounds.min.x + x * width, bounds.min.y + y * height),
                weight: 1.0,
            }
        })
        .collect();
    let methods = methods();
    let mut race = Race::default();
    for method in &methods {
        let law = build(display, &method.settings).map_err(|e| Failure::Input(e.to_string()))?;
        let mut mixer = Mixer::new(law, Sharing::Strongest, display.wires().len());
        let targets = &targets;
        race.enter(move || {
            targets
                .iter()
                .map(|t| mixer.activate(std::slice::from_ref(t)).iter().sum::<f32>())
                .sum::<f32>()
        });
    }
    let samples = race.run(200, Duration::from_millis(500));
    for (method, samples) in methods.iter().zip(samples) {
        let us = samples.median() / f64::from(TARGETS);
        found.row(case, &method.name, NO_ERROR, us);
    }
    Ok(())
}

/// Error by one centroid against error by the other, over the balanced law's exponent and for every law.
fn trade_off(found: &mut Findings, person: Person, drive: Milliamps) -> Result<(), Failure> {
    let display = display("thimble-8")?;
    let paths = paths(&display)?;
    let at = |settings: &ModelSettings| {
        let total = total(&display, settings, &paths, (person, drive))?;
        Ok::<_, Failure>((total.rmse(0), total.rmse(1)))
    };
    let exponent = |tenths: u8| ModelSettings {
        shape: ShapeChoice::Factor(0.05 * f32::from(tenths)),
        ..ModelSettings::default()
    };
    let curve = (8..=24).filter_map(|e| at(&exponent(e)).ok()).collect();
    let name = "balanced, exponent 0.4 to 1.2";
    let mut series = vec![Series::new(name, Mark::Swept, curve)];
    for method in methods() {
        let point = at(&method.settings)?;
        series.push(Series::new(method.name, Mark::Ours, vec![point]));
    }
    let plot = Plot {
        x: Axis::linear("felt error by the energy centroid [mm RMSE]"),
        y: Axis::linear("felt error by the amplitude centroid [mm RMSE]"),
        series,
    };
    found.figures.push(plot.figure(
        "trade-off",
        "Two centroids, one law",
        "Thimble, four sphere paths, published drive. No exponent is best by both centroids; the default is where they \
         differ little.",
    ));
    Ok(())
}
