//! An emulated hand that a wearer's glove bends: the newest angles of its joints, and what they press.

use std::sync::{Arc, Mutex, PoisonError};

use palpate_buses::pacer::RunClock;
use palpate_core::units::{Duration, Instant};
use palpate_files::{BenchKind, Joint, MOST_DEG, Setup};
use palpate_records::mcap::decode;
use palpate_records::trace::{Event, event};
use palpate_run::{Failure, Hand, Recorder, Truth, press};
use zenoh::pubsub::Subscriber;

use crate::message::{Flexed, VERSION};
use crate::name::{FingerName, Name};
use crate::net::{self, Net};

/// Silence after which the hand lets go.
const PATIENCE: Duration = Duration::from_millis(100);
/// Silence after which another glove may bend the hand.
const LEASE: Duration = Duration::from_millis(1000);

/// Newest message of a glove, and its arrival.
type Newest = Option<(Flexed, Instant)>;

/// A hand that follows a glove.
pub(super) struct Bent {
    /// Clock of arrivals, which is this hand's own.
    clock: RunClock,
    newest: Arc<Mutex<Newest>>,
    joints: Vec<Joint>,
    /// Angles of the joints so far, thousandths of a degree.
    angles: Vec<i32>,
    hands: Vec<Hand>,
    wearer: Name,
    /// The newest message that the skin is under; 0 for none.
    taken: (u64, u64),
    /// `true` while the hand follows: it has let go otherwise.
    follows: bool,
    _hears: Subscriber<()>,
}

/// Keeps a message that is newer than the newest one of its glove, or of another glove where that fell silent.
fn keep(newest: &mut Newest, flexed: Flexed, now: Instant) {
    let angle = |deg: f64| (-MOST_DEG..=MOST_DEG).contains(&deg);
    let fits = flexed.version == VERSION
        && flexed.sequence > 0
        && flexed.joints.iter().all(|joint| angle(joint.deg));
    let follows = newest.as_ref().is_none_or(|(own, heard)| {
        let same = own.session == flexed.session && own.sequence < flexed.sequence;
        same || (own.session != flexed.session && now.since(*heard) > LEASE)
    });
    if fits && follows {
        *newest = Some((flexed, now));
    }
}

impl Bent {
    /// Hands for a setup's modules, bent by the glove of `wearer`.
    ///
    /// # Errors
    /// [`Failure::Input`] for a bench of hardware, and a scene in which no joint presses.
    pub(super) fn begin(
        net: &Net,
        finger: &FingerName,
        wearer: &Name,
        setup: &Setup,
    ) -> Result<Self, Failure> {
        let scene = &setup.scene.value;
        if setup.bench.value.kind == BenchKind::Real {
            return Err(Failure::Input(
                "--glove: expected an emulated bench, since nothing here moves a real hand".into(),
            ));
        }
        if scene.joints.iter().all(|joint| joint.press.is_none()) {
            return Err(Failure::Input(format!(
                "--glove: expected a scene with a joint that presses (`press` in [[joints]]), such as `finger-flexes`, found `{}`",
                scene.name
            )));
        }
        let clock = RunClock::start();
        let newest: Arc<Mutex<Newest>> = Arc::default();
        let kept = Arc::clone(&newest);
        let hears = net::subscribe(&net.session, finger.flexion(wearer), move |sample| {
            let now = clock.now();
            if let Some(flexed) = net::bytes(&sample).and_then(|bytes| decode(&bytes)) {
                let mut newest = kept.lock().unwrap_or_else(PoisonError::into_inner);
                keep(&mut newest, flexed, now);
            }
        })?;
        let modules = &setup.sensor.value.modules;
        // one for each: clones of a hand are the same hand
        let hands = modules.iter().map(|_| Hand::default());
        Ok(Self {
            clock,
            newest,
            angles: vec![0; scene.joints.len()],
            joints: scene.joints.clone(),
            hands: hands.collect(),
            wearer: wearer.clone(),
            taken: (0, 0),
            follows: false,
            _hears: hears,
        })
    }

    /// Truth of the module that drives: where this hand presses it.
    pub(super) fn truth(&self, drives: usize) -> Truth {
        let hand = self.hands.get(drives).cloned();
        hand.map_or(Truth::Unknown, Truth::Hand)
    }

    /// The hand on each module.
    pub(super) fn hands(&self) -> &[Hand] {
        &self.hands
    }

    /// Number of the message that the skin is under; 0 for none.
    pub(super) const fn flexed(&self) -> u64 {
        self.taken.1
    }

    /// Bends the hand as the newest message says. A glove that falls silent lets go. Returns what is worth a note.
    pub(super) fn turn(&mut self, now: Instant, recorder: &mut Recorder) -> Option<String> {
        let newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let (flexed, heard) = newest.clone()?;
        drop(newest);
        if self.clock.now().since(heard) > PATIENCE {
            if !std::mem::replace(&mut self.follows, false) {
                return None;
            }
            self.hands.iter().for_each(|hand| hand.press(&[]));
            return Some(format!(
                "the glove of {} fell silent: the hand lets go",
                self.wearer
            ));
        }
        let begins = !std::mem::replace(&mut self.follows, true);
        let number = (flexed.session, flexed.sequence);
        if std::mem::replace(&mut self.taken, number) != number || begins {
            for (index, (joint, angle)) in self.joints.iter().zip(&mut self.angles).enumerate() {
                let said = flexed.joints.iter().find(|said| said.name == joint.name);
                let milli_deg = said.map(|said| (said.deg * 1e3).round() as i32);
                let Some(milli_deg) = milli_deg.filter(|said| said != angle) else {
                    continue;
                };
                *angle = milli_deg;
                recorder.events.push(Event::Joint(event::Joint {
                    t_us: now.as_micros(),
                    joint: index as u16,
                    milli_deg,
                }));
            }
            self.press();
        }
        begins.then(|| format!("the glove of {} bends the hand", self.wearer))
    }

    /// Presses every module as the joints stand.
    fn press(&self) {
        for (module, hand) in self.hands.iter().enumerate() {
            let joints = self.joints.iter().zip(&self.angles);
            let pressed = joints.filter_map(|(joint, milli_deg)| {
                let own = joint.press.filter(|press| press.module == module)?;
                let at = own.at(f64::from(*milli_deg) * 1e-3);
                let here = press(at.x_mm as f32, at.y_mm as f32, at.force_n, at.diameter_mm);
                (at.force_n > 0.0).then_some(here)
            });
            hand.press(&pressed.collect::<Vec<_>>());
        }
    }
}

#[cfg(test)]
#[path = "bent_tests.rs"]
mod tests;
