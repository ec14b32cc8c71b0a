//! A run of several displays: one skin, the buses with their boards, and a session per finger. No session knows of another.
//! What they share, boards, buses and supply, is shared out before the run begins.

use palpate_core::contact::Levels;
use palpate_core::skin::Layout;
use palpate_core::units::{Duration, Instant};
use palpate_files::{Fault, Gate};
use palpate_records::i2c::Transfer;
use palpate_records::trace::{Event, Header};

use super::{Run, look_on, part};
use crate::actuator_bus::ActuatorBus;
use crate::display_end::{DisplayEnd, EmulatedDisplay};
use crate::effects::Faultable;
use crate::failure::Failure;
use crate::join::{Common, Part, join};
use crate::pads::Pads;
use crate::place::{Place, fingers};
use crate::plan;
use crate::recorder::Truth;
use crate::script::Script;
use crate::session::{Session, TICK, Turn};
use crate::skin_end::SkinEnd;
use crate::stagger::stagger;
use crate::verdict::STOPPED_BY;
use crate::{Beginning, Host, Outcome};

/// A finger's session, and whether it has ended before the run.
struct Finger {
    place: Place,
    header: Header,
    session: Session<Pads, EmulatedDisplay>,
    /// How far its bus may be behind at its turn: what the guard counts with.
    bus_wait: Duration,
    ended: bool,
    /// The joint that it depends on, and whether it was felt in the last turn.
    gate: Option<(Gate, bool)>,
}

impl Finger {
    /// When its next turn is due. A host waits for an adapter that is still busy with other fingers' transfers: what it
    /// wrote later it must not believe to be written now. Looked at when a turn is there, not before.
    fn due(&mut self, now: Instant) -> Instant {
        let next = self.session.next();
        if self.place.alone || next > now {
            return next;
        }
        let busy = self.session.display().hardware().bus_now();
        let waits_us = busy
            .0
            .div_ceil(1000)
            .saturating_sub(self.bus_wait.as_micros());
        next.max(Instant::from_micros(waits_us))
    }

    /// A turn, if one is due; something that ends it ends no other finger.
    fn turn(&mut self, now: Instant, skin: &mut dyn SkinEnd) -> Result<(), Failure> {
        if self.ended {
            return self.rest(now);
        }
        if self.due(now) > now {
            return Ok(());
        }
        self.look_at_joint(now);
        if self.session.turn(now)? == Turn::Last {
            self.end(now);
        }
        self.session.skin().exchange(skin);
        Ok(())
    }

    /// Shows the finger's skin, or hides it, as its joint stands.
    fn look_at_joint(&mut self, now: Instant) {
        let Some((gate, was_open)) = &mut self.gate else {
            return;
        };
        let t_s = now.as_micros() as f64 * 1e-6;
        let (_, projector, recorder) = self.session.all();
        let is_open = gate.is_open(&recorder.joints, t_s);
        if std::mem::replace(was_open, is_open) != is_open {
            projector.show(is_open);
            let joint = recorder.joints.get(gate.joint).map_or("?", |j| &*j.name);
            let word = if is_open { "felt" } else { "not felt" };
            let text = format!("{word}: joint {joint}");
            recorder.note(now, text);
        }
    }

    /// What no loop drives any more is looked at to the end: its wires cool, and a shorted amplifier heats on.
    fn rest(&mut self, now: Instant) -> Result<(), Failure> {
        let (display, projector, recorder) = self.session.all();
        display.fail(now, false, None, &mut recorder.events);
        display.advance_to(now, &mut recorder.events)?;
        display.look(now, false, projector, recorder);
        Ok(())
    }

    /// Everything of it off at `now`, once.
    fn end(&mut self, now: Instant) {
        if !std::mem::replace(&mut self.ended, true) {
            self.session.conclude(now);
        }
    }
}

