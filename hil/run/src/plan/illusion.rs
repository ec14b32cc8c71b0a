//! A scene's illusion section as the core's settings.

use palpate_core::guard::Guard;
use palpate_core::illusion::{
    Calibration, Cells, Display, Drive, IllusionError, IllusionModel, LONGEST, ModelSettings,
    Planned, ShapeChoice, Steps, Stroke, build, inverse,
};
use palpate_core::projector::OutputSettings;
use palpate_core::render::{CADENCE, Pattern, RenderSettings};
use palpate_core::schedule::Timing;
use palpate_core::units::{Duration, Instant, Milliamps, Prescale};

use super::response::Responses;
use super::{level, point};
use crate::failure::Failure;
use palpate_files::Setup;

/// Power of a moving contact, W, that the number of pulses must be able to carry: half the fingertip's for a minute.
pub(crate) const MOVING_W: f64 = 0.03;
/// The widest pulse that the limits let pass at the nominal oscillator, s.
const WIDEST_S: f64 = 184e-6;

fn settings(illusion: &palpate_files::Illusion) -> ModelSettings {
    ModelSettings {
        model: illusion.model,
        shape: match illusion.shape {
            _ if illusion.flat => ShapeChoice::Flat,
            Some(x) => match illusion.shape_y {
                Some(y) => ShapeChoice::Axes(x as f32, y as f32),
                None => ShapeChoice::Factor(x as f32),
            },
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

/// Curve from activation to duty.
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
fn strokes(setup: &Setup, display: &Display, timing: Timing) -> Result<Box<[Planned]>, Failure> {
    let scene = &setup.scene;
    // Time that other displays' transfers may take of a burst counts as time on.
    let longest = LONGEST
        .as_micros()
        .saturating_sub(setup.bus_wait.as_micros());
    let longest = Duration::from_micros(longest);
    let micros = |seconds: f64| (seconds * 1e6).round() as u64;
    let plan = |(index, file): (usize, &palpate_files::SceneStroke)| {
        let bad = |expected: String| {
            let key = format!("{}strokes[{index}].length_s", setup.section);
            Failure::File(scene.source.bad(&key, expected))
        };
        let start = Instant::from_micros(micros(file.start_s));
        let stroke = Stroke {
            from: point(file.from_mm),
            to: point(file.to_mm),
            length: Duration::from_micros(micros(file.length_s)),
        };
        let weight = file.weight as f32;
        // A stroke that goes nowhere, as it is written: any other has a way to go.
        #[allow(clippy::float_cmp)]
        let stays = file.from_mm == file.to_mm;
        if stays {
            let each = (timing.duration, timing.soa);
            let stays = Planned::staying(start, stroke.from, stroke.length, each);
            return Ok(stays.weighted(weight));
        }
        let cells = Cells::new(display).ok_or_else(|| bad("two wires or more".into()))?;
        let dabs = stroke
            .plan(&cells, display.gap(), longest)
            .map_err(|e| bad(e.to_string()))?;
        Ok(Planned::new(start, dabs).weighted(weight))
    };
    scene.value.strokes.iter().enumerate().map(plan).collect()
}

/// Pulses and cadence where the scene's law chooses them. The spacing belongs to the boards: a bench that states its
/// frequency keeps it, a texture has its own, and the law takes what fits.
pub(super) fn pattern(setup: &Setup) -> Result<Option<Pattern>, Failure> {
    let (scene, bench) = (&setup.scene, &setup.bench.value);
    let illusion = &scene.value.illusion;
    if illusion.model != IllusionModel::Inverse {
        return Ok(None);
    }
    let bad = |key: &str, expected: String| Failure::File(scene.source.bad(key, expected));
    let (duration, stated) = illusion.stated();
    if duration.is_some() {
        let expected = "nothing: `inverse` finds how long a burst is";
        return Err(bad("illusion.tau_d_ms", expected.into()));
    }
    let soa = stated.or(bench.drive.soa()).unwrap_or(CADENCE);
    let free = bench.drive.pwm_hz.is_none() && scene.value.texture.is_none();
    let pattern = if free {
        let amps = bench.drive.current_ma * 1e-3;
        let pulse_j = amps * amps * super::wire(setup).resistance_ohm * WIDEST_S;
        let burst_j = MOVING_W * soa.as_secs_f64();
        let pattern = Pattern::new(soa, (burst_j / pulse_j).ceil() as u8);
        let spacing = |pattern: Pattern| {
            let prescale = super::clock(bench)
                .and_then(|clock| Prescale::from_hz(clock, pattern.prescale().hz()));
            Pattern::on(prescale.unwrap_or(pattern.prescale()), soa)
        };
        match bench.drive.clock {
            None => pattern,
            Some(_) => pattern.and_then(spacing),
        }
    } else {
        Pattern::on(super::prescale(bench)?, soa)
    };
    pattern
        .map(Some)
        .map_err(|e| match (stated, bench.drive.soa_ms) {
            (None, Some(_)) => Failure::File(setup.bench.source.bad("drive.soa_ms", e.to_string())),
            _ => bad("illusion.soa_ms", e.to_string()),
        })
}

/// Settings of the law that chooses its pulses by itself.
fn render(
    setup: &Setup,
    display: &Display,
    guard: &Guard,
    calibration: &Calibration,
    (pattern, responses): (Pattern, &Responses),
) -> Result<RenderSettings, Failure> {
    let illusion = &setup.scene.value.illusion;
    let bad = |e: IllusionError| Failure::File(setup.scene.source.bad(key(e), e.to_string()));
    let felt = responses.response(setup, guard, &pattern)?;
    let mut settings = RenderSettings {
        law: inverse(display, &settings(illusion)).map_err(bad)?,
        style: illusion.render,
        pattern,
        response: felt.response,
        woven: responses.woven(setup, guard, &pattern)?,
        full: felt.threshold,
        texture: felt.threshold,
        sharing: illusion.sharing,
        calibration: calibration.clone(),
    };
    level::ask(setup, guard, display.wires().len(), &mut settings)?;
    Ok(settings)
}

/// Settings of the output: how stimuli are made.
pub(super) fn output(
    setup: &Setup,
    display: &Display,
    guard: &Guard,
    peak: Milliamps,
    (pattern, responses): (Option<Pattern>, &Responses),
) -> Result<OutputSettings, Failure> {
    let illusion = &setup.scene.value.illusion;
    let bad = |key: &str, expected: String| Failure::File(setup.scene.source.bad(key, expected));
    let (duration, soa) = illusion.stated();
    let stated = || illusion.timing.timing(duration, soa);
    let timing = pattern
        .map_or_else(stated, |p| Ok(p.timing()))
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
    let render = pattern.map(|p| render(setup, display, guard, &calibration, (p, responses)));
    let render = render.transpose()?;
    Ok(OutputSettings {
        timing,
        render,
        illusion: law,
        sharing: illusion.sharing,
        calibration,
        strokes: strokes(setup, display, timing)?,
        drive: drive(illusion),
        share: super::current::share(&setup.bench.value, guard, peak),
    })
}
