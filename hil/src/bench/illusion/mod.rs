//! Illusions: every law on every array by both perceivers - where it is felt, how even, how often nothing is
//! - and what an onset costs. Figure 5.5 of the thesis, for (5.2) and for the default law.

mod figure;
mod users;

use std::time::Duration;

use palpate_core::illusion::{
    Display, Mixer, Model, ModelSettings, ShapeChoice, Sharing, Target, Wire, build,
};
use palpate_core::units::{Board, Channel, Milliamps, Point};
use palpate_emulators::perceiver::Perceiver;
use palpate_records::felt::FeltScore;

use crate::failure::Failure;
use crate::felt::{PATHS, PathScore, Worn, current, path_on, person};
use crate::plan;
use palpate_files::{LayoutFile, load_layout};

use super::plot::{Axis, Mark, Plot, Series};
use super::timing::Race;
use super::{Findings, Row};

/// The arrays, by layout.
const ARRAYS: [&str; 3] = ["three-in-line", "thimble-8", "tactile-brush-4x3"];
/// Wires of the largest driver unit: 16 boards of 8.
const MANY: usize = 128;

/// What a law came to over the four paths on one array.
#[derive(Clone, Copy, Debug, Default)]
struct Total {
    /// Mean square of the felt error, by energy and by amplitude centroid, mm2, and onsets.
    squares: [f64; 2],
    onsets: [u64; 2],
    breaks: u64,
    jumps: [u64; 2],
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
            self.jumps[k] += felt.jumps;
        }
        self.breaks += score.felt.first().map_or(0, |f: &FeltScore| f.breaks);
        self.dip_db = self.dip_db.min(score.energy_db.0);
        self.peak_db = self.peak_db.max(score.energy_db.1);
    }

    /// Root mean square of the felt error by one of the perceivers, mm; NaN where nothing was felt.
    fn rmse(&self, perceiver: usize) -> f64 {
        (self.squares[perceiver] / self.onsets[perceiver] as f64).sqrt()
    }
}

/// A law by name with its settings, as it stands in a table.
struct Method {
    name: String,
    settings: ModelSettings,
}

/// Every law; the default one is called `default`, (5.2) also stands with flat midpoints.
fn methods() -> Vec<Method> {
    let of = |model: Model, shape: ShapeChoice| ModelSettings {
        model,
        shape,
        ..ModelSettings::default()
    };
    let mut methods: Vec<Method> = Model::ALL
        .into_iter()
        .map(|model| Method {
            name: if model == Model::default() {
                "default".into()
            } else {
                model.name().into()
            },
            settings: of(model, ShapeChoice::Model),
        })
        .collect();
    methods.insert(
        1,
        Method {
            name: "phantom, flat".into(),
            settings: of(Model::Phantom, ShapeChoice::Flat),
        },
    );
    methods
}

/// Measures everything.
///
/// # Errors
/// [`Failure`] where a shipped file cannot be read.
pub fn measure() -> Result<Findings, Failure> {
    let (perceiver, drive) = (person()?, current("thesis")?);
    let mut found = Findings::default();
    for name in ARRAYS {
        let display = array(name)?;
        on_array(&mut found, name, &display, perceiver, drive)?;
    }
    costs(&mut found, "cost, 8 wires", &array("thimble-8")?);
    costs(&mut found, "cost, 128 wires", &many()?);
    found.plots.push(trade_off(perceiver, drive)?);
    found.words.push(format!(
        "default is {}: shares to the power of {}, one energy everywhere. Errors are over the four sphere paths \
         at the published drive (1.97 A, no intensity), contacts inside the array, a break counting as felt where \
         it was felt last; one time per array is that of an onset on it.",
        Model::default().name(),
        Model::default().shape().unwrap_or(1.0),
    ));
    found.words.push(
        "Gain and threshold of both perceivers are fitted, not measured (fixtures/perceivers/fitted.toml)."
            .into(),
    );
    found.figures.push(figure::five_five(perceiver, drive)?);
    Ok(found)
}

/// A shipped display on outputs of its own.
fn array(name: &str) -> Result<Display, Failure> {
    let LayoutFile::Display(file) = load_layout(name)?.value else {
        return Err(Failure::Input(format!(
            "layout `{name}`: expected a display"
        )));
    };
    plan::display_of(&file, |wire| {
        (Board((wire / 8) as u8), Channel((wire % 8) as u8))
    })
}

/// Sixteen columns of eight wires, 9 mm apart.
fn many() -> Result<Display, Failure> {
    let wire = |i: usize| Wire {
        place: Point::new(9.0 * (i / 8) as f32, 9.0 * (i % 8) as f32),
        board: Board((i / 8) as u8),
        channel: Channel((i % 8) as u8),
    };
    let wires: Vec<Wire> = (0..MANY).map(wire).collect();
    Display::new(&wires).map_err(|e| Failure::Input(e.to_string()))
}

