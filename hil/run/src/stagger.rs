//! The grid of onsets that the fingers of a bench share, emulated or real: bursts of displays on one board take turns, and
//! boards of one bus are written one after the other.

use palpate_core::projector::Projector;
use palpate_core::units::{Duration, Instant};
use palpate_emulators::display::i2c::BusClock;
use palpate_files::Setup;

use crate::failure::Failure;
use crate::place::{Place, hand_of};
use crate::plan;
use crate::policy::TICK;

/// Tells whether two displays have a board in common.
fn share(one: &Place, other: &Place) -> bool {
    one.boards.iter().any(|board| other.boards.contains(board))
}

/// Group of each finger: fingers that share boards, directly or through others, have the same number.
fn groups(places: &[&Place]) -> Vec<usize> {
    let mut groups: Vec<usize> = Vec::new();
    for (index, place) in places.iter().enumerate() {
        let joined = (0..index).filter(|other| share(places[*other], place));
        let joined: Vec<usize> = joined.map(|other| groups[other]).collect();
        let group = joined.iter().copied().min().unwrap_or(index);
        let all = groups.iter_mut().filter(|g| joined.contains(g));
        all.for_each(|g| *g = group);
        groups.push(group);
    }
    groups
}

/// Time that a write of all channels of a display takes a bus, in whole turns of the loop.
fn write_time(places: &[&Place]) -> Duration {
    let most = places.iter().map(|p| p.wires).max().unwrap_or(0) as u64;
    let write = BusClock::Fast.write_time(1 + 4 * most.min(16));
    Duration::from_micros(write.as_micros().next_multiple_of(TICK.as_micros()))
}

/// The power of a hand, shared out, carries a moving contact on each of its fingertips.
fn check_hands(setup: &Setup) -> Result<(), Failure> {
    let limits = &setup.limits;
    let hand_mw = limits.value.limits.hand_60s_uw as f64 * 1e-3;
    let moving_mw = plan::MOVING_W * 1e3;
    let counts = setup.fingers.iter().map(|f| hand_of(setup, f).count());
    let most = counts.max().unwrap_or(0);
    let needed = most as f64 * moving_mw;
    if hand_mw >= needed {
        return Ok(());
    }
    let expected = format!(
        "at least {needed} mW: {most} displays on one hand with a moving contact of {moving_mw} mW each"
    );
    let key = "hand_power.over_60s_mw";
    let found = format!("{hand_mw} mW");
    Err(Failure::File(limits.source.bad_found(key, expected, found)))
}

/// Strokes that are known beforehand do not keep to the grid: while one runs, other displays on its boards wait. A burst
/// that would meet it does not begin.
fn leave_to_strokes(
    setup: &Setup,
    fingers: &mut [(&Place, &mut Projector)],
) -> Result<(), Failure> {
    for own in 0..fingers.len() {
        let (place, projector) = &fingers[own];
        let burst = projector.timing().duration + projector.guard().surplus();
        let mut left = Vec::new();
        for (index, (other, theirs)) in fingers.iter().enumerate() {
            if index == own || !share(place, other) {
                continue;
            }
            let off = theirs.guard().surplus();
            let spans = theirs.strokes().iter();
            let spans = spans.map(|(start, end)| (*start - burst, *end + off));
            left.extend(spans.clone());
            let meets = |(start, _): &(Instant, Instant)| {
                let mut spans = spans.clone();
                spans.find(|(from, to)| from <= start && start < to)
            };
            let mut strokes = projector.strokes().iter().enumerate();
            if let Some((number, (_, end))) = strokes.find_map(|(n, s)| Some((n, meets(s)?))) {
                let key = format!("fingers[{own}].strokes[{number}].start_s");
                let ends_s = end.as_micros() as f64 * 1e-6;
                let expected = format!(
                    "a stroke that begins at {ends_s} s or ends before: until then one of display `{}` has a board that both are on",
                    other.display()
                );
                return Err(Failure::File(setup.scene.source.bad(&key, expected)));
            }
        }
        fingers[own].1.leave(&left);
    }
    Ok(())
}

/// Gives every finger its place on the grid of onsets. Bursts of those that share a board never meet; within a burst the
/// guard keeps a board's wires apart, so at most one wire's current flows per board. Boards of one bus are written one
/// after the other, so that no onset and no end of one waits for another's.
///
/// # Errors
/// [`Failure::File`] for a bench whose boards or whose hand cannot be shared so.
pub fn stagger(setup: &Setup, mut fingers: Vec<(&Place, &mut Projector)>) -> Result<(), Failure> {
    check_hands(setup)?;
    leave_to_strokes(setup, &mut fingers)?;
    let places: Vec<&Place> = fingers.iter().map(|(place, _)| *place).collect();
    let groups = groups(&places);
    let write = write_time(&places);
    let mut ranks: Vec<u64> = Vec::new();
    for (index, place) in places.iter().enumerate() {
        let earlier = places[..index].iter().zip(&ranks);
        let taken = earlier.filter(|(other, _)| share(other, place));
        let taken: Vec<u64> = taken.map(|(_, rank)| *rank).collect();
        ranks.extend((0..).find(|rank| !taken.contains(rank)));
    }
    let slots = ranks.iter().max().map_or(1, |most| most + 1);
    for (index, (place, projector)) in fingers.into_iter().enumerate() {
        let (timing, off) = (projector.timing(), projector.guard().surplus());
        let soa_us = timing.soa.as_micros();
        let burst = timing.duration + off;
        if slots > 1 && soa_us / slots < burst.as_micros() {
            let ms = |d: Duration| d.as_micros() as f64 * 1e-3;
            let most = soa_us / burst.as_micros();
            let expected = format!(
                "at most {most} per board: bursts of {} ms and {} ms until all is off, one after the other within {} ms from onset to onset",
                ms(timing.duration),
                ms(off),
                ms(timing.soa)
            );
            let found = format!("{slots} that share boards");
            let error = setup.bench.source.bad_found("displays", expected, found);
            return Err(Failure::File(error));
        }
        // Groups of the same bus before its own.
        let first = |other: &usize| groups[*other] == *other && *other < groups[index];
        let before = (0..index).filter(|other| first(other) && places[*other].bus == place.bus);
        let wait_us = before.count() as u64 * write.as_micros();
        projector.begin_at(Instant::from_micros(
            soa_us * ranks[index] / slots + wait_us,
        ));
    }
    Ok(())
}
