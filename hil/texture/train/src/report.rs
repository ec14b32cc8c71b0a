//! One run from first epoch to figures: the model file, and the model's worth.

use std::io::Write;
use std::process::Command;
use std::time::Instant;

use ndarray::{Array2, Axis};
use palpate_files::Precision;
use serde_json::{Map, Value, json};

use crate::Arguments;
use crate::failure::Failure;
use crate::measure::{self, Components};
use crate::model_file::{self, About};
use crate::network::Network;
use crate::recordings::LabelFacts;
use crate::settings::Progress;
use crate::shown::Shown;
use crate::training::{self, Plain};
use crate::windows::{Place, Split, Windows};

/// Width of the thesis's latent vector.
const COMPONENTS: usize = 3;
/// Neighbours that vote.
const NEIGHBOURS: usize = 5;

/// Trains, writes the model, measures it and reports.
pub fn run(
    arguments: &Arguments,
    windows: &Windows,
    split: &Split,
    known: &LabelFacts,
) -> Result<(), Failure> {
    let settings = &arguments.settings;
    #[allow(clippy::disallowed_methods)] // progress and --minutes; no result depends on it
    let began = Instant::now();
    // of the tree as it is now: it may change while a training runs
    let revision = revision();
    let shown = Shown::new(settings.epochs);
    let says = |progress: &Progress| {
        shown.epoch(progress);
        let minutes = began.elapsed().as_secs_f64() / 60.0;
        arguments.minutes.is_none_or(|limit| minutes < limit)
    };
    let folder = arguments.checkpoint.as_deref();
    let (network, progress) = training::train(windows, split, known, settings, folder, says)?;
    drop(shown);
    let (network, precision) = match arguments.half {
        true => (
            training::halved(network, windows, settings)?,
            Precision::Half,
        ),
        false => (network, Precision::Single),
    };
    let heads = settings.heads > 0.0;
    let test = windows.places(&split.test, if heads { training::MATERIALS_HOP } else { 1 });
    let decodes = settings.decode > 0.0;
    let test_error = decodes.then(|| training::reconstruction(&network, windows, &test));
    let latent = model_file::drivers(&network, windows, &split.train, (known, heads));
    let peers = (!heads).then(|| {
        let seen = measure::matrix(windows, &windows.places(&split.train, 4));
        peers(&seen, settings.latent)
    });
    let figures = json!({
        "recordings": windows.recordings.all.len(),
        "features": windows.recordings.columns.len(),
        "device": settings.device,
        "epochs": progress.epochs,
        "best_epoch": progress.best_epoch,
        "minutes": began.elapsed().as_secs_f64() / 60.0,
        "test": (peers.as_ref().zip(test_error))
            .map(|(peers, error)| against_others(windows, split, error, peers)),
        "heads": heads.then(|| {
            let tested = model_file::drivers(&network, windows, &split.test, (known, heads));
            let rank = |driver: Option<model_file::Driver>| driver.map(|d| d.spearman);
            json!({
                "materials": "test",
                "roughness": rank(tested.roughness),
                "friction": rank(tested.friction),
                "hardness": rank(tested.hardness),
            })
        }),
        "unseen": (decodes && !split.unseen.is_empty()).then(|| {
            let unseen = windows.places(&split.unseen, 4);
            training::reconstruction(&network, windows, &unseen)
        }),
        "neighbours": peers.map(|peers| by_neighbours(&network, windows, split, &peers)),
        "latent": latent,
        "curve": progress,
    });
    let about = About {
        windows,
        split,
        settings,
        progress: &progress,
        test_error,
        latent,
        rate_hz: arguments.rate_hz,
        command: command(),
        revision,
        precision,
    };
    model_file::write(&arguments.model, &network, &about)?;
    // A closed stream is no reason to fail: the model is written.
    let _closed = writeln!(std::io::stdout(), "{figures:#}");
    Ok(())
}

/// Principal components to compare with: as many as the thesis's latent vector has, and as this one's has.
fn peers(known: &Array2<f32>, latent: usize) -> Vec<(String, Components)> {
    let mut counts = vec![COMPONENTS, latent];
    counts.dedup();
    let fit = |&count: &usize| (format!("pca{count}"), Components::fit(known, count));
    counts.iter().map(fit).collect()
}

