//! Recorder: from the loop's reports to the canonical trace.

use std::collections::BTreeSet;

use palpate_core::contact::Scope;
use palpate_core::guard::Guard;
use palpate_core::projector::{Cause, FrameReport, Observer, Projector, Target, TextureReport};
use palpate_core::schedule::Entry;
use palpate_core::skin::{Condition, Layout};
use palpate_core::units::{Board, Duration, Instant, Point, Ticks};
use palpate_records::felt::FeltPath;
use palpate_records::readings::Readings;
use palpate_records::trace::{Driven, Event, PlaceUm, event};
use palpate_records::words::texture;

use crate::fingers::Fingers;
use crate::hand::Hand;
use crate::onsets::Onsets;
use palpate_files::{Finger, Joint, Setup, Touch, TouchPoint};

/// Windows of texture further apart are of different touches.
const APART: Duration = Duration::from_millis(500);

/// Thousandths of a degree; `None` for a display without wires.
pub(crate) fn milli_c(celsius: f64) -> Option<i32> {
    celsius.is_finite().then(|| (celsius * 1e3).round() as i32)
}

/// Stimuli that stand for a run, 2 MB of them: a quarter of an hour on all wires of a fingertip.
const ROUND: usize = 1 << 15;
/// Longest session that is told apart from an endless one.
const DAY: Duration = Duration::from_millis(24 * 3_600_000);

/// Events that are looked through at once for those that a summary reads.
const UNREAD: usize = 1 << 10;

/// True touches of the driving module.
#[derive(Debug, Default)]
pub enum Truth {
    /// Unknown: a recording, readings that are pushed, a real skin.
    #[default]
    Unknown,
    /// A scene's touches that drive the display, each with the offset (mm) from its own places to the driving plane.
    Scene(Vec<(Touch, [f64; 2])>),
    /// A hand on the driving module.
    Hand(Hand),
    /// A scene's touches and fingers; the touches with their offsets (mm), and the offset of each module that drives.
    Played(Vec<(Touch, [f64; 2])>, Fingers, Vec<Option<[f64; 2]>>),
}

impl Truth {
    /// Truth of a setup's scene: the driving module's touches, or where the skin is one, all of them.
    pub fn of_scene(setup: &Setup) -> Self {
        let scene = &setup.scene.value;
        match scene.compression.scope {
            Scope::Skin => Self::on(setup, true, |_| true),
            Scope::Module => Self::on(setup, false, |module| module == scene.drives),
        }
    }

    /// Truth of a setup's scene that fingers join.
    pub fn played(setup: &Setup, fingers: &Fingers) -> Self {
        let scene = &setup.scene.value;
        let whole = scene.compression.scope == Scope::Skin;
        let modules = setup.sensor.value.modules.iter().enumerate();
        let drives = modules.map(|(number, module)| match whole {
            true => Some(module.place_mm),
            false => (number == scene.drives).then_some([0.0; 2]),
        });
        let drives = drives.collect();
        match Self::of_scene(setup) {
            Self::Scene(touches) => Self::Played(touches, fingers.clone(), drives),
            other => other,
        }
    }

    /// Truth of one of several fingers: the touches of the module that drives it, or where its modules are one skin, of
    /// all of them.
    pub fn of_finger(setup: &Setup, finger: &Finger) -> Self {
        let driving = match finger.merged {
            true => finger.modules.as_slice(),
            false => &finger.modules[..1],
        };
        Self::on(setup, finger.merged, |module| driving.contains(&module))
    }

    /// The touches of modules that drive; where these are one skin, in its plane.
    fn on(setup: &Setup, whole: bool, drives: impl Fn(usize) -> bool) -> Self {
        let place = |touch: &Touch| match setup.sensor.value.modules.get(touch.module) {
            Some(module) if whole => module.place_mm,
            _ => [0.0; 2],
        };
        let touches = setup.scene.value.touches.iter();
        let driving = touches.filter(|touch| drives(touch.module));
        Self::Scene(driving.map(|t| (t.clone(), place(t))).collect())
    }

    /// Place and force (N) of the only touch; `None` for none or several.
    fn at(&self, at: Instant) -> Option<(Point, f64)> {
        match self {
            Self::Unknown => None,
            Self::Scene(touches) => only(touching(touches, seconds(at))),
            Self::Played(..) => only(self.playing(seconds(at)).into_iter()),
            Self::Hand(hand) => hand.only(),
        }
    }

