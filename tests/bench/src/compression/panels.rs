//! Panels of the thesis's figures 4.5 to 4.7 beside the places of contacts: pressure along the edges, readouts and
//! intensity levels, raw readouts over time, the fullest frame, contacts and speed over time.

use std::collections::BTreeMap;

use palpate_files::Setup;
use palpate_live::host;
use palpate_live::views::Wanted;
use palpate_records::readings::Readings;
use palpate_records::trace::{Event, event};
use palpate_run::{Failure, Input, Keep, KeptReadings, Outcome};

use crate::findings::Findings;
use crate::plot::{Axis, Mark, Plot, Series};

/// Bars of a histogram, as in figure 4.7.
const BARS: usize = 24;
/// Height of the intensity levels' marks, below the bars.
const RUG: f64 = 0.5;
/// Number of frames of which one is drawn over time.
const DRAWN: usize = 4;

/// A run that keeps every taxel's readings.
///
/// # Errors
/// The errors of [`host::run`].
pub(super) fn kept(setup: &Setup, input: &Input) -> Result<Outcome, Failure> {
    let keep = Keep {
        readings: KeptReadings::All,
        ..Keep::default()
    };
    host::run(setup, input, 1, keep, Wanted::default())
}

/// Taxels in contact of every frame, by its time in microseconds.
fn in_contact(outcome: &Outcome) -> BTreeMap<u64, usize> {
    let frame = |event: &Event| match event {
        Event::Frame(event::Frame {
            t_us, in_contact, ..
        }) => Some((*t_us, usize::from(*in_contact))),
        _ => None,
    };
    outcome.trace.events.iter().filter_map(frame).collect()
}

fn seconds(t_us: u64) -> f64 {
    t_us as f64 * 1e-6
}

/// Readings of every frame: time, and each taxel's distance from its reference, strongest first, with those in
/// contact.
struct Frames<'a> {
    readings: &'a Readings,
    in_contact: BTreeMap<u64, usize>,
}

impl<'a> Frames<'a> {
    fn new(outcome: &'a Outcome) -> Option<Self> {
        Some(Self {
            readings: outcome.readings.as_ref()?,
            in_contact: in_contact(outcome),
        })
    }

    /// Time, and magnitudes of all taxels, counts.
    fn magnitudes(&self) -> impl Iterator<Item = (u64, Vec<u16>)> {
        let frames = self.readings.frames().iter();
        frames.map(|f| (f.t_us, f.readings.iter().map(|r| r[3]).collect()))
    }

    /// The frame with the most taxels in contact.
    fn fullest(&self) -> Option<u64> {
        let fuller = |a: &(&u64, &usize), b: &(&u64, &usize)| a.1.cmp(b.1).then(b.0.cmp(a.0));
        self.in_contact.iter().max_by(fuller).map(|(t, _)| *t)
    }
}

/// Figure 4.5-A's edges: how all pressure, and all contacts, are spread along x and along y.
pub(super) fn edges(findings: &mut Findings, name: &str, title: &str, outcome: &Outcome) {
    let Some(frames) = Frames::new(outcome) else {
        return;
    };
    let Some(module) = frames.readings.modules().first() else {
        return;
    };
    let mut pressure = [BTreeMap::new(), BTreeMap::new()];
    for (_, magnitudes) in frames.magnitudes() {
        for (place, magnitude) in module.taxels.iter().zip(magnitudes) {
            for (axis, at) in pressure.iter_mut().zip([place.x, place.y]) {
                *axis.entry(at).or_insert(0.0) += f64::from(magnitude);
            }
        }
    }
    // A contact counts for the two taxels between which it lies.
    let mut contacts = pressure
        .each_ref()
        .map(|axis| axis.keys().map(|k| (*k, 0.0)).collect::<BTreeMap<_, _>>());
    for event in &outcome.trace.events {
        if let Event::Contact(event::Contact { place, .. }) = event {
            for (axis, at) in contacts.iter_mut().zip([place.x, place.y]) {
                share(axis, at);
            }
        }
    }
    let course = |axis: &BTreeMap<i32, f64>| {
        let all: f64 = axis.values().sum();
        let point = |(at, sum): (&i32, &f64)| (f64::from(*at) * 1e-3, 100.0 * sum / all.max(1.0));
        axis.iter().map(point).collect::<Vec<_>>()
    };
    let [px, py] = pressure.each_ref().map(course);
    let [cx, cy] = contacts.each_ref().map(course);
    let plot = Plot {
        x: Axis::linear("x or y [mm]"),
        y: Axis::linear("share [%]"),
        series: vec![
            Series::new("pressure along x", Mark::Swept, px),
            Series::new("contacts along x", Mark::Swept, cx),
            Series::new("pressure along y", Mark::Swept, py),
            Series::new("contacts along y", Mark::Swept, cy),
        ],
    };
    let words =
        "All readouts of the run summed per column and per row of taxels, and its contacts.";
    findings.figures.push(plot.figure(name, title, words));
}