impl Run<'_> {
    /// The pass that counts, of every finger, on one skin until `end`.
    pub(super) fn several(
        &self,
        levels: &Levels,
        skin: &mut dyn SkinEnd,
        truth: &Truth,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Outcome, Failure> {
        let alone = fingers(self.setup);
        let layouts = alone.iter().map(|(_, s)| plan::layout(&s.sensor.value));
        let layouts: Vec<Layout> = layouts.collect::<Result<_, _>>()?;
        let runs = alone.iter().zip(&layouts).map(|((_, setup), layout)| Run {
            setup,
            layout,
            ..*self
        });
        let runs: Vec<Run<'_>> = runs.collect();
        let mut buses = ActuatorBus::all(self.setup, self.layout, self.seed);
        let mut fingers = Vec::new();
        for ((run, (place, _)), finger) in runs.iter().zip(&alone).zip(&self.setup.fingers) {
            let truth = match truth {
                Truth::Scene(_) => Truth::of_finger(self.setup, finger),
                _ => Truth::Unknown,
            };
            let pads = Pads::new(&place.modules);
            let on = (place.clone(), buses.iter().find(|bus| bus.carries(place)));
            let (header, session) = run.assemble(levels.clone(), pads, truth, on, host)?;
            host.begin(&Beginning {
                setup: run.setup,
                header: &header,
                projector: session.projector(),
                end,
                display: Some(place.display()),
            })?;
            fingers.push(Finger {
                place: place.clone(),
                header,
                session,
                bus_wait: run.setup.bus_wait,
                ended: false,
                gate: finger.when.map(|gate| (gate, true)),
            });
        }
        let loops = fingers.iter_mut().map(|finger| {
            let Finger { place, session, .. } = finger;
            (&*place, session.projector_mut())
        });
        stagger(self.setup, loops.collect())?;
        let hardware = Hardware {
            skin: &mut *skin,
            buses: &mut buses,
            script: Script::new(self.of_skin(), self.layout),
            events: Vec::new(),
        };
        let played = self.play(&mut fingers, hardware, end, host);
        host.end();
        let (last, common) = played?;
        let replayed = matches!(truth, Truth::Unknown);
        let mut parts = Vec::new();
        // Boards that fingers share go off before any of them is looked at.
        fingers.iter_mut().for_each(|finger| finger.end(last));
        let i2c: Vec<Transfer> = buses.iter().flat_map(ActuatorBus::transfers).collect();
        for (run, mut finger) in runs.iter().zip(fingers) {
            let (display, projector, recorder) = finger.session.all();
            display.settle(last, projector, recorder)?;
            let mut outcome = run.outcome(finger.header, &mut finger.session, last, host)?;
            let own = plan::boards(&run.setup.bench.value);
            let of_boards = |t: &&Transfer| t.bus == finger.place.bus && own.contains(&t.address);
            outcome.i2c = i2c.iter().filter(of_boards).cloned().collect();
            // The whole scene's faults say what may be missing; the person is the finger's.
            let mut judged = self.setup.clone();
            judged.person.clone_from(&run.setup.person);
            parts.push(Part {
                place: finger.place,
                limits: *finger.session.projector().guard().limits(),
                outcome: outcome.concluded(&judged, replayed),
            });
        }
        let common = Common {
            can: skin.take_frames(),
            buses: skin.buses(),
            board_faults: buses.iter().flat_map(ActuatorBus::faults).collect(),
            i2c,
            ..common
        };
        Ok(join(self.setup, parts, common))
    }

    /// The scene's faults of the skin.
    fn of_skin(&self) -> impl Iterator<Item = &Fault> {
        let faults = self.setup.scene.value.faults.iter();
        faults.filter(|fault| !fault.kind.is_of_display())
    }

    /// Turn after turn. The skin is read at times that no finger sets: each then finds what it would find alone.
    fn play(
        &self,
        fingers: &mut [Finger],
        mut hardware: Hardware<'_>,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<(Instant, Common), Failure> {
        let mut now = Instant::ZERO;
        let mut due = hardware.fail(now, false).min(now + TICK);
        let mut order: Vec<usize> = (0..fingers.len()).collect();
        for finger in &mut *fingers {
            // The policy waits for boards that do not answer, so this cannot fail.
            let _ = finger.session.start(now);
        }
        while !host.passed(part(now, end)) {
            let turns = fingers.iter_mut().filter(|f| !f.ended);
            let next = turns.map(|f| f.due(now)).fold(due, Instant::min);
            if next >= end {
                now = end;
                break;
            }
            now = next;
            if now >= due {
                hardware.skin.advance_to(now);
                let read = hardware.skin.scans(now, &mut |scan| {
                    fingers
                        .iter_mut()
                        .for_each(|f| f.session.skin().offer(scan));
                });
                if let Err(e) = read {
                    let failed = || Failure::Device(format!("sensor bus: {e}"));
                    fingers
                        .iter_mut()
                        .for_each(|f| f.session.set_failure(failed()));
                    break;
                }
                due = hardware.fail(now, false).min(now + TICK);
            }
            let mut is_stopped = false;
            // What waits longest comes first: tries to bring a board back must not hold up the end of a burst.
            order.sort_unstable_by_key(|number| (fingers[*number].session.next(), *number));
            for &number in &order {
                let finger = &mut fingers[number];
                finger.turn(now, hardware.skin)?;
                is_stopped |= look_on(&finger.session, (now, number), hardware.skin, host);
            }
            if is_stopped {
                let text = format!("{STOPPED_BY}the person who watched");
                let fingers = fingers.iter_mut();
                fingers.for_each(|f| f.session.recorder().note(now, text.clone()));
                hardware.events.push(Event::note(now, text));
                break;
            }
        }
        hardware.skin.advance_to(now);
        let _ = hardware.fail(end, true);
        let common = Common {
            events: hardware.events,
            faults: hardware.script.report(),
            ..Common::default()
        };
        Ok((now, common))
    }
}

/// What the fingers have in common, and the scene's faults of it.
struct Hardware<'a> {
    skin: &'a mut dyn SkinEnd,
    buses: &'a mut [ActuatorBus],
    /// The skin's faults.
    script: Script,
    events: Vec<Event>,
}

impl Hardware<'_> {
    /// Lets faults begin and end that are due at `now`; with `last` those that are on end. Returns when the next one is due.
    fn fail(&mut self, now: Instant, last: bool) -> Instant {
        let mut bench = Faultable {
            skin: self.skin.emulated(),
            display: None,
        };
        let events = &mut self.events;
        self.script.step(now, last, &mut bench, events);
        let buses = self.buses.iter_mut().map(|bus| {
            bus.fail(now, last, events);
            bus.next_fault()
        });
        buses.fold(self.script.next(), Instant::min)
    }
}