    /// Every place that is pressed; `None` where that is unknown.
    fn places(&self, at: Instant) -> Option<Vec<Point>> {
        let t_s = seconds(at);
        let pressed = |all: Vec<_>| all.into_iter().filter_map(pressing).map(|p| p.0).collect();
        match self {
            Self::Unknown => None,
            Self::Scene(touches) => Some(pressed(touching(touches, t_s).collect())),
            Self::Played(..) => Some(pressed(self.playing(t_s))),
            Self::Hand(hand) => Some(hand.places()),
        }
    }

    /// Touches of a scene that fingers join.
    fn playing(&self, t_s: f64) -> Vec<(TouchPoint, [f64; 2])> {
        let Self::Played(touches, fingers, drives) = self else {
            return Vec::new();
        };
        let mut here: Vec<_> = touching(touches, t_s).collect();
        fingers.each(|touch| {
            let offset = drives.get(touch.module).copied().flatten();
            here.extend(touch.at(t_s).zip(offset));
        });
        here
    }
}

fn seconds(at: Instant) -> f64 {
    at.as_micros() as f64 * 1e-6
}

/// Touches at a time, each with its offset, mm.
fn touching(
    touches: &[(Touch, [f64; 2])],
    t_s: f64,
) -> impl Iterator<Item = (TouchPoint, [f64; 2])> {
    let here = move |(touch, offset): &(Touch, [f64; 2])| Some((touch.at(t_s)?, *offset));
    touches.iter().filter_map(here)
}

/// The only one of the touches, if it presses.
fn only(mut now: impl Iterator<Item = (TouchPoint, [f64; 2])>) -> Option<(Point, f64)> {
    let only = now.next().and_then(pressing)?;
    now.next().is_none().then_some(only)
}

/// Place and force (N) of a touch that presses.
fn pressing((touch, [x, y]): (TouchPoint, [f64; 2])) -> Option<(Point, f64)> {
    let place = Point::new((touch.x_mm + x) as f32, (touch.y_mm + y) as f32);
    (touch.force_n > 0.0).then_some((place, touch.force_n))
}

/// An onset whose sensation is not known yet.
#[derive(Clone, Debug)]
pub struct Onset {
    /// Time of the onset.
    pub at: Instant,
    /// The contacts on the display.
    pub targets: Vec<Target>,
    /// Stimuli of the onset: requested and applied by the guard.
    pub entries: Vec<Entry>,
}

/// Recorder of a run.
#[derive(Debug, Default)]
pub struct Recorder {
    /// Events so far, in the order in which they were noticed.
    pub events: Vec<Event>,
    /// Frames compressed.
    pub frames: u32,
    /// Contacts over all frames.
    pub contacts: u64,
    /// Counts of the stimuli.
    pub driven: Driven,
    /// The newest reading of every taxel, raw counts, NaN for one that is left out; kept for a live view.
    pub counts: Option<Vec<f32>>,
    /// Readings of every taxel, where they are kept.
    pub readings: Option<Readings>,
    /// Readings for a record that grows: its writer takes them, turn by turn.
    pub taxels: Option<Readings>,
    /// The newest onset.
    pub onset: Option<Onset>,
    /// Onsets projected, and those of them without a contact.
    pub onsets: (u64, u64),
    /// Touches at onsets, and whether they were felt.
    pub met: Onsets,
    /// `true` where a wire was driven since the newest onset was scored.
    pub pulsed: bool,
    /// Boards and channels of which a stimulus was asked.
    pub warmed: BTreeSet<(u8, u8)>,
    /// The first stimuli, `ROUND` at most, from which the longest session is computed.
    pub first: Vec<Entry>,
    /// The newest stimuli that all began at once.
    asked: Vec<Entry>,
    /// End of the newest window of texture.
    window: Option<Instant>,
    /// Windows of texture, and the sum of their roughness, thousandths.
    pub windows: (u32, u64),
    truth: Truth,
    /// Felt path so far, where a summary is enough and the truth is not known. Of the events only notes stay then.
    pub felt: Option<FeltPath>,
    /// Number of notes at the front of the events, which were looked through already.
    stayed: usize,
    /// Events that were looked through since the last time, for a record that is written while the run goes on.
    pub handed: Option<Vec<Event>>,
    /// Most events that are kept; the oldest are dropped. `None`: all are kept.
    most_events: Option<usize>,
    /// Events that were dropped for that.
    pub dropped: u64,
    /// The skin, for naming its taxels.
    layout: Option<Layout>,
    /// Joints whose angles are kept.
    pub joints: Vec<Joint>,
    /// Taxels whose health changed alike: time, module, condition, taxels. Not yet noted.
    changed: Option<(Instant, usize, Condition, Vec<usize>)>,
}

