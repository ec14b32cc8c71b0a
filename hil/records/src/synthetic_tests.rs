//! Traces for tests: plausible in every number, made without the loop.
#![allow(clippy::cast_possible_truncation)]

use crate::margin::{Limited, Margin};
use crate::trace::{
    EnergyPermille, Event, FeltAt, Header, Ledger, PlaceUm, Source, Trace, WireInfo, event,
};
use palpate_core::schedule::{Entry, Reason};
use palpate_core::units::{Board, Channel, Instant, Prescale, Ticks};

const SOA_US: u64 = 58_500;
const TAU_US: u64 = 35_000;
const WIRES: [(f64, f64); 8] = [
    (0.0, -14.25),
    (0.0, -4.75),
    (0.0, 4.75),
    (0.0, 14.25),
    (-11.0, -4.75),
    (-11.0, 4.75),
    (11.0, -4.75),
    (11.0, 4.75),
];

fn um(x: f64, y: f64) -> PlaceUm {
    PlaceUm {
        x: (x * 1000.0) as i32,
        y: (y * 1000.0) as i32,
    }
}

/// A header with a 4x4 pad and eight wires, and nothing that happened.
pub(crate) fn empty() -> Trace {
    let taxels = (0..16)
        .map(|i| {
            um(
                -7.05 + 4.7 * f64::from(i % 4),
                7.05 - 4.7 * f64::from(i / 4),
            )
        })
        .collect();
    let wires = (0u8..)
        .zip(WIRES)
        .map(|(channel, (x, y))| WireInfo {
            place: um(x, y),
            board: 0,
            channel,
        })
        .collect();
    Trace {
        header: Header {
            source: Source::Emulated,
            scene: "sphere-circle".to_owned(),
            bench: "default".to_owned(),
            seed: 7,
            scene_digest: "0123456789abcdef".to_owned(),
            limits_digest: "fedcba9876543210".to_owned(),
            pre_scale: Prescale::new(30),
            tau_d_us: TAU_US,
            soa_us: SOA_US,
            person: "typical".to_owned(),
            preset: "thin".to_owned(),
            illusion: "log".to_owned(),
            kc: 1,
            taxels,
            wires,
            displays: Vec::new(),
            joints: Vec::new(),
            warmth: false,
            motors: false,
        },
        events: Vec::new(),
        ledger: Ledger::default(),
    }
}

/// A small deterministic noise in -1 ..= 1.
fn noise(i: u64) -> f64 {
    let mut x = i.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x ^= x >> 29;
    x = x.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x ^= x >> 32;
    (x % 2001) as f64 / 1000.0 - 1.0
}

fn truth(t: f64) -> Option<(f64, f64, f64)> {
    // Touches down at 0.5 s; lifts for 0.3 s every 4 s.
    if t < 0.5 || t % 4.0 > 3.7 {
        return None;
    }
    let a = (t - 0.5) * 1.6;
    Some((7.05 * a.cos(), 7.05 * a.sin(), 0.9 + 0.5 * (t * 2.1).sin()))
}

fn activation(d: (f64, f64)) -> Vec<f64> {
    let axis = |v: f64, span: f64| (1.0 - (v.abs() + 1.0).log2() / (span + 1.0).log2()).max(0.0);
    WIRES
        .iter()
        .map(|w| axis(d.0 - w.0, 11.0) * axis(d.1 - w.1, 9.5))
        .collect()
}

/// The scans: truth and what was found of it.
fn frames(events: &mut Vec<Event>, seconds: u64) {
    for frame in 0..seconds * 100 {
        let t_us = (frame + 1) * 10_000;
        let touched = truth(t_us as f64 * 1e-6);
        let members = touched.map_or(0, |(_, _, f)| (f * 8.0) as u16);
        events.push(Event::Frame(event::Frame {
            t_us,
            frame: frame as u32,
            in_contact: members,
            peak_counts: u32::from(members) * 120,
        }));
        if let Some((x, y, f)) = touched {
            events.push(Event::Truth(event::Truth {
                t_us,
                place: um(x, y),
                force_mn: (f * 1000.0) as u32,
            }));
            let x = x * 0.86 + 0.12 * noise(frame * 2);
            let y = y * 0.86 + 0.12 * noise(frame * 2 + 1);
            events.push(Event::Contact(event::Contact {
                t_us,
                frame: frame as u32,
                module: 0,
                contact: 1 + (t_us / 4_000_000) as u32,
                place: um(x, y),
                intensity_milli: (f * 900_000.0) as u32,
                level: (f * 7.0) as u16,
                members: members.into(),
            }));
        }
    }
}

