//! A run of several displays: one skin, and a session per finger. No session knows of another, so what befalls one
//! finger changes nothing of the others'; what they share, boards and supply, is shared out before the run begins.

use palpate_core::contact::Levels;
use palpate_core::projector::Projector;
use palpate_core::skin::Layout;
use palpate_core::units::{Duration, Instant};
use palpate_files::{Gate, Setup};
use palpate_records::trace::{Event, Header};

use super::{Run, build, part};
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
use crate::verdict::STOPPED_BY;
use crate::{Host, Outcome, TurnView};

/// A finger's session, and whether it has ended before the run.
struct Finger {
    place: Place,
    header: Header,
    session: Session<Pads, EmulatedDisplay>,
    ended: bool,
    /// The joint that it depends on, and whether it was felt in the last turn.
    gate: Option<(Gate, bool)>,
}

impl Finger {
    /// A turn, if one is due; something that ends it ends no other finger.
    fn turn(&mut self, now: Instant, skin: &mut impl SkinEnd) -> Result<(), Failure> {
        if self.ended {
            return self.rest(now);
        }
        if self.session.next() > now {
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

    /// Shows its turn to the host; whether the host wants no more.
    fn show(
        &mut self,
        display: usize,
        now: Instant,
        skin: &impl SkinEnd,
        host: &mut dyn Host,
    ) -> bool {
        if !host.looks_on() {
            return false;
        }
        let (_, recorder) = self.session.seen();
        host.turn(&TurnView {
            now,
            display,
            events: &recorder.events,
            counts: recorder.counts.as_deref().unwrap_or_default(),
            buses: &|| skin.buses(),
        })
    }

    /// Everything of it off at `now`, once.
    fn end(&mut self, now: Instant) {
        if std::mem::replace(&mut self.ended, true) {
            return;
        }
        if let Err(e) = self.session.switch_off(now)
            && self.session.failure().is_none()
        {
            self.session.lose(&e);
            self.session.set_failure(Failure::Device(e.to_string()));
        }
    }
}

impl Run<'_> {
    /// The pass that counts, of every finger, on one skin until `end`.
    pub(super) fn several<S: SkinEnd>(
        &self,
        levels: &Levels,
        mut skin: S,
        truth: &Truth,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<(Outcome, S), Failure> {
        let alone = fingers(self.setup);
        let layouts = alone.iter().map(|(_, s)| plan::layout(&s.sensor.value));
        let layouts: Vec<Layout> = layouts.collect::<Result<_, _>>()?;
        let runs = alone.iter().zip(&layouts).map(|((_, setup), layout)| Run {
            setup,
            layout,
            ..*self
        });
        let runs: Vec<Run<'_>> = runs.collect();
        let mut fingers = Vec::new();
        for ((run, (place, _)), finger) in runs.iter().zip(&alone).zip(&self.setup.fingers) {
            let truth = match truth {
                Truth::Scene(_) => Truth::of_finger(self.setup, finger),
                _ => Truth::Unknown,
            };
            let pads = Pads::new(&place.modules);
            let (header, session) =
                run.assemble(levels.clone(), pads, truth, place.clone(), host)?;
            host.begin(&header, run.layout, end)?;
            fingers.push(Finger {
                place: place.clone(),
                header,
                session,
                ended: false,
                gate: finger.when.map(|gate| (gate, true)),
            });
        }
        let loops = fingers.iter_mut().map(|finger| {
            let Finger { place, session, .. } = finger;
            (&*place, session.projector_mut())
        });
        stagger(self.setup, loops.collect())?;
        let played = self.play(&mut fingers, &mut skin, end, host);
        host.end();
        let (last, common) = played?;
        let replayed = matches!(truth, Truth::Unknown);
        let mut parts = Vec::new();
        for (run, mut finger) in runs.iter().zip(fingers) {
            finger.end(last);
            let (display, projector, recorder) = finger.session.all();
            display.settle(last, projector, recorder)?;
            let outcome = run.outcome(finger.header, &mut finger.session, last, host)?;
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
            ..common
        };
        Ok((join(self.setup, parts, common), skin))
    }

    /// Turn after turn. The skin is read at times that no finger sets: each then finds what it would find alone.
    fn play<S: SkinEnd>(
        &self,
        fingers: &mut [Finger],
        skin: &mut S,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<(Instant, Common), Failure> {
        let faults = self.setup.scene.value.faults.iter();
        let of_skin = faults.filter(|fault| !fault.kind.is_of_display());
        let mut script = Script::new(of_skin, self.layout);
        let mut events = Vec::new();
        let mut fail = |now, skin: &mut S, events: &mut Vec<Event>| {
            let mut bench = Faultable {
                skin: skin.emulated(),
                display: None,
            };
            if now < end {
                script.step(now, &mut bench, events);
            } else {
                script.finish(now, &mut bench, events);
            }
            script.next()
        };
        for finger in &mut *fingers {
            // The policy waits for boards that do not answer, so this cannot fail.
            let _ = finger.session.start(Instant::ZERO);
        }
        let mut due = fail(Instant::ZERO, skin, &mut events).min(Instant::ZERO + TICK);
        let mut now = Instant::ZERO;
        while !host.passed(part(now, end)) {
            let turns = fingers.iter().filter(|f| !f.ended);
            let next = turns.map(|f| f.session.next()).fold(due, Instant::min);
            if next >= end {
                now = end;
                break;
            }
            now = next;
            if now >= due {
                skin.advance_to(now);
                let read = skin.scans(now, &mut |scan| {
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
                due = fail(now, skin, &mut events).min(now + TICK);
            }
            let mut is_stopped = false;
            for (number, finger) in fingers.iter_mut().enumerate() {
                finger.turn(now, skin)?;
                is_stopped |= finger.show(number, now, skin, host);
            }
            if is_stopped {
                let text = format!("{STOPPED_BY}the person who watched");
                let fingers = fingers.iter_mut();
                fingers.for_each(|f| f.session.recorder().note(now, text.clone()));
                let t_us = now.as_micros();
                events.push(Event::Note { t_us, text });
                break;
            }
        }
        skin.advance_to(now);
        let _ = fail(end, skin, &mut events);
        let common = Common {
            events,
            faults: script.report(),
            ..Common::default()
        };
        Ok((now, common))
    }
}

/// Builds every finger's loop and gives it its place on the grid of onsets, and lets go of them.
///
/// # Errors
/// [`Failure`] for what fits no hardware, or no grid.
pub(super) fn fits(setup: &Setup) -> Result<(), Failure> {
    let alone = fingers(setup);
    let loops = alone.iter().map(|(_, setup)| build(setup, 1, Levels::Off));
    let mut loops: Vec<Projector> = loops.collect::<Result<_, _>>()?;
    let places = alone.iter().map(|(place, _)| place);
    stagger(setup, places.zip(&mut loops).collect())
}

/// Gives every finger its place on the grid of onsets: bursts of those that share a board never meet. Within a burst
/// the guard keeps a board's wires apart, so at most one wire's current flows per board.
fn stagger(setup: &Setup, fingers: Vec<(&Place, &mut Projector)>) -> Result<(), Failure> {
    let mut ranks: Vec<u64> = Vec::new();
    for (index, (place, _)) in fingers.iter().enumerate() {
        let shares = |other: &Place| other.boards.iter().any(|b| place.boards.contains(b));
        let earlier = fingers[..index].iter().zip(&ranks);
        let taken = earlier.filter(|((other, _), _)| shares(other));
        let taken: Vec<u64> = taken.map(|(_, rank)| *rank).collect();
        ranks.extend((0..).find(|rank| !taken.contains(rank)));
    }
    let slots = ranks.iter().max().map_or(1, |most| most + 1);
    for ((_, projector), rank) in fingers.into_iter().zip(ranks) {
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
        projector.begin_at(Instant::from_micros(soa_us * rank / slots));
    }
    Ok(())
}