/// Shares a contact between the columns on both sides of it.
fn share(axis: &mut BTreeMap<i32, f64>, at: i32) {
    let below = axis.range(..=at).next_back().map(|(k, _)| *k);
    let above = axis.range(at..).next().map(|(k, _)| *k);
    let (Some(low), Some(high)) = (below.or(above), above.or(below)) else {
        return;
    };
    let part = if high > low {
        f64::from(at - low) / f64::from(high - low)
    } else {
        0.0
    };
    for (key, part) in [(low, 1.0 - part), (high, part)] {
        if let Some(sum) = axis.get_mut(&key) {
            *sum += part;
        }
    }
}

/// Figure 4.5-B, and the top of 4.7: readouts as a histogram of 24 bars, those in contact apart, with the levels' mean
/// intensities below.
pub(super) fn histogram(findings: &mut Findings, name: &str, title: &str, outcome: &Outcome) {
    let Some(frames) = Frames::new(outcome) else {
        return;
    };
    let (mut active, mut idle) = (Vec::new(), Vec::new());
    for (t_us, mut magnitudes) in frames.magnitudes() {
        let count = frames.in_contact.get(&t_us).copied().unwrap_or(0);
        magnitudes.sort_unstable_by(|a, b| b.cmp(a));
        let (touched, rest) = magnitudes.split_at(count.min(magnitudes.len()));
        active.extend_from_slice(touched);
        idle.extend_from_slice(rest);
    }
    let most = active.iter().chain(&idle).max().copied().unwrap_or(0);
    let width = (f64::from(most) / BARS as f64).max(1.0);
    let bars = |values: &[u16]| {
        let mut counts = [0u32; BARS];
        for value in values {
            let bar = (f64::from(*value) / width) as usize;
            counts[bar.min(BARS - 1)] += 1;
        }
        let bar = |(n, count): (usize, u32)| ((n as f64 + 0.5) * width, f64::from(count));
        counts.into_iter().enumerate().map(bar).collect::<Vec<_>>()
    };
    let mut levels: BTreeMap<u16, (f64, f64)> = BTreeMap::new();
    for event in &outcome.trace.events {
        if let Event::Contact(event::Contact {
            level,
            intensity_milli,
            ..
        }) = event
        {
            let (sum, count) = levels.entry(*level).or_default();
            *sum += f64::from(*intensity_milli) * 1e-3;
            *count += 1.0;
        }
    }
    let rug = levels.values().map(|(sum, count)| (sum / count, RUG));
    let tallest = (idle.len() + active.len()).max(1) as f64;
    let plot = Plot {
        x: Axis::linear("distance from the reference [counts]").span(0.0, width * BARS as f64),
        y: Axis::decades("readouts").span(RUG, tallest * 2.0),
        series: vec![
            Series::new("not in contact", Mark::Bars, bars(&idle)),
            Series::new("in contact", Mark::Bars, bars(&active)),
            Series::new("intensity levels", Mark::Crosses, rug.collect()),
        ],
    };
    let words = "All readouts of the run in 24 bars. Of a frame with n taxels in contact, the n strongest count as such.";
    findings.figures.push(plot.figure(name, title, words));
}