/// What is felt of an onset; the activation of each wire.
fn felt(events: &mut Vec<Event>, t_us: u64) -> Vec<f64> {
    let mut drive = vec![0.0; 8];
    if let Some((x, y, _)) = truth(t_us as f64 * 1e-6) {
        let d = (x * 0.86 * 11.0 / 7.05, y * 0.86 * 14.25 / 7.05);
        drive = activation(d);
        let total: f64 = drive.iter().map(|a| a * a).sum();
        let strongest = drive.iter().copied().fold(0.0, f64::max);
        let met = (strongest > 0.0).then(|| {
            let mean = |pick: fn(&(f64, f64)) -> f64| {
                WIRES
                    .iter()
                    .zip(&drive)
                    .map(|(w, a)| pick(w) * a * a)
                    .sum::<f64>()
                    / total
            };
            let at = um(mean(|w| w.0), mean(|w| w.1));
            FeltAt {
                energy: at,
                amplitude: at,
                level_mdb: (20e3 * (strongest / 0.17).log10()) as i32,
                skin_nm: (9e3 * strongest) as i32,
                tap: false,
            }
        });
        let inside = d.0.abs() / 11.0 + d.1.abs() / 28.0 < 1.0;
        events.push(Event::Felt(event::Felt {
            t_us,
            target: um(d.0, d.1),
            inside,
            met,
            energy: EnergyPermille {
                requested: (total * 1e3) as u32,
                applied: (total * 1e3) as u32,
                felt: (total * 2e3) as u32,
            },
        }));
    }
    drive
}

/// What a wire is told at an onset.
fn entry(wire: usize, t_us: u64, requested: u16, width: u16) -> Entry {
    let on = 256 * wire as u16;
    Entry {
        at: Instant::from_micros(t_us),
        board: Board(0),
        channel: Channel(wire as u8),
        on,
        off: on + width,
        until: Instant::from_micros(t_us + TAU_US),
        requested: Ticks::new(requested),
        requested_until: Instant::from_micros(t_us + TAU_US),
        current: None,
        reason: (width != requested).then_some(Reason::WirePower),
    }
}

fn margins() -> Vec<Margin> {
    vec![
        Margin::new(Limited::SupplyCurrent, 1.97, 2.5),
        Margin::new(Limited::Burst, 30.596, 50.0),
        Margin::new(Limited::SkinPeak, 36.48, 43.0),
        Margin::new(Limited::SkinMean, 34.1, 41.0),
        Margin::new(Limited::SkinDeep, 33.5, 41.0),
        Margin::new(Limited::Henriques, 1e-7, 0.01),
    ]
}

/// A sphere rolled in a circle for `seconds`, with a limiter event now and then, breaks and notes.
pub(crate) fn circle(seconds: u64) -> Trace {
    let mut trace = empty();
    let events = &mut trace.events;
    events.push(Event::PreScale(event::PreScale {
        t_us: 0,
        board: 0,
        pre_scale: 30,
    }));
    let end = seconds * 1_000_000;
    frames(events, seconds);
    let mut heat = [33.0f64; 8];
    let mut hottest = (0, 0);
    for onset in 0..=(end - 1) / SOA_US {
        let t_us = onset * SOA_US;
        let drive = felt(events, t_us);
        for (wire, a) in drive.iter().enumerate() {
            let requested = Ticks::from_duty((a * 0.0244) as f32).get();
            let limited = wire == 2 && onset % 40 == 17;
            let refused = wire == 2 && onset % 40 == 18;
            let width = match (limited, refused) {
                (_, true) => 0,
                (true, _) => requested / 2,
                _ => requested,
            };
            if requested > 0 {
                trace.ledger.energy_uj += u64::from(width) * 64;
                let entry = entry(wire, t_us, requested, width);
                trace.ledger.driven.add(&entry);
                events.push(Event::Schedule(entry));
                if width > 0 {
                    events.push(Event::Schedule(Entry {
                        at: entry.until,
                        off: entry.on,
                        requested: Ticks::new(0),
                        reason: None,
                        ..entry
                    }));
                }
            }
            for step in 0..6 {
                let within = step * 10_000 < TAU_US;
                let gain = if within {
                    f64::from(width) * 0.055
                } else {
                    0.0
                };
                heat[wire] += gain - (heat[wire] - 33.0) * 0.22;
                let milli_c = (heat[wire] * 1000.0) as i32;
                let t_us = t_us + step * 9_750;
                events.push(Event::Wire(event::Temperature {
                    t_us,
                    wire: wire as u16,
                    milli_c,
                }));
                if milli_c > hottest.0 {
                    hottest = (milli_c, wire as u16);
                }
            }
        }
    }
    events.push(Event::Note(event::Note {
        t_us: end / 2,
        text: "taxel 7 frozen for 250 ms, left out".to_owned(),
    }));
    events.push(Event::AllOff(event::AllOff {
        t_us: end,
        board: 0,
        cause: "end-of-run",
    }));
    events.sort_by_key(Event::t_ns);
    trace.ledger.hottest_wire = Some(hottest);
    trace.ledger.margins = margins();
    trace.ledger.length_us = end;
    trace
}