/// Reconstruction errors of the test recordings: of the network, of a mean and of principal components.
fn against_others(
    windows: &Windows,
    split: &Split,
    network: f64,
    peers: &[(String, Components)],
) -> Value {
    let asked = measure::matrix(windows, &windows.places(&split.test, 1));
    let mut errors = Map::from_iter([("network".to_owned(), json!(network))]);
    for (name, components) in peers {
        errors.insert("mean".to_owned(), json!(components.error_of_mean(&asked)));
        errors.insert(name.clone(), json!(components.error(&asked)));
    }
    errors.into()
}

/// Labels of the test recordings by their neighbours among the others, and by a linear probe (of means alone): from the
/// network's latent vectors, and from principal components. The mean over its windows represents a recording, and with
/// `with_spread` mean and standard deviation: the motion of a latent vector is texture too.
fn by_neighbours(
    network: &Network<Plain>,
    windows: &Windows,
    split: &Split,
    peers: &[(String, Components)],
) -> Value {
    type Codes<'a> = &'a dyn Fn(&[Place]) -> Vec<Vec<f32>>;
    let labels = windows.recordings.labels();
    let points = |part: &[usize], codes: Codes<'_>| -> Vec<(Vec<f32>, usize)> {
        let point = |&recording: &usize| {
            let all = codes(&windows.places(&[recording], 5));
            let label = labels
                .binary_search(&windows.recordings.all[recording].label)
                .ok()?;
            Some((moments(&all)?, label))
        };
        part.iter().filter_map(point).collect()
    };
    let known: Vec<usize> = split
        .train
        .iter()
        .chain(&split.validation)
        .copied()
        .collect();
    let (mut means, mut both, mut linear) = (Map::new(), Map::new(), Map::new());
    let mut add = |name: &str, codes: Codes<'_>| {
        let (mut known, mut asked) = (points(&known, codes), points(&split.test, codes));
        let share = measure::neighbours(&known, &asked, NEIGHBOURS);
        both.insert(name.to_owned(), json!(share));
        for (point, _) in known.iter_mut().chain(&mut asked) {
            point.truncate(point.len() / 2);
        }
        let share = measure::neighbours(&known, &asked, NEIGHBOURS);
        means.insert(name.to_owned(), json!(share));
        let share = measure::linear(&known, &asked, labels.len());
        linear.insert(name.to_owned(), json!(share));
    };
    add("network", &|places| {
        training::latents(network, windows, places)
    });
    for (name, components) in peers {
        add(name, &|places| {
            let scores = components.scores(&measure::matrix(windows, places));
            scores.rows().into_iter().map(|row| row.to_vec()).collect()
        });
    }
    means.insert("labels".to_owned(), json!(labels.len()));
    means.insert("with_spread".to_owned(), both.into());
    means.insert("linear".to_owned(), linear.into());
    means.into()
}

/// The mean of each coordinate, then the standard deviation of each.
fn moments(all: &[Vec<f32>]) -> Option<Vec<f32>> {
    let width = all.first()?.len();
    let all = Array2::from_shape_fn((all.len(), width), |(n, c)| all[n][c]);
    let mut moments = all.mean_axis(Axis(0))?.to_vec();
    moments.extend(all.std_axis(Axis(0), 0.0));
    Some(moments)
}

/// The command line, without the folders that only this machine has.
fn command() -> String {
    let short = |argument: String| {
        let last = argument.rsplit('/').next().unwrap_or_default().to_owned();
        if argument.starts_with('/') {
            last
        } else {
            argument
        }
    };
    std::env::args().map(short).collect::<Vec<_>>().join(" ")
}

fn revision() -> String {
    let asked = Command::new("git")
        .args(["describe", "--always", "--dirty"])
        .output();
    let text = asked
        .ok()
        .filter(|o| o.status.success())
        .map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned());
    text.unwrap_or_else(|| "unknown".into())
}
