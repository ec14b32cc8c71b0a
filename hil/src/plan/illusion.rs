//! A scene's illusion section as the core's settings.

use palpate_core::illusion::{
    Calibration, Cells, Display, Distances, Drive, Model, ModelError, ModelSettings, Planned,
    ShapeChoice, Sharing, Steps, Stroke, build,
};
use palpate_core::projector::OutputSettings;
use palpate_core::units::{Duration, Instant, Milliamps};

use super::point;
use crate::failure::Failure;
use palpate_files::{IllusionModel, Setup};

/// The core's model of a scene file.
pub const fn model(model: IllusionModel) -> Model {
    match model {
        IllusionModel::Phantom => Model::Phantom,
        IllusionModel::Energy => Model::Energy,
        IllusionModel::Linear => Model::Linear,
        IllusionModel::Square => Model::Square,
        IllusionModel::Balanced => Model::Balanced,
        IllusionModel::ThreeNearest => Model::ThreeNearest,
        IllusionModel::Gaussian => Model::Gaussian,
        IllusionModel::Nearest => Model::Nearest,
    }
}

fn settings(illusion: &palpate_files::Illusion) -> ModelSettings {
    ModelSettings {
        model: model(illusion.model),
        shape: match illusion.shape {
            _ if illusion.flat => ShapeChoice::Flat,
            Some(shape) => ShapeChoice::Factor(shape as f32),
            None => ShapeChoice::Model,
        },
        distances: illusion.distances.map(|d| match d {
            palpate_files::Distances::Axes => Distances::Axes,
            palpate_files::Distances::Plane => Distances::Plane,
            palpate_files::Distances::Space => Distances::Space,
        }),
        margin: illusion.margin.map(|m| m as f32),
    }
}

/// The key that a model's refusal is about.
const fn key(error: ModelError) -> &'static str {
    match error {
        ModelError::OneWire | ModelError::InLine => "illusion.model",
        ModelError::Shape => "illusion.shape",
        ModelError::Distances => "illusion.distances",
        ModelError::Margin => "illusion.margin",
    }
}

/// Activation to duty.
pub fn drive(illusion: &palpate_files::Illusion) -> Drive {
    Drive {
        alpha: illusion.alpha as f32,
        beta: illusion.beta as f32,
        floor: if illusion.intensity {
            illusion.intensity_floor as f32
        } else {
            1.0
        },
        steps: match illusion.weber {
            Some(fraction) if illusion.intensity => Steps::Weber(fraction as f32),
            _ => Steps::Even,
        },
    }
}

/// A scene's strokes, planned for a display.
fn strokes(setup: &Setup, display: &Display) -> Result<Box<[Planned]>, Failure> {
    let scene = &setup.scene;
    let micros = |seconds: f64| (seconds * 1e6).round() as u64;
    let plan = |(index, file): (usize, &palpate_files::Stroke)| {
        let bad = |expected: String| {
            let key = format!("strokes[{index}].length_s");
            Failure::Input(scene.source.bad(&key, expected).to_string())
        };
        let stroke = Stroke {
            from: point(file.from_mm),
            to: point(file.to_mm),
            length: Duration::from_micros(micros(file.length_s)),
        };
        let cells = Cells::new(display).ok_or_else(|| bad("two wires or more".into()))?;
        let dabs = stroke
            .plan(&cells, display.gap())
            .map_err(|e| bad(e.to_string()))?;
        Ok(Planned::new(
            Instant::from_micros(micros(file.start_s)),
            dabs,
        ))
    };
    scene.value.strokes.iter().enumerate().map(plan).collect()
}

/// How stimuli are made.
pub(super) fn output(
    setup: &Setup,
    display: &Display,
    peak: Milliamps,
) -> Result<OutputSettings, Failure> {
    let illusion = &setup.scene.value.illusion;
    let bad = |key: &str, expected: String| {
        Failure::Input(setup.scene.source.bad(key, expected).to_string())
    };
    let (duration, soa) = illusion.stated();
    let timing = illusion
        .law()
        .timing(duration, soa)
        .map_err(|e| bad("illusion.tau_d_ms", e.to_string()))?;
    let law = build(display, &settings(illusion)).map_err(|e| bad(key(e), e.to_string()))?;
    let floats = |values: &[f64]| values.iter().map(|v| *v as f32).collect::<Vec<_>>();
    let calibration = match &setup.wearer {
        None => Calibration::even(display.wires().len()),
        Some(wearer) => {
            let (gain, threshold) = (&wearer.value.gain, &wearer.value.threshold);
            Calibration::new(&floats(gain), &floats(threshold))
                .map_err(|e| Failure::Input(wearer.source.bad("gain", e.to_string()).to_string()))?
        }
    };
    Ok(OutputSettings {
        timing,
        illusion: law,
        sharing: match illusion.sharing {
            None | Some(palpate_files::Sharing::Strongest) => Sharing::Strongest,
            Some(palpate_files::Sharing::Sum) => Sharing::Sum,
            Some(palpate_files::Sharing::Slices) => Sharing::Slices,
        },
        calibration,
        smallest_step: illusion.smallest_step as f32,
        strokes: strokes(setup, display)?,
        drive: drive(illusion),
        peak,
    })
}