/// Figure 4.5-C: raw magnitudes over time, with the first contact and the fullest frame.
pub(super) fn raw(findings: &mut Findings, name: &str, title: &str, outcome: &Outcome) {
    let Some(frames) = Frames::new(outcome) else {
        return;
    };
    let mut taxels: Vec<Vec<(f64, f64)>> = Vec::new();
    for (t_us, magnitudes) in frames.magnitudes().step_by(DRAWN) {
        taxels.resize_with(magnitudes.len(), Vec::new);
        for (course, magnitude) in taxels.iter_mut().zip(magnitudes) {
            course.push((seconds(t_us), f64::from(magnitude)));
        }
    }
    let course = |(n, points)| Series::new(format!("taxel {n}"), Mark::Line, points);
    let mut series: Vec<Series> = taxels.into_iter().enumerate().map(course).collect();
    let first = frames.in_contact.iter().find(|(_, n)| **n > 0);
    let marks = [first.map(|(t, _)| *t), frames.fullest()];
    let marks = marks.into_iter().flatten().map(|t| (seconds(t), 0.0));
    let marked = "first contact, fullest frame";
    series.push(Series::new(marked, Mark::Crosses, marks.collect()));
    let plot = Plot::over_time(Axis::linear("distance from the reference [counts]"), series);
    let words = "Every taxel of the driving module, one frame of four.";
    findings.figures.push(plot.figure(name, title, words));
}

/// Figures 4.6-A and C: the frame with the most taxels in contact, as contacts of more and more clusters.
pub(super) fn fullest(
    findings: &mut Findings,
    name: &str,
    title: &str,
    (outcome, clusters): (&Outcome, &[(u32, Outcome)]),
) {
    let Some(frames) = Frames::new(outcome) else {
        return;
    };
    let (Some(at), Some(module)) = (frames.fullest(), frames.readings.modules().first()) else {
        return;
    };
    let count = frames.in_contact.get(&at).copied().unwrap_or(0);
    let here = frames.magnitudes().find(|(t, _)| *t == at);
    let mut strongest: Vec<_> = module
        .taxels
        .iter()
        .zip(here.map_or(Vec::new(), |(_, magnitudes)| magnitudes))
        .collect();
    strongest.sort_by_key(|s| std::cmp::Reverse(s.1));
    let mm = |um: i32| f64::from(um) * 1e-3;
    let touched = strongest
        .iter()
        .take(count)
        .map(|(p, _)| (mm(p.x), mm(p.y)));
    let mut series = vec![Series::new(
        format!("{count} taxels in contact"),
        Mark::Places,
        touched.collect(),
    )];
    for (kc, outcome) in clusters.iter().rev() {
        let place = |event: &Event| match event {
            Event::Contact(event::Contact { t_us, place, .. }) if *t_us == at => {
                Some((mm(place.x), mm(place.y)))
            }
            _ => None,
        };
        let places = outcome.trace.events.iter().filter_map(place).collect();
        series.push(Series::new(format!("K_C = {kc}"), Mark::Places, places));
    }
    let plot = Plot::of_plane(series);
    let words =
        "One frame: where contacts are found with K_C from 1 to as many as there are taxels.";
    findings.figures.push(plot.figure(name, title, words));
}

/// The bottom of figure 4.7: taxels in contact and, in a figure of its own, frames per second, over time.
pub(super) fn course(
    findings: &mut Findings,
    name: &str,
    title: &str,
    clusters: &[(u32, Outcome)],
) {
    let Some((_, first)) = clusters.first() else {
        return;
    };
    let held = in_contact(first).into_iter();
    let held = held.map(|(t_us, count)| (seconds(t_us), count as f64));
    let plot = Plot::over_time(
        Axis::linear("taxels in contact"),
        vec![Series::new("taxels in contact", Mark::Line, held.collect())],
    );
    let words = "Taxels above the contact threshold, frame by frame.";
    findings.figures.push(plot.figure(name, title, words));
    let speed = |(kc, outcome): &(u32, Outcome)| {
        let times = in_contact(outcome).into_keys().zip(&outcome.frame_us);
        let speeds = times.map(|(t_us, us)| (seconds(t_us), 1e6 / f64::from(*us)));
        let speeds = speeds.step_by(DRAWN).collect();
        Series::new(format!("K_C = {kc}"), Mark::Line, speeds)
    };
    let plot = Plot::over_time(
        Axis::decades("frames per second [Hz]"),
        clusters.iter().map(speed).collect(),
    );
    let words = "Speed of the whole loop, one frame of four, on this machine.";
    let (name, title) = (format!("{name}-speed"), format!("{title}, speed"));
    findings.figures.push(plot.figure(&name, &title, words));
}
