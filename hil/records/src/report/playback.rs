//! Data for the playback of the page's script: taxels, contacts
//! and felt places over time, as numbers in a bounded space.
//!
//! The script reads what the wires do off the schedule's own bars.

use super::paths::TAXELS;
use super::series::scan_us;
use super::svg::Plot;
use super::timeplot::tenth_ms;
use crate::measure::length_us;
use crate::readings::{Reading, Readings};
use crate::trace::{FeltAt, PlaceUm, Trace, event};
use std::fmt::Write;

/// Most contacts and felt places: what is beyond goes frame by frame, evenly.
const CONTACTS: usize = 5_000;
const FELT: usize = 3_000;
/// Most frames with taxels, and the most bytes they may take.
const FRAMES: usize = 3_000;
const BYTES: usize = 300_000;
/// A skin that never had more counts is drawn against these: noise is no touch.
const FAINT: u16 = 100;
/// Steps of a taxel's value, told as one letter each.
const LEVELS: u16 = 61;
/// The letter of the lowest step; digits are left for runs of zeros.
const FIRST: u8 = b'A';

/// Numbers, each time from the one before.
struct Rows {
    out: String,
    before: i64,
}

impl Rows {
    const fn new() -> Self {
        Self {
            out: String::new(),
            before: 0,
        }
    }

    fn add(&mut self, t_us: u64, more: &[i64]) {
        let now = tenth_ms(t_us);
        let comma = if self.out.is_empty() { "" } else { "," };
        let _ = write!(self.out, "{comma}{}", now.saturating_sub(self.before));
        for value in more {
            let _ = write!(self.out, ",{value}");
        }
        self.before = now;
    }
}

fn xy(p: PlaceUm) -> [i64; 2] {
    [i64::from(p.x), i64::from(p.y)]
}

/// The contacts, and of how many frames one is told.
fn contacts(trace: &Trace) -> (String, usize) {
    let contacts = trace.each::<event::Contact>();
    let every = contacts.clone().count().div_ceil(CONTACTS).max(1);
    let mut rows = Rows::new();
    for now in contacts.filter(|now| (now.frame as usize).is_multiple_of(every)) {
        let [x, y] = xy(now.place);
        let counts = i64::from(now.intensity_milli / 1000);
        rows.add(
            now.t_us,
            &[now.module.into(), now.contact.into(), x, y, counts],
        );
    }
    (rows.out, every)
}

/// Places at which onsets were aimed and felt, and the number of onsets of which one is told; a break is felt nowhere.
fn felt(trace: &Trace) -> (String, usize) {
    let onsets = trace.each::<event::Felt>();
    let every = onsets.clone().count().div_ceil(FELT).max(1);
    let mut rows = Rows::new();
    for onset in onsets.step_by(every) {
        let felt = onset.met.filter(FeltAt::is_felt).map(|f| f.energy);
        let ([x, y], [u, v]) = (xy(onset.target), xy(felt.unwrap_or_default()));
        rows.add(onset.t_us, &[x, y, i64::from(felt.is_some()), u, v]);
    }
    (rows.out, every)
}

/// A frame: a letter per taxel, and the length of each run of zeros.
fn letters(out: &mut String, frame: &[Reading], most: u16) {
    let mut zeros = 0;
    for reading in frame {
        let level = u32::from(reading[3]) * u32::from(LEVELS) / u32::from(most);
        if level == 0 {
            zeros += 1;
            continue;
        }
        if zeros > 0 {
            let _ = write!(out, "{zeros}");
            zeros = 0;
        }
        let letter = FIRST + level as u8;
        // A backslash would need another one.
        out.push(char::from(if letter == b'\\' { b'!' } else { letter }));
    }
    out.push('.');
}

/// The driving module's taxels over time; empty where nothing was kept.
fn taxels(readings: &Readings) -> String {
    let largest = readings
        .driving()
        .flat_map(|(_, all)| all.iter().map(|r| r[3]));
    let Some(most) = largest.max().map(|m| m.max(FAINT)) else {
        return String::new();
    };
    let mut every = readings.driving().len().div_ceil(FRAMES).max(1);
    loop {
        let (mut times, mut values) = (Rows::new(), String::new());
        for (t_us, frame) in readings.driving().step_by(every) {
            times.add(t_us, &[]);
            letters(&mut values, frame, most);
        }
        if values.len() <= BYTES || every > FRAMES {
            let levels = LEVELS;
            let t = times.out;
            return format!("\"most\":{most},\"levels\":{levels},\"t\":[{t}],\"v\":\"{values}\"");
        }
        every *= 2;
    }
}

/// Scale and offset along x and y that make pixels of a plane of its millimetres.
fn to_pixels(plot: &Plot) -> [f64; 4] {
    let ((x, y), (right, up)) = (plot.at((0.0, 0.0)), plot.at((1.0, 1.0)));
    [right - x, x, up - y, y].map(|v| (v * 1e3).round() / 1e3)
}

/// The numbers as a block of the page, with the planes of skin and display.
pub(super) fn data(
    page: &mut String,
    trace: &Trace,
    readings: Option<&Readings>,
    planes: [&Plot; 2],
) {
    let (contacts, every) = contacts(trace);
    let scan = scan_us(trace).unwrap_or(10_000.0) as u64;
    // A contact is there until two more frames came without it.
    let hold = tenth_ms(scan.saturating_mul(every as u64).saturating_mul(5) / 2);
    let (felt, every) = felt(trace);
    let soa = tenth_ms(trace.header.soa_us.saturating_mul(every as u64)).max(1);
    let played = readings.filter(|_| trace.header.taxels.len() <= TAXELS);
    let taxels = played.map(taxels).unwrap_or_default();
    let [pad, display] = planes.map(to_pixels);
    let _ = writeln!(
        page,
        "<script type=\"application/json\" id=\"run\">{{\"end\":{},\"hold\":{hold},\"soa\":{soa},\"pad\":{pad:?},\
         \"display\":{display:?},\n\"contacts\":[{contacts}],\n\"felt\":[{felt}],\n\"taxels\":{{{taxels}}}}}</script>",
        tenth_ms(length_us(trace)).max(1),
    );
}

#[cfg(test)]
#[path = "playback_tests.rs"]
mod tests;