impl Recorder {
    /// A recorder for a skin, with its true touches where they are known.
    pub fn new(truth: Truth, layout: &Layout) -> Self {
        Self {
            truth,
            layout: Some(layout.clone()),
            ..Self::default()
        }
    }

    /// The recorder with so many events at most.
    #[must_use]
    pub const fn bounded(mut self, most_events: usize) -> Self {
        self.most_events = Some(most_events);
        self
    }

    /// Drops the older half of the events where there are too many. Where a summary is enough, drops all that it does
    /// not read.
    pub fn trim(&mut self) {
        if self.events.len() - self.stayed > UNREAD {
            self.pass_on();
        }
        let most = self.most_events.unwrap_or(usize::MAX);
        if self.events.len() > most {
            let surplus = self.events.len() - most / 2;
            self.events.drain(..surplus);
            self.dropped += surplus as u64;
        }
    }

    /// Looks through the new events, keeps notes, and hands all of them on, where a summary is enough.
    pub fn pass_on(&mut self) {
        if self.felt.is_none() {
            return;
        }
        // Without this, the change would be told when another taxel changes, which may be hours later.
        self.tell_taxels();
        let new = self.events.split_off(self.stayed);
        if let Some(path) = &mut self.felt {
            new.iter().for_each(|event| path.add(event));
        }
        let notes = new.iter().filter(|e| matches!(e, Event::Note(_)));
        self.events.extend(notes.cloned());
        self.stayed = self.events.len();
        if let Some(handed) = &mut self.handed {
            handed.extend(new);
        }
    }

    /// Longest session, s, that repeats this run until `end` over and over; `None` for a day and more.
    pub fn longest_session_s(&self, guard: &Guard, end: Instant) -> Option<f64> {
        let whole = self.first.len() < ROUND;
        let end = if whole { end } else { self.first.last()?.at };
        let shortest = self.warmed.iter().fold(DAY, |most, wire| {
            let own = self.first.iter();
            let own = own.filter(|e| (e.board.0, e.channel.0) == *wire);
            let bursts: Vec<_> = guard.booked(own).collect();
            let lasts = guard.lasts(&bursts, end.since(Instant::ZERO), most);
            lasts.unwrap_or(most)
        });
        (shortest < DAY).then(|| shortest.as_secs_f64())
    }

    /// Writes down the taxels whose health changed last.
    pub fn tell_taxels(&mut self) {
        let Some((at, module, condition, taxels)) = self.changed.take() else {
            return;
        };
        let name = self.layout.as_ref().and_then(|l| l.modules().get(module));
        let name = name.map_or("?", palpate_core::skin::Module::name);
        let list: Vec<String> = taxels.iter().map(usize::to_string).collect();
        let text = format!("taxels of {name}: {} {}", list.join(","), condition.word());
        self.note(at, text);
    }

    /// Adds a note.
    pub fn note(&mut self, at: Instant, text: String) {
        self.events.push(Event::note(at, text));
    }

    /// Notes what was done to the wires of a setup before its run.
    pub fn begin(&mut self, setup: &Setup) {
        if let Some(told) = &setup.told {
            self.note(Instant::ZERO, format!("hot pass: {told}"));
        }
    }

    /// Counts the onset that was just projected.
    pub fn count(&mut self, projector: &Projector) {
        if let Some(onset) = &self.onset {
            let truth = self.truth.places(onset.at);
            let targets = onset.targets.len();
            self.met.add(projector, targets, truth.as_deref());
        }
    }

    /// Number of touches that press on the driving module; none where that is not known.
    pub fn touches_at(&self, at: Instant) -> usize {
        self.truth.places(at).map_or(0, |places| places.len())
    }

