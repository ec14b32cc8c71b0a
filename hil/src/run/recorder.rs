//! From what the loop reports to the canonical trace.

use palpate_core::projector::{Cause, FrameReport, Observer, Target};
use palpate_core::schedule::Entry;
use palpate_core::units::{Board, Instant, Point};
use palpate_records::trace::{Event, PlaceUm};

use crate::files::Touch;

/// Micrometres of a place in millimetres, rounded.
pub fn um(p: Point) -> PlaceUm {
    let um = |mm: f32| (f64::from(mm) * 1e3).round() as i32;
    PlaceUm {
        x: um(p.x),
        y: um(p.y),
    }
}

/// What truly touches the driving module: where, and how hard (N), when exactly one thing does.
pub fn truth(touches: &[Touch], drives: usize, at: Instant) -> Option<(Point, f64)> {
    let seconds = at.as_micros() as f64 * 1e-6;
    let mut now = touches
        .iter()
        .filter(|t| t.module == drives)
        .filter_map(|t| t.at(seconds));
    let only = now.next().filter(|t| t.force_n > 0.0)?;
    now.next()
        .is_none()
        .then(|| (Point::new(only.x_mm as f32, only.y_mm as f32), only.force_n))
}

/// An onset whose sensation is not known yet.
#[derive(Clone, Copy, Debug)]
pub struct Onset {
    /// When.
    pub at: Instant,
    /// Where the only contact was on the display; `None` for none or several.
    pub target: Option<Point>,
}

/// Collects a run.
#[derive(Debug, Default)]
pub struct Recorder {
    /// What happened.
    pub events: Vec<Event>,
    /// Frames compressed.
    pub frames: u32,
    /// Contacts over all frames.
    pub contacts: u64,
    /// Stimuli with a pulse.
    pub stimuli: u64,
    /// Times the guard applied something other than what was requested.
    pub limiter_events: u32,
    /// Intensities of all contacts, raw counts: what static levels are found over.
    pub intensities: Vec<f32>,
    /// The newest onset.
    pub onset: Option<Onset>,
    /// The scene's touches and the driving module, where an emulated skin knows the truth.
    truth: Option<(Vec<Touch>, usize)>,
}

impl Recorder {
    /// For a skin whose touches are known, or not.
    pub fn new(truth: Option<(Vec<Touch>, usize)>) -> Self {
        Self {
            truth,
            ..Self::default()
        }
    }

    /// Where the driving module is truly touched.
    pub fn truth_at(&self, at: Instant) -> Option<(Point, f64)> {
        let (touches, drives) = self.truth.as_ref()?;
        truth(touches, *drives, at)
    }
}

impl Observer for Recorder {
    fn frame(&mut self, report: &FrameReport<'_>) {
        let t_us = report.at.as_micros();
        self.frames += 1;
        let in_contact = report.relative.contacts().len();
        let peak = report
            .relative
            .magnitude()
            .iter()
            .fold(0.0f32, |m, &v| m.max(v));
        self.events.push(Event::Frame {
            t_us,
            frame: report.number,
            in_contact: u16::try_from(in_contact).unwrap_or(u16::MAX),
            peak_counts: peak.round() as u32,
        });
        for contact in report.contacts {
            self.contacts += 1;
            self.intensities.push(contact.intensity);
            self.events.push(Event::Contact {
                t_us,
                frame: report.number,
                module: contact.module,
                contact: contact.id,
                place: um(contact.place),
                intensity_milli: (f64::from(contact.intensity) * 1e3).round() as u32,
                level: contact.level,
                members: contact.members,
            });
        }
        if let Some((place, force_n)) = self.truth_at(report.at) {
            let force_mn = (force_n * 1e3).round() as u32;
            self.events.push(Event::Truth {
                t_us,
                place: um(place),
                force_mn,
            });
        }
    }

    fn entry(&mut self, entry: &Entry) {
        self.stimuli += u64::from(entry.width().get() > 0);
        self.limiter_events += u32::from(entry.reason.is_some());
        self.events.push(Event::Schedule(*entry));
    }

    fn onset(&mut self, at: Instant, targets: &[Target]) {
        let target = if let [only] = targets {
            Some(only.place)
        } else {
            None
        };
        self.onset = Some(Onset { at, target });
    }

    fn all_off(&mut self, at: Instant, board: Board, cause: Cause) {
        self.events.push(Event::AllOff {
            t_us: at.as_micros(),
            board: board.0,
            cause: cause.word(),
        });
    }
}