fn on_array(
    found: &mut Findings,
    name: &str,
    display: &Display,
    perceiver: Perceiver,
    drive: Milliamps,
) -> Result<(), Failure> {
    let paths: Vec<Vec<Point>> = PATHS
        .iter()
        .map(|scene| path_on(scene, display))
        .collect::<Result<_, _>>()?;
    let mut results = Vec::new();
    for method in methods() {
        // A law that does not fit this array (three-nearest on a line) has no row.
        let Ok(mut worn) = Worn::new(display, &method.settings, perceiver, drive) else {
            continue;
        };
        let mut total = Total::default();
        paths.iter().for_each(|path| total.add(&worn.score(path)));
        results.push((method, total));
    }
    let times = time(display, results.iter().map(|(method, _)| &method.settings));
    let mut case = |what: &str, unit: &'static str, value: &dyn Fn(&Total) -> f64| {
        for ((method, total), median_us) in results.iter().zip(&times) {
            found.rows.push(Row {
                family: "illusion",
                case: format!("{name}: {what}"),
                method: method.name.clone(),
                error: value(total),
                error_unit: unit,
                median_us: *median_us,
                peer: false,
            });
        }
    };
    case("energy centroid", "mm RMSE", &|t| t.rmse(0));
    case("amplitude centroid", "mm RMSE", &|t| t.rmse(1));
    case("dip", "dB", &|t| t.dip_db);
    case("peak", "dB", &|t| t.peak_db);
    case("breaks", "onsets", &|t| t.breaks as f64);
    case("jumps, energy centroid", "onsets", &|t| t.jumps[0] as f64);
    case("jumps, amplitude centroid", "onsets", &|t| {
        t.jumps[1] as f64
    });
    Ok(())
}

/// Median time of one contact at an onset, microseconds, by law; NaN for one that does not fit.
fn time<'s>(display: &Display, settings: impl Iterator<Item = &'s ModelSettings>) -> Vec<f64> {
    let wires = display.wires().len();
    let bounds = display.bounds();
    let (width, height) = (bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y);
    // Places that no branch predictor learns: golden-ratio steps over the whole display.
    let targets: Vec<Target> = (0..256)
        .map(|k| {
            let part = |step: f32| (k as f32 * step).fract();
            let (x, y) = (part(0.618_034), part(0.754_877_7));
            Target {
                place: Point::new(bounds.min.x + x * width, bounds.min.y + y * height),
                weight: 1.0,
            }
        })
        .collect();
    let mut race = Race::default();
    let mut fits = Vec::new();
    for settings in settings {
        let law = build(display, settings);
        fits.push(law.is_ok());
        let Ok(law) = law else { continue };
        let mut mixer = Mixer::new(law, Sharing::Strongest, wires);
        let targets = &targets;
        race.enter(move || {
            targets
                .iter()
                .map(|t| mixer.activate(std::slice::from_ref(t)).iter().sum::<f32>())
                .sum::<f32>()
        });
    }
    let mut samples = race.run(200, Duration::from_millis(500)).into_iter();
    fits.iter()
        .map(|fits| match fits {
            true => samples.next().map_or(f64::NAN, |s| s.median() / 256.0),
            false => f64::NAN,
        })
        .collect()
}

/// What an onset costs beside its target: 0.3 us for eight wires, 5 us for 128.
fn costs(found: &mut Findings, case: &str, display: &Display) {
    let methods = methods();
    let times = time(display, methods.iter().map(|m| &m.settings));
    for (method, median_us) in methods.into_iter().zip(times) {
        found.rows.push(Row {
            family: "illusion",
            case: case.into(),
            method: method.name,
            error: f64::NAN,
            error_unit: "",
            median_us,
            peer: false,
        });
    }
}

/// Error by one perceiver against error by the other, over the balanced law's exponent and for every law.
fn trade_off(perceiver: Perceiver, drive: Milliamps) -> Result<Plot, Failure> {
    let display = array("thimble-8")?;
    let paths: Vec<Vec<Point>> = PATHS
        .iter()
        .map(|scene| path_on(scene, &display))
        .collect::<Result<_, _>>()?;
    let at = |settings: &ModelSettings| {
        let mut worn = Worn::new(&display, settings, perceiver, drive)?;
        let mut total = Total::default();
        paths.iter().for_each(|path| total.add(&worn.score(path)));
        Ok::<_, palpate_core::illusion::ModelError>((total.rmse(0), total.rmse(1)))
    };
    let exponent = |tenths: u8| ModelSettings {
        shape: ShapeChoice::Factor(0.05 * f32::from(tenths)),
        ..ModelSettings::default()
    };
    let mut series = vec![Series {
        name: "balanced, exponent 0.4 to 1.2".into(),
        points: (8..=24).filter_map(|e| at(&exponent(e)).ok()).collect(),
        mark: Mark::Swept,
    }];
    for method in methods() {
        let point = at(&method.settings).map_err(|e| Failure::Input(e.to_string()))?;
        series.push(Series {
            name: method.name,
            points: vec![point],
            mark: Mark::Ours,
        });
    }
    let axis = |who: &str| Axis {
        label: format!("felt error by the {who} centroid [mm RMSE]"),
        log: false,
    };
    Ok(Plot {
        name: "trade-off".into(),
        title: "Two perceivers, one law".into(),
        words: "Thimble, four sphere paths, published drive. No exponent is best by both perceivers; the default \
                is where they differ little."
            .into(),
        x: axis("energy"),
        y: axis("amplitude"),
        series,
    })
}