    /// Place and force (N) of the only true touch; `None` for none, several or an unknown truth.
    pub fn truth_at(&self, at: Instant) -> Option<(Point, f64)> {
        self.truth.at(at)
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
        self.events.push(Event::Frame(event::Frame {
            t_us,
            frame: report.number,
            in_contact: u16::try_from(in_contact).unwrap_or(u16::MAX),
            peak_counts: peak.round() as u32,
        }));
        if let Some(counts) = &mut self.counts {
            let readings = report.relative.magnitude().iter();
            let readings = readings.zip(report.relative.usable());
            counts.clear();
            counts.extend(readings.map(|(v, usable)| if *usable { *v } else { f32::NAN }));
        }
        for readings in [&mut self.readings, &mut self.taxels].into_iter().flatten() {
            readings.push(t_us, report.relative);
        }
        for contact in report.contacts {
            self.contacts += 1;
            self.events.push(Event::Contact(event::Contact {
                t_us,
                frame: report.number,
                module: contact.module,
                contact: contact.id,
                place: PlaceUm::from(contact.place),
                intensity_milli: (f64::from(contact.intensity) * 1e3).round() as u32,
                level: contact.level,
                members: contact.members,
            }));
        }
        let t_s = report.at.as_micros() as f64 * 1e-6;
        for (number, joint) in (0..).zip(&self.joints) {
            self.events.push(Event::Joint(event::Joint {
                t_us,
                joint: number,
                milli_deg: (joint.at(t_s) * 1e3).round() as i32,
            }));
        }
        if let Some((place, force_n)) = self.truth_at(report.at) {
            let force_mn = (force_n * 1e3).round() as u32;
            self.events.push(Event::Truth(event::Truth {
                t_us,
                place: PlaceUm::from(place),
                force_mn,
            }));
        }
    }

    fn entry(&mut self, entry: &Entry) {
        self.driven.add(entry);
        self.pulsed |= entry.width() > Ticks::ZERO;
        self.warmed.insert((entry.board.0, entry.channel.0));
        if self.first.len() < ROUND {
            self.first.push(*entry);
        }
        // A burst may come in parts, all alike: the first one counts.
        if self.asked.first().is_some_and(|first| first.at != entry.at) {
            self.asked.clear();
        }
        self.asked.push(*entry);
        self.events.push(Event::Schedule(*entry));
    }

    fn onset(&mut self, at: Instant, targets: &[Target]) {
        self.onsets.0 += 1;
        self.onsets.1 += u64::from(targets.is_empty());
        let targets = targets.to_vec();
        let mut entries = std::mem::take(&mut self.asked);
        entries.retain(|entry| entry.at == at);
        self.onset = Some(Onset {
            at,
            targets,
            entries,
        });
    }

    fn texture(&mut self, report: &TextureReport<'_>) {
        let milli = |v: f64| (v * 1e3).round() as i32;
        let rough_permille = milli(report.roughness) as u16; // 0 to 1
        let latent = event::Latent {
            t_us: report.at.as_micros(),
            z_milli: report.latent.iter().map(|z| milli(f64::from(*z))).collect(),
            rough_permille,
            rate_mhz: report.control.rate_mhz,
        };
        let goes_on = |last: Instant| report.at.since(last) < APART;
        if !self.window.is_some_and(goes_on) {
            self.note(report.at, format!("texture felt: {}", texture(&latent)));
        }
        self.window = Some(report.at);
        self.windows.0 += 1;
        self.windows.1 += u64::from(rough_permille);
        self.events.push(Event::Latent(latent));
    }

    fn taxel(&mut self, at: Instant, index: usize, condition: Condition) {
        let place = self.layout.as_ref().and_then(|l| l.locate(index));
        let Some((module, taxel)) = place else {
            return;
        };
        match &mut self.changed {
            Some((t, m, c, taxels)) if (*t, *m, *c) == (at, module, condition) => {
                taxels.push(taxel);
            }
            _ => {
                self.tell_taxels();
                self.changed = Some((at, module, condition, vec![taxel]));
            }
        }
    }

    fn all_off(&mut self, at: Instant, board: Board, cause: Cause) {
        self.events.push(Event::AllOff(event::AllOff {
            t_us: at.as_micros(),
            board: board.0,
            cause: cause.word(),
        }));
    }

    fn observed_stop(&mut self, at: Instant, cause: Cause) {
        self.note(
            at,
            format!("observed: the guard would have stopped: {}", cause.word()),
        );
    }
}
