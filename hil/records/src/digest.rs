//! The trace as canonical bytes, and SHA-256 over them: what "byte-identical runs" means.
//!
//! Little-endian integers at fixed widths, strings with their length in front, one tag byte an event,
//! so two different traces never share their bytes.

use crate::trace::{
    Driven, Event, Header, Ledger, PlaceUm, Source, Trace, VERSION, event, sort_by_time,
};
use sha2::{Digest, Sha256};

/// First 16 hex digits of the SHA-256 over the whole trace: header, events and ledger.
pub fn trace_digest(trace: &Trace) -> String {
    let mut sink = Sink::default();
    sink.header(&trace.header);
    sink.events(trace.events.iter());
    sink.ledger(&trace.ledger);
    sink.finish()
}

/// The same over taxels, frames, contacts and truth alone: a change behind the compression leaves it.
pub fn contacts_digest(trace: &Trace) -> String {
    let mut sink = Sink::default();
    sink.places(trace.header.taxels.iter());
    sink.events(
        trace
            .events
            .iter()
            .filter(|e| matches!(e, Event::Frame(_) | Event::Contact(_) | Event::Truth(_))),
    );
    sink.finish()
}

/// The same over what was sent to the boards alone: a change of a physical model leaves it.
pub fn schedule_digest(trace: &Trace) -> String {
    let mut digest = ScheduleDigest::default();
    digest.add(&trace.events, u64::MAX);
    digest.finish()
}

/// [`schedule_digest`] of a run whose events are not kept.
#[derive(Clone, Debug, Default)]
pub struct ScheduleDigest {
    sink: Sink,
    /// What may still get older company.
    waiting: Vec<Event>,
}

impl ScheduleDigest {
    /// The next events, in the order in which they were noticed. None that comes later is older than `until_ns`.
    pub fn add(&mut self, events: &[Event], until_ns: u64) {
        let Self { sink, waiting } = self;
        let sent = events.iter().filter(|e| {
            matches!(
                e,
                Event::Schedule(_) | Event::PreScale(_) | Event::AllOff(_)
            )
        });
        waiting.extend(sent.cloned());
        sort_by_time(waiting);
        let due = waiting.partition_point(|e| e.t_ns() < until_ns);
        waiting.drain(..due).for_each(|event| sink.event(&event));
    }

    /// The digest of all of them.
    pub fn finish(mut self) -> String {
        self.sink.events(self.waiting.iter());
        self.sink.finish()
    }
}

/// First 16 hex digits of the SHA-256 of any bytes, for scene files and limit tables.
pub fn short_digest(bytes: &[u8]) -> String {
    let mut sink = Sink::default();
    sink.0.update(bytes);
    sink.finish()
}

#[derive(Clone, Debug, Default)]
struct Sink(Sha256);

impl Sink {
    fn finish(self) -> String {
        use std::fmt::Write;
        let mut text = String::with_capacity(16);
        for byte in self.0.finalize().iter().take(8) {
            let _ = write!(text, "{byte:02x}");
        }
        text
    }

