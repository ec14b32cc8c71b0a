//! `palpate-link glove`: publishes how a wearer's hand bends, and measures the time until the robot's skin answers.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_core::units::{Duration, Instant};
use palpate_files::{Joint, Timing, load_scene};
use palpate_live::output::{note, print, print_json};
use palpate_live::recording::read_joints;
use palpate_run::Failure;
use serde::Serialize;
use zenoh::Wait as _;

use crate::budget::{Samples, Spread};
use crate::cli::{GloveArgs, after};
use crate::message::{self, Flexed, Frame, JointAngle, VERSION};
use crate::net::{self, Mode, zenoh};
use crate::records::session_of;

/// Time between two messages.
const TURN: Duration = Duration::from_millis(10);
/// Messages whose answer is awaited at most: ten seconds of them.
const MOST_AWAITED: usize = 1000;

/// Report of a glove.
#[derive(Debug, Serialize)]
struct Report {
    finger: String,
    wearer: String,
    seconds: f64,
    /// Messages sent.
    flexions: u64,
    /// Messages that a frame of contacts answered: the first frame of a skin that had taken them.
    answered: u64,
    /// Time from a message until such a frame arrived, ms; null without one.
    round_trip_ms: Option<Spread>,
}

/// Messages on their way, and the times of those that came back.
#[derive(Default)]
struct Awaited {
    /// Number and time of each, oldest first.
    sent: VecDeque<(u64, Instant)>,
    answered: u64,
    round_trips: Samples,
}

impl Awaited {
    fn send(&mut self, number: u64, at: Instant) {
        if self.sent.len() >= MOST_AWAITED {
            self.sent.pop_front();
        }
        self.sent.push_back((number, at));
    }

    /// Takes a frame of a skin that is under message `number`. Messages that it had passed over have no answer.
    fn hear(&mut self, number: u64, at: Instant) {
        while let Some((sent, since)) = self.sent.pop_front_if(|(sent, _)| *sent <= number) {
            if sent == number {
                self.answered += 1;
                self.round_trips.keep(at.since(since).as_micros());
            }
        }
    }
}

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &GloveArgs) -> Result<(), Failure> {
    let joints = joints(args)?;
    let last = joints.iter().filter_map(|joint| joint.points_s_deg.last());
    let last_s = last.map(|[t_s, _]| *t_s).fold(0.0, f64::max);
    let end = after(args.seconds.unwrap_or(last_s));
    let signals = Signals::catch().map_err(|e| Failure::Device(e.to_string()))?;
    let net = net::open(&args.at.at(), Mode::Peer, &signals)?;
    let wearer = net.wearer(&args.wearer)?;
    let key = args.finger.flexion(&wearer);
    let publisher = net::frames(&net.session, key, &message::encoding::<Flexed>())?;
    let clock = RunClock::start();
    let awaited = Arc::new(Mutex::new(Awaited::default()));
    let hears = {
        let awaited = Arc::clone(&awaited);
        net::subscribe(&net.session, args.finger.contacts(), move |sample| {
            let at = clock.now();
            if let Some(frame) = net::bytes(&sample).and_then(|bytes| Frame::touched(&bytes)) {
                let mut awaited = awaited.lock().unwrap_or_else(PoisonError::into_inner);
                awaited.hear(frame.flexed, at);
            }
        })?
    };
    if !args.quiet {
        let names: Vec<&str> = joints.iter().map(|joint| &*joint.name).collect();
        let names = names.join(", ");
        note(&format!("glove of {wearer} for {}: {names}", args.finger));
    }
    let mut flexed = Flexed {
        version: VERSION,
        session: session_of(&net.session),
        ..Flexed::default()
    };
    let mut next = Instant::ZERO;
    while next <= end && signals.caught().is_none() && !net.session.is_closed() {
        clock.sleep_until(next);
        let now = clock.now();
        flexed.sequence += 1;
        flexed.said_us = now.as_micros();
        let t_s = now.as_micros() as f64 * 1e-6;
        let angle = |joint: &Joint| JointAngle {
            name: joint.name.clone(),
            deg: joint.at(t_s),
        };
        flexed.joints = joints.iter().map(angle).collect();
        let bytes = palpate_records::mcap::encoded(&mut flexed);
        let mut waiting = awaited.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.send(flexed.sequence, now);
        drop(waiting);
        publisher.put(bytes.bytes()).wait().map_err(zenoh)?;
        // after a pause it goes on from now: no burst makes up for it
        next = (next + TURN).max(now);
    }
    drop(hears);
    let mut awaited = awaited.lock().unwrap_or_else(PoisonError::into_inner);
    let report = Report {
        finger: args.finger.to_string(),
        wearer: wearer.to_string(),
        seconds: clock.now().as_micros() as f64 * 1e-6,
        flexions: flexed.sequence,
        answered: awaited.answered,
        round_trip_ms: awaited.round_trips.spread(),
    };
    if args.json {
        return print_json(&report);
    }
    print(|out| told(out, &report))
}

fn told(out: &mut dyn std::io::Write, report: &Report) -> std::io::Result<()> {
    let Report {
        flexions, answered, ..
    } = report;
    writeln!(
        out,
        "{flexions} flexions in {:.1} s, {answered} answered by the skin",
        report.seconds
    )?;
    match report.round_trip_ms {
        Some(Spread { median, p99, max }) => writeln!(
            out,
            "  round trip      {median:.1} ms (median), {p99:.1} (99 %), {max:.1} at most"
        ),
        None => writeln!(
            out,
            "  round trip      unknown: no skin followed this glove"
        ),
    }
}

/// Joints of the scene, or of a recording in its place.
fn joints(args: &GloveArgs) -> Result<Vec<Joint>, Failure> {
    let joints = match &args.replay {
        Some(path) => read_joints(std::slice::from_ref(path), &Timing::default())?,
        None => load_scene(&args.scene)?.value.joints,
    };
    if joints.is_empty() {
        let (found, expected) = match &args.replay {
            Some(path) => (
                path.display().to_string(),
                "a recording with a column joint_NAME",
            ),
            None => (
                args.scene.clone(),
                "a scene with [[joints]], such as `finger-flexes`",
            ),
        };
        return Err(Failure::Input(format!(
            "{found}: expected {expected}, found none"
        )));
    }
    Ok(joints)
}

#[cfg(test)]
#[path = "glove_tests.rs"]
mod tests;
