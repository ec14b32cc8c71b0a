//! Skins of the robot's end: boards on interfaces, an emulated skin, recorded rows, recorded frames of buses.

use palpate_buses::pacer::RunClock;
use palpate_core::units::Instant;
use palpate_files::{BenchKind, Setup, Timing};
use palpate_live::real::{Sensed, open_skin};
use palpate_live::recording::{Reading, recorded};
use palpate_run::{Failure, Hand, Input, plan, skin};

use crate::cli::SkinArgs;
use crate::records::keeps_frames;

/// Opens the skin of a setup, or recordings in its place, and hands it to `work` with its clock and when it ends at the
/// latest. With hands, one on each module, an emulated skin is under these alone, and has no end.
pub(super) fn open(
    setup: &Setup,
    args: &SkinArgs,
    hands: Option<&[Hand]>,
    work: impl FnOnce(&mut dyn Sensed, RunClock, Instant) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let replay = &args.replay;
    let layout = plan::layout(&setup.sensor.value)?;
    if let Some(hands) = hands {
        let mut skin = skin::under_hands(setup, &layout, args.on.seed, hands)?;
        return work(&mut skin, RunClock::start(), Instant::FAR_FUTURE);
    }
    let is_real = replay.is_empty() && setup.bench.value.kind == BenchKind::Real;
    let input = match replay.is_empty() {
        true => Input::Scene,
        false => {
            let reading = Reading {
                timing: Timing {
                    rate_hz: args.rate,
                    rest_rows: setup.scene.value.reference_frames as usize + 1,
                    ..Timing::default()
                },
                ..Reading::default()
            };
            let (input, notes) = recorded(replay, &setup.sensor.value, &reading)?;
            notes
                .iter()
                .for_each(|text| palpate_live::output::note(text));
            input
        }
    };
    let (clock, keeps) = (RunClock::start(), is_real && keeps_frames(&args.record));
    let (mut skin, end) = open_skin(setup, &layout, &input, args.on.seed, clock, keeps)?;
    match is_real {
        // What touches it is up to the world, and so is for how long.
        true => work(&mut *skin, clock, Instant::FAR_FUTURE),
        // Its own time begins when it is there.
        false => work(&mut *skin, RunClock::start(), end),
    }
}
