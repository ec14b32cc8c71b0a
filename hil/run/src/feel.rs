//! What a run samples of the display: where an onset was felt, how warm the wires are.

use palpate_core::illusion::Drive;
use palpate_core::projector::Projector;
use palpate_core::units::{Instant, Point};
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::WornDisplay;
use palpate_records::trace::{Event, FeltAt, PlaceUm};

use super::recorder::{Onset, Recorder, milli_c};

/// A contact this close to the display's hull counts as inside it, mm.
const HULL_MARGIN: f32 = 1e-3;

/// What a person felt of an onset that is over. One felt place can be held against one touch only: an onset with
/// several contacts is scored where they are known to come from a single one.
pub(super) fn feel(
    onset: Option<Onset>,
    display: &WornDisplay,
    projector: &Projector,
    drive: Drive,
    recorder: &mut Recorder,
) {
    let Some(Onset {
        at,
        targets,
        squares,
    }) = onset
    else {
        return;
    };
    let true_place = recorder
        .truth_at(at)
        .map(|(place, _)| projector.map().apply(place));
    let strongest = targets.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
    let Some(seen) = strongest.filter(|_| targets.len() == 1 || true_place.is_some()) else {
        return;
    };
    let place = |(x, y): (f64, f64)| PlaceUm::from(Point::new(x as f32, y as f32));
    let felt = display.feel(Nanos::from(at)).map(|felt| FeltAt {
        energy: place(felt.energy_mm),
        amplitude: place(felt.amplitude_mm),
    });
    let full = targets
        .iter()
        .map(|t| u64::from(drive.width(t.weight).get()).pow(2));
    let full = full.sum::<u64>().max(1);
    recorder.events.push(Event::Felt {
        t_us: at.as_micros(),
        target: PlaceUm::from(true_place.unwrap_or(seen.place)),
        inside: projector.display().contains(seen.place, HULL_MARGIN),
        felt,
        energy_permille: u32::try_from(1000 * squares / full).unwrap_or(u32::MAX),
    });
}

/// How warm every wire is now, and the skin under it.
pub(super) fn sample_wires(
    now: Instant,
    display: &mut WornDisplay,
    projector: &Projector,
    recorder: &mut Recorder,
) {
    let t_us = now.as_micros();
    for index in 0..projector.display().wires().len() {
        let wire = index as u16;
        if let Some(milli_c) = display.wire_c(index).and_then(milli_c) {
            recorder.events.push(Event::Wire {
                t_us,
                wire,
                milli_c,
            });
        }
        if let Some(milli_c) = display.tissue_c(index).and_then(milli_c) {
            recorder.events.push(Event::Skin {
                t_us,
                wire,
                milli_c,
            });
        }
    }
}
