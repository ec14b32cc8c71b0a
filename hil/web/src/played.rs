//! A session that a page plays: its fingers, its pictures, and the scene that it can be saved as.

use std::collections::BTreeMap;

use palpate_core::units::{Instant, Point};
use palpate_files::Setup;
use palpate_records::digest::ScheduleDigest;
use palpate_run::picture::{Head, Painter, Picture};
use palpate_run::wires::EmulatedDisplay;
use palpate_run::{EmulatedEnd, EmulatedMotors, Failure, Fingers, Live, SessionOn, Turn, header};
use serde::Serialize;

/// Longest virtual time of a picture, microseconds: a page that slept does not make up for it.
const MOST_STEP_US: u64 = 2_000_000;
/// Longest delay of an event, nanoseconds.
const LATE_NS: u64 = 2_000_000_000;

/// A finger: its number, module, x, y (um), force (mN), diameter (um).
type Finger = (usize, usize, i64, i64, i64, i64);

/// A session with its page's state.
pub struct Played {
    setup: Setup,
    session: Box<dyn Live>,
    fingers: Fingers,
    head: Head,
    painter: Painter,
    told: ScheduleDigest,
    /// End of the last step: the time of the next touches.
    mark: Instant,
    /// Fingers that press, by number.
    pressing: BTreeMap<usize, Finger>,
}

/// A session as a scene.
#[derive(Debug, Serialize)]
pub struct Saved {
    /// The scene's text (TOML).
    text: String,
    /// Length of the scene, s.
    length_s: f64,
}

/// A session that is over.
#[derive(Debug, Serialize)]
pub struct Ended {
    /// Digest of the schedule, as that of a run of the same length.
    digest: String,
}

/// Opens a session on a display of this kind, and its fingers.
fn opened<D: EmulatedEnd + Send + 'static>(
    setup: &Setup,
    seed: u64,
) -> Result<(Box<dyn Live>, Fingers), Failure> {
    let (session, fingers) = SessionOn::<D>::played(setup, seed)?;
    Ok((Box::new(session), fingers))
}

impl Played {
    /// Begins a session.
    ///
    /// # Errors
    /// What fits no emulated hardware, and several displays.
    pub fn new(setup: Setup, seed: u64) -> Result<Self, Failure> {
        if !setup.bench.value.displays.is_empty() {
            return Err(Failure::Input(format!(
                "bench `{}`: expected a bench of one display; the page has one finger, `hil run` has all",
                setup.bench.value.name
            )));
        }
        let open = match setup.bench.value.haptics {
            None => opened::<EmulatedDisplay>,
            Some(_) => opened::<EmulatedMotors>,
        };
        let (mut session, fingers) = open(&setup, seed)?;
        let header = header(&setup, seed, session.projector())?;
        session.keep_counts();
        let head = Head::new(&setup, &header, session.projector());
        let painter = Painter::new(&setup, &header, session.projector());
        session
            .start(Instant::ZERO)
            .map_err(|e| Failure::Device(e.to_string()))?;
        Ok(Self {
            setup,
            session,
            fingers,
            head,
            painter,
            told: ScheduleDigest::default(),
            mark: Instant::ZERO,
            pressing: BTreeMap::new(),
        })
    }

    /// Head of the session's pictures.
    pub const fn head(&self) -> &Head {
        &self.head
    }

    /// Takes touches that fingers change from the end of the last step on.
    ///
    /// # Errors
    /// Numbers that no finger has, a touch while the reference is taken, and a full log.
    pub fn touch(&mut self, fingers: &[Finger]) -> Result<(), Failure> {
        let now_us = self.mark.as_micros();
        for &finger in fingers {
            let (number, module, x, y, force, diameter) = finger;
            let quiet_us = self.head.quiet_us;
            if now_us < quiet_us {
                return Err(Failure::Input(format!(
                    "finger {number}: expected a touch from {quiet_us} us on, when the reference is taken, found {now_us} us"
                )));
            }
            let modules = self.setup.sensor.value.modules.len();
            if module >= modules {
                return Err(Failure::Input(format!(
                    "finger {number}: expected a module from 0 to {}, found {module}",
                    modules - 1
                )));
            }
            let t_us = i64::try_from(now_us).unwrap_or(i64::MAX);
            self.fingers
                .add(number, module, [t_us, x, y, force, diameter])?;
            match force {
                0 => self.pressing.remove(&number),
                _ => self.pressing.insert(number, finger),
            };
        }
        Ok(())
    }

    /// Lets the session go on until a time, and returns its picture.
    ///
    /// # Errors
    /// The failure that ends the session.
    pub fn step(&mut self, until_us: u64) -> Result<Picture, Failure> {
        let mark_us = self.mark.as_micros();
        let until_us = until_us.clamp(mark_us, mark_us.saturating_add(MOST_STEP_US));
        let until = Instant::from_micros(until_us);
        if self.session.advance(until)? == Turn::Last {
            let ended = self.session.take_failure();
            return Err(ended.unwrap_or_else(|| Failure::Device("the session ended".into())));
        }
        self.mark = until;
        let (events, dropped) = self.session.drain();
        let final_ns = (until_us * 1000).saturating_sub(LATE_NS);
        self.told.add(&events, final_ns);
        let mut state = self.session.state(self.painter.wants(until_us));
        state.now = until;
        let counts = self.session.counts();
        let map = state.map;
        let mut picture = self.painter.picture(&events, counts, state);
        let presses = |&(number, module, x, y, ..): &Finger| {
            let place = Point::new(x as f32 * 1e-3, y as f32 * 1e-3);
            let here = module == self.setup.scene.value.drives && map.shows(place);
            let Point { x, y } = map.apply(place);
            here.then_some((number, [x, y]))
        };
        picture.fingers = self.pressing.values().filter_map(presses).collect();
        picture.dropped = dropped;
        Ok(picture)
    }

    /// The session so far as a scene of its own.
    ///
    /// # Errors
    /// A scene that cannot be written.
    pub fn save(&self) -> Result<Saved, Failure> {
        let now_us = self.mark.as_micros();
        let length_s = now_us.max(self.head.scene_us).max(self.head.quiet_us) as f64 / 1e6;
        let fingers = i64::try_from(now_us).unwrap_or(i64::MAX);
        let fingers = self.fingers.touches(fingers, length_s);
        let text = self.setup.scene.saved(length_s, &fingers)?;
        Ok(Saved { text, length_s })
    }

    /// Switches everything off, as at the end of a run.
    ///
    /// # Errors
    /// The failure of an emulator that contradicts itself.
    pub fn end(mut self) -> Result<Ended, Failure> {
        self.session.end(self.mark)?;
        let (events, _) = self.session.drain();
        self.told.add(&events, u64::MAX);
        let digest = self.told.finish();
        Ok(Ended { digest })
    }
}
