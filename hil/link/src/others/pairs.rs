//! Contacts of the two ends side by side: each frame of the wearer with its frame of the robot.

use std::collections::BTreeMap;
use std::path::Path;

use palpate_files::Format;
use palpate_live::output::{Outputs, make_folder};
use palpate_records::contacts_csv::{write_header, write_rows};
use palpate_records::mcap::decode;
use palpate_records::trace::{PlaceUm, event};
use palpate_run::Failure;

/// Age that the guard lets a frame have, microseconds: its time is unknown by as much, beside the clocks.
const AGE_US: u64 = 100_000;

/// The contacts of one frame, as of one time.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    t_us: u64,
    contacts: Vec<event::Contact>,
}

/// Frames with contacts, from messages of `/contacts` in the order of time.
pub(super) fn frames<'a>(messages: impl Iterator<Item = (u64, &'a [u8])>) -> Vec<Frame> {
    let mut all: Vec<Frame> = Vec::new();
    for (t_us, data) in messages {
        // A damaged one is left out.
        let Some(contact) = decode(data) else {
            continue;
        };
        let contact = event::Contact { t_us, ..contact };
        match all.last_mut().filter(|frame| frame.t_us == t_us) {
            Some(frame) => frame.contacts.push(contact),
            None => all.push(Frame {
                t_us,
                contacts: vec![contact],
            }),
        }
    }
    all
}

/// A contact without its time and frame, which each end counts for itself.
const fn said(contact: &event::Contact) -> (u16, PlaceUm, u32, u16) {
    (
        contact.module,
        contact.place,
        contact.intensity_milli,
        contact.level,
    )
}

/// The wearer's frames at the robot's times and under its numbers, each by the robot's frame with the same contacts. A
/// frame without such a one near keeps its own. Returns the number of frames that have one, too.
pub(super) fn paired(robot: &[Frame], wearer: &[Frame], within_us: u64) -> (Vec<Frame>, usize) {
    let within_us = within_us.saturating_add(AGE_US);
    let (mut next, mut same) = (0, 0);
    let mut all: BTreeMap<u64, Frame> = BTreeMap::new();
    for frame in wearer {
        let from = frame.t_us.saturating_sub(within_us);
        let until = frame.t_us.saturating_add(within_us);
        let begin = next.max(robot.partition_point(|r| r.t_us < from));
        let near = robot[begin..].iter().take_while(|r| r.t_us <= until);
        let says = |of: &Frame| of.contacts.iter().map(said).collect::<Vec<_>>();
        let own = says(frame);
        let found = near
            .into_iter()
            .position(|r| says(r) == own)
            .map(|at| begin + at);
        let mut frame = frame.clone();
        if let Some(found) = found {
            (next, same) = (found + 1, same + 1);
            take_over(&mut frame, &robot[found]);
        }
        all.entry(frame.t_us).or_insert(frame);
    }
    (all.into_values().collect(), same)
}

/// Takes over time and number of a frame with the same contacts.
fn take_over(frame: &mut Frame, same: &Frame) {
    frame.t_us = same.t_us;
    for (contact, of_same) in frame.contacts.iter_mut().zip(&same.contacts) {
        (contact.t_us, contact.frame) = (of_same.t_us, of_same.frame);
    }
}

/// Writes the contacts of frames, as `hil diff` reads them.
pub(super) fn write(
    folder: &Path,
    name: &str,
    frames: &[Frame],
    force: bool,
) -> Result<(), Failure> {
    make_folder(folder)?;
    let outputs = Outputs::new(force);
    outputs.write(&folder.join(name), Format::Contacts, |out| {
        write_header(&[], out)?;
        frames
            .iter()
            .try_for_each(|frame| write_rows(&frame.contacts, &[], out))
    })
}

#[cfg(test)]
#[path = "pairs_tests.rs"]
mod tests;
