//! Skins of the robot's end: boards on interfaces, an emulated skin, recorded rows, recorded frames of buses.

use palpate_buses::pacer::RunClock;
use palpate_core::units::{Duration, Instant};
use palpate_files::{BenchKind, Setup, Timing};
use palpate_live::real::{Sensed, open_skin};
use palpate_live::recording::{Reading, recorded};
use palpate_run::skin_end::Tap;
use palpate_run::{CanPlayer, Failure, Input, Rows, plan, skin};

use crate::cli::SkinArgs;
use crate::records::keeps_frames;

/// Time after a recording's last row.
const AFTER: Duration = Duration::from_millis(100);

/// Work with a skin of any kind.
pub(super) trait WithSkin {
    /// Works with the skin, until `end` at the latest. The skin's own time is the clock's.
    fn with<S: Sensed>(self, skin: S, clock: RunClock, end: Instant) -> Result<(), Failure>;
}

/// Opens the skin of a setup, or recordings in its place.
pub(super) fn open(setup: &Setup, args: &SkinArgs, work: impl WithSkin) -> Result<(), Failure> {
    let (replay, rate_hz) = (&args.replay, args.rate);
    let layout = plan::layout(&setup.sensor.value)?;
    if replay.is_empty() && setup.bench.value.kind == BenchKind::Real {
        let clock = RunClock::start();
        let skin = open_skin(setup, &layout, clock, keeps_frames(&args.record))?;
        // The world decides on touches, and on the end.
        return work.with(skin, clock, Instant::FAR_FUTURE);
    }
    if replay.is_empty() {
        let end = (setup.scene.value.length_s * 1e6).round() as u64;
        let skin = skin::scene(setup, args.on.seed, None)?;
        return work.with(skin, RunClock::start(), Instant::from_micros(end));
    }
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
        .for_each(|text| palpate_live::output::note(text));
    match input {
        Input::Rows(sources) => {
            let rows = Rows::new(&sources, &setup.sensor.value, &layout)?;
            let last = sources.iter().map(|s| s.span_us()).max().unwrap_or(0);
            let end = Instant::from_micros(last) + AFTER;
            work.with(rows, RunClock::start(), end)
        }
        Input::Frames(frames) => {
            let player = CanPlayer::new(frames.frames()?);
            let end = frames.end() + AFTER;
            let skin = skin::source(setup, &layout, Tap::new(player, false));
            work.with(skin, RunClock::start(), end)
        }
        Input::Scene | Input::Stream(_) => {
            Err(Failure::Input("--replay: expected recordings".into()))
        }
    }
}