    fn u8(&mut self, v: u8) {
        self.0.update([v]);
    }
    fn u16(&mut self, v: u16) {
        self.0.update(v.to_le_bytes());
    }
    fn u32(&mut self, v: u32) {
        self.0.update(v.to_le_bytes());
    }
    fn u64(&mut self, v: u64) {
        self.0.update(v.to_le_bytes());
    }
    fn i32(&mut self, v: i32) {
        self.0.update(v.to_le_bytes());
    }
    fn i64(&mut self, v: i64) {
        self.0.update(v.to_le_bytes());
    }
    fn text(&mut self, v: &str) {
        self.u64(v.len() as u64);
        self.0.update(v.as_bytes());
    }
    fn place(&mut self, p: PlaceUm) {
        self.i32(p.x);
        self.i32(p.y);
    }
    fn option<T>(&mut self, v: Option<T>, write: impl FnOnce(&mut Self, T)) {
        self.u8(u8::from(v.is_some()));
        if let Some(v) = v {
            write(self, v);
        }
    }
    fn places<'a>(&mut self, places: impl ExactSizeIterator<Item = &'a PlaceUm>) {
        self.u64(places.len() as u64);
        for p in places {
            self.place(*p);
        }
    }

    // Taken apart by pattern: a new field does not compile until it is hashed.
    fn header(&mut self, header: &Header) {
        let Header {
            source,
            scene,
            bench,
            seed,
            scene_digest,
            limits_digest,
            pre_scale,
            tau_d_us,
            soa_us,
            person,
            preset,
            illusion,
            kc,
            taxels,
            wires,
            displays,
            joints,
            warmth,
        } = header;
        // What a run without joints comes to is what it came to before there were any.
        joints.iter().for_each(|name| self.text(name));
        // The same of a run without a module.
        if *warmth {
            self.text("warmth");
        }
        self.u32(VERSION);
        self.u8(match source {
            Source::Emulated => 0,
            Source::Real => 1,
            Source::Observed => 2,
        });
        self.text(scene);
        self.text(bench);
        self.u64(*seed);
        self.text(scene_digest);
        self.text(limits_digest);
        self.u8(pre_scale.get());
        let clock = pre_scale.clock();
        if let Some(ppm) = clock.tolerance_ppm() {
            self.u32(clock.hz());
            self.u32(ppm);
        }
        self.u64(*tau_d_us);
        self.u64(*soa_us);
        self.text(person);
        self.text(preset);
        self.text(illusion);
        self.u16(*kc);
        self.places(taxels.iter());
        self.u64(wires.len() as u64);
        for wire in wires {
            self.place(wire.place);
            self.u8(wire.board);
            self.u8(wire.channel);
        }
        for display in displays {
            self.text(&display.name);
            self.u64(display.wires as u64);
            self.u64(display.modules.len() as u64);
            display.modules.iter().for_each(|m| self.u16(*m));
        }
    }

    fn ledger(&mut self, ledger: &Ledger) {
        let Ledger {
            driven,
            energy_uj,
            hottest_wire,
            margins,
            length_us,
        } = ledger;
        let Driven {
            stimuli,
            limiter_events,
            widest,
        } = driven;
        self.u64(*stimuli);
        self.u32(*limiter_events);
        self.u16(*widest);
        self.u64(*energy_uj);
        self.option(*hottest_wire, |s, (milli_c, wire)| {
            s.i32(milli_c);
            s.u16(wire);
        });
        self.u64(margins.len() as u64);
        for margin in margins {
            self.text(margin.of.name());
            self.i64(margin.worst_nano);
            self.i64(margin.limit_nano);
        }
        self.u64(*length_us);
    }

    fn events<'a>(&mut self, events: impl Iterator<Item = &'a Event>) {
        for event in events {
            self.event(event);
        }
        self.u8(0xFF);
    }

    // Every variant has its place here: a new one does not compile until it is hashed.
    fn event(&mut self, event: &Event) {
        match event {
            Event::Frame(_)
            | Event::Contact(_)
            | Event::Truth(_)
            | Event::Joint(_)
            | Event::Latent(_) => self.sensed(event),
            Event::Schedule(_) | Event::PreScale(_) | Event::AllOff(_) => self.told(event),
            Event::Edge(_)
            | Event::Felt(_)
            | Event::Wire(_)
            | Event::Skin(_)
            | Event::Face(_)
            | Event::Note(_) => self.came(event),
        }
    }

    /// What the sensor end saw.
    fn sensed(&mut self, event: &Event) {
        match event {
            Event::Frame(event::Frame {
                t_us,
                frame,
                in_contact,
                peak_counts,
            }) => {
                self.u8(1);
                self.u64(*t_us);
                self.u32(*frame);
                self.u16(*in_contact);
                self.u32(*peak_counts);
            }
            Event::Contact(event::Contact {
                t_us,
                frame,
                module,
                contact,
                place,
                intensity_milli,
                level,
                members,
            }) => {
                self.u8(2);
                self.u64(*t_us);
                self.u32(*frame);
                self.u16(*module);
                self.u32(*contact);
                self.place(*place);
                self.u32(*intensity_milli);
                self.u16(*level);
                self.u32(*members);
            }
            Event::Truth(event::Truth {
                t_us,
                place,
                force_mn,
            }) => {
                self.u8(3);
                self.u64(*t_us);
                self.place(*place);
                self.u32(*force_mn);
            }
            Event::Joint(event::Joint {
                t_us,
                joint,
                milli_deg,
            }) => {
                self.u8(14);
                self.u64(*t_us);
                self.u16(*joint);
                self.i32(*milli_deg);
            }
            Event::Latent(event::Latent {
                t_us,
                z_milli,
                rough_permille,
                rate_mhz,
            }) => {
                self.u8(12);
                self.u64(*t_us);
                self.u64(z_milli.len() as u64);
                z_milli.iter().for_each(|z| self.i32(*z));
                self.u16(*rough_permille);
                self.u32(*rate_mhz);
            }
            _ => {}
        }
    }

    /// What the boards were told.
    fn told(&mut self, event: &Event) {
        match event {
            Event::Schedule(entry) => {
                self.u8(4);
                self.u64(entry.at.as_micros());
                self.u8(entry.board.0);
                self.u8(entry.channel.0);
                self.u16(entry.on);
                self.u16(entry.off);
                self.u64(entry.until.as_micros());
                self.u16(entry.requested.get());
                self.option(entry.reason, |s, reason| s.text(reason.word()));
                // Only where it says more: digests of other runs stay.
                if entry.requested_until != entry.until {
                    self.u8(13);
                    self.u64(entry.requested_until.as_micros());
                }
                if let Some(current) = entry.current {
                    self.u8(16);
                    self.u64(current.0.into());
                }
            }
            Event::PreScale(event::PreScale {
                t_us,
                board,
                pre_scale,
            }) => {
                self.u8(5);
                self.u64(*t_us);
                self.u8(*board);
                self.u8(*pre_scale);
            }
            Event::AllOff(event::AllOff { t_us, board, cause }) => {
                self.u8(6);
                self.u64(*t_us);
                self.u8(*board);
                self.text(cause);
            }
            _ => {}
        }
    }

    /// What came of it.
    fn came(&mut self, event: &Event) {
        match event {
            Event::Edge(event::Edge {
                t_ns,
                board,
                channel,
                high,
            }) => {
                self.u8(7);
                self.u64(*t_ns);
                self.u8(*board);
                self.u8(*channel);
                self.u8(u8::from(*high));
            }
            Event::Felt(event::Felt {
                t_us,
                target,
                inside,
                met,
                energy,
            }) => {
                self.u8(8);
                self.u64(*t_us);
                self.place(*target);
                self.u8(u8::from(*inside));
                self.option(*met, |hash, met| {
                    hash.place(met.energy);
                    hash.place(met.amplitude);
                    hash.i32(met.level_mdb);
                    hash.u8(u8::from(met.tap));
                });
                for permille in [energy.requested, energy.applied, energy.felt] {
                    self.u32(permille);
                }
            }
            Event::Wire(event::Temperature {
                t_us,
                wire,
                milli_c,
            }) => {
                self.u8(9);
                self.u64(*t_us);
                self.u16(*wire);
                self.i32(*milli_c);
            }
            Event::Skin(event::Temperature {
                t_us,
                wire,
                milli_c,
            }) => {
                self.u8(11);
                self.u64(*t_us);
                self.u16(*wire);
                self.i32(*milli_c);
            }
            Event::Face(event::Face {
                t_us,
                face_mc,
                aim_mc,
                sink_mc,
                milliamps,
            }) => {
                self.u8(15);
                self.u64(*t_us);
                self.i32(*face_mc);
                self.option(*aim_mc, Self::i32);
                self.i32(*sink_mc);
                self.i32(*milliamps);
            }
            Event::Note(event::Note { t_us, text }) => {
                self.u8(10);
                self.u64(*t_us);
                self.text(text);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
#[path = "digest_tests.rs"]
mod tests;
