//! A scene's illusion section as the core's settings.

use palpate_core::illusion::{
    Calibration, Cells, Display, Drive, IllusionError, ModelSettings, Planned, ShapeChoice, Steps,
    Stroke, build,
};
use palpate_core::projector::OutputSettings;
use palpate_core::units::{Duration, Instant, Milliamps};

use super::point;
use crate::failure::Failure;
use palpate_files::Setup;

fn settings(illusion: &palpate_files::Illusion) -> ModelSettings {
    ModelSettings {
        model: illusion.model,
        shape: match illusion.shape {
            _ if illusion.flat => ShapeChoice::Flat,
            Some(shape) => ShapeChoice::Factor(shape as f32),
            None => ShapeChoice::Model,
        },
        distances: illusion.distances,
        margin: illusion.margin.map(|m| m as f32),
    }
}

/// The key that a model's refusal is about.
const fn key(error: IllusionError) -> &'static str {
    match error {
        IllusionError::OneWire | IllusionError::InLine => "illusion.model",
        IllusionError::Shape => "illusion.shape",
        IllusionError::Distances => "illusion.distances",
        IllusionError::Margin => "illusion.margin",
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
    let plan = |(index, file): (usize, &palpate_files::SceneStroke)| {
        let bad = |expected: String| {
            let key = format!("strokes[{index}].length_s");
            Failure::File(scene.source.bad(&key, expected))
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
    let bad = |key: &str, expected: String| Failure::File(setup.scene.source.bad(key, expected));
    let (duration, soa) = illusion.stated();
    let timing = illusion
        .timing
        .timing(duration, soa)
        .map_err(|e| bad("illusion.tau_d_ms", e.to_string()))?;
    let law = build(display, &settings(illusion)).map_err(|e| bad(key(e), e.to_string()))?;
    let floats = |values: &[f64]| values.iter().map(|v| *v as f32).collect::<Vec<_>>();
    let calibration = match &setup.wearer {
        None => Calibration::even(display.wires().len()),
        Some(wearer) => {
            let (gain, threshold) = (&wearer.value.gain, &wearer.value.threshold);
            Calibration::new(&floats(gain), &floats(threshold))
                .map_err(|e| wearer.source.bad("gain", e.to_string()))?
        }
    };
    Ok(OutputSettings {
        timing,
        illusion: law,
        sharing: illusion.sharing,
        calibration,
        strokes: strokes(setup, display)?,
        drive: drive(illusion),
        peak,
    })
}
