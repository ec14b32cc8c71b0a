//! What may stand at the robot's end: an emulated skin, recorded rows, recorded frames of buses.

use std::path::PathBuf;

use palpate_core::units::{Duration, Instant};
use palpate_files::{Setup, Timing};
use palpate_hil::recording::{Reading, recorded};
use palpate_run::skin_end::{SkinEnd, Tap};
use palpate_run::{CanPlayer, EmulatedSkin, Failure, Input, Rows, plan, skin};

/// After a recording's last row.
const AFTER: Duration = Duration::from_millis(100);

/// What is done with a skin, whatever it is.
pub(super) trait WithSkin {
    /// Does it, until `end` at the latest.
    fn with<S: SkinEnd>(self, skin: S, end: Instant) -> Result<(), Failure>;
}

/// Opens the skin of a setup, or recordings in its place.
pub(super) fn open(
    setup: &Setup,
    replay: &[PathBuf],
    rate_hz: Option<f64>,
    seed: u64,
    work: impl WithSkin,
) -> Result<(), Failure> {
    if replay.is_empty() {
        if setup.bench.value.is_hardware() {
            return Err(Failure::Input(format!(
                "bench `{}`: expected an emulated bench or --replay: palpate-link opens no buses",
                setup.bench.value.name
            )));
        }
        let end = (setup.scene.value.length_s * 1e6).round() as u64;
        return work.with(EmulatedSkin::scene(setup, seed)?, Instant::from_micros(end));
    }
    let layout = plan::layout(&setup.sensor.value)?;
    let reading = Reading {
        timing: Timing {
            column: None,
            rate_hz,
            split_jumps: false,
        },
        prefix: None,
        rest_rows: setup.scene.value.reference_frames as usize + 1,
    };
    let (input, notes) = recorded(replay, &setup.sensor.value, &reading)?;
    notes
        .iter()
        .for_each(|text| palpate_hil::output::note(text));
    match input {
        Input::Rows(sources) => {
            let rows = Rows::new(&sources, &setup.sensor.value, &layout)?;
            let last = sources.iter().map(|s| s.span_us()).max().unwrap_or(0);
            work.with(rows, Instant::from_micros(last) + AFTER)
        }
        Input::Frames(frames) => {
            let player = CanPlayer::new(frames.frames()?);
            let end = frames.end() + AFTER;
            work.with(skin::source(setup, &layout, Tap::new(player, false)), end)
        }
        Input::Scene | Input::Stream(_) => {
            Err(Failure::Input("--replay: expected recordings".into()))
        }
    }
}
