//! Events as tables: one per kind of event, with the columns that Python sees.

use palpate_core::schedule::Entry;
use palpate_records::margin::Margin;
use palpate_records::readings::Readings;
use palpate_records::report::Warmth;
use palpate_records::trace::event::each;
use palpate_records::trace::{Event, FeltAt, Header, event};

use crate::table::Table;

/// Facts of a run that its tables need besides the events.
#[derive(Clone, Debug)]
pub struct About {
    /// Board and channel of each wire.
    outputs: Vec<(u8, u8)>,
    period_ns: u64,
}

impl About {
    /// Facts of a run.
    pub fn new(header: &Header) -> Self {
        Self {
            outputs: header.wires.iter().map(|w| (w.board, w.channel)).collect(),
            period_ns: header.pre_scale.period_ns(),
        }
    }
}

/// The value of so many thousandths.
fn milli(value: impl Into<f64>) -> f64 {
    value.into() * 1e-3
}

/// Table of this name; `None` for an unknown name.
pub fn table(name: &str, events: &[Event], about: &About) -> Option<Table> {
    Some(match name {
        "frames" => frames(events),
        "contacts" => contacts(&each(events).copied().collect::<Vec<_>>()),
        "truth" => truth(events),
        "stimuli" => stimuli(events, about),
        "edges" => edges(events),
        "felt" => felt(events),
        "temperatures" => temperatures(events),
        "notes" => notes(events),
        _ => return None,
    })
}

fn frames(events: &[Event]) -> Table {
    let rows: Vec<&event::Frame> = each(events).collect();
    Table::default()
        .with("frame", &rows, |r| r.frame)
        .with("time_us", &rows, |r| r.t_us)
        .with("taxels_in_contact", &rows, |r| r.in_contact)
        .with("peak_counts", &rows, |r| r.peak_counts)
}

/// Contacts of every frame.
pub fn contacts(rows: &[event::Contact]) -> Table {
    Table::default()
        .with("frame", rows, |r| r.frame)
        .with("time_us", rows, |r| r.t_us)
        .with("module", rows, |r| r.module)
        .with("contact", rows, |r| r.contact)
        .with("x_mm", rows, |r| milli(r.place.x))
        .with("y_mm", rows, |r| milli(r.place.y))
        .with("intensity", rows, |r| milli(r.intensity_milli))
        .with("level", rows, |r| r.level)
        .with("members", rows, |r| r.members)
}

fn truth(events: &[Event]) -> Table {
    let rows: Vec<&event::Truth> = each(events).collect();
    Table::default()
        .with("time_us", &rows, |r| r.t_us)
        .with("x_mm", &rows, |r| milli(r.place.x))
        .with("y_mm", &rows, |r| milli(r.place.y))
        .with("force_n", &rows, |r| milli(r.force_mn))
}

/// Stimuli of the wires: requested, and applied by the guard.
pub fn stimuli(events: &[Event], about: &About) -> Table {
    let rows: Vec<&Entry> = each(events).collect();
    let wire = |output: (u8, u8)| about.outputs.iter().position(|o| *o == output);
    Table::default()
        .with("time_us", &rows, |e| e.at.as_micros())
        // Outputs are those of the wires: an entry of another is none.
        .with("wire", &rows, |e| {
            wire((e.board.0, e.channel.0)).map_or(u16::MAX, |w| w as u16)
        })
        .with("board", &rows, |e| e.board.0)
        .with("channel", &rows, |e| e.channel.0)
        .with("on", &rows, |e| e.on)
        .with("off", &rows, |e| e.off)
        .with("width", &rows, |e| e.width().get())
        .with("requested", &rows, |e| e.requested.get())
        .with("pulses", &rows, |e| e.pulses(about.period_ns))
        .with("until_us", &rows, |e| e.until.as_micros())
        .with("requested_until_us", &rows, |e| {
            e.requested_until.as_micros()
        })
        .with("reason", &rows, |e| {
            e.reason.map_or("", |r| r.word()).to_owned()
        })
}

fn edges(events: &[Event]) -> Table {
    let rows: Vec<&event::Edge> = each(events).collect();
    Table::default()
        .with("time_ns", &rows, |r| r.t_ns)
        .with("board", &rows, |r| r.board)
        .with("channel", &rows, |r| r.channel)
        .with("high", &rows, |r| r.high)
}

fn felt(events: &[Event]) -> Table {
    let rows: Vec<&event::Felt> = each(events).collect();
    // Where no wire moved there is no place.
    let of_met =
        |r: &event::Felt, of: fn(FeltAt) -> i32| r.met.map_or(f64::NAN, |met| milli(of(met)));
    let level = |met: Option<FeltAt>| met.map_or(f64::NEG_INFINITY, |m| milli(m.level_mdb));
    Table::default()
        .with("time_us", &rows, |r| r.t_us)
        .with("target_x_mm", &rows, |r| milli(r.target.x))
        .with("target_y_mm", &rows, |r| milli(r.target.y))
        .with("inside", &rows, |r| r.inside)
        .with("felt", &rows, |r| r.is_felt())
        .with("x_mm", &rows, |r| of_met(r, |m| m.energy.x))
        .with("y_mm", &rows, |r| of_met(r, |m| m.energy.y))
        .with("amplitude_x_mm", &rows, |r| of_met(r, |m| m.amplitude.x))
        .with("amplitude_y_mm", &rows, |r| of_met(r, |m| m.amplitude.y))
        .with("level_db", &rows, |r| level(r.met))
        .with("skin_um", &rows, |r| {
            r.met.map_or(0.0, |m| milli(m.skin_nm))
        })
        .with("tap", &rows, |r| r.met.is_some_and(|met| met.tap))
        .with("energy_requested", &rows, |r| milli(r.energy.requested))
        .with("energy_applied", &rows, |r| milli(r.energy.applied))
        .with("energy_felt", &rows, |r| milli(r.energy.felt))
}

fn temperatures(events: &[Event]) -> Table {
    let mut rows: Vec<(u64, u16, f64, f64)> = Vec::new();
    for event in events {
        match event {
            Event::Wire(now) => rows.push((now.t_us, now.wire, milli(now.milli_c), f64::NAN)),
            // The skin under a wire is sampled with the wire.
            Event::Skin(now) => {
                let mut same = rows.iter_mut().rev().take_while(|r| r.0 == now.t_us);
                match same.find(|r| r.1 == now.wire) {
                    Some(row) => row.3 = milli(now.milli_c),
                    None => rows.push((now.t_us, now.wire, f64::NAN, milli(now.milli_c))),
                }
            }
            _ => {}
        }
    }
    Table::default()
        .with("time_us", &rows, |r| r.0)
        .with("wire", &rows, |r| r.1)
        .with("wire_c", &rows, |r| r.2)
        .with("skin_c", &rows, |r| r.3)
}

fn notes(events: &[Event]) -> Table {
    let note = |event: &Event| match event {
        Event::Note(note) => Some((note.t_us, note.text.clone())),
        Event::AllOff(off) => Some((
            off.t_us,
            format!("board {}: all off: {}", off.board, off.cause),
        )),
        _ => None,
    };
    let rows: Vec<_> = events.iter().filter_map(note).collect();
    Table::default()
        .with("time_us", &rows, |r| r.0)
        .with("text", &rows, |r| r.1.clone())
}

/// The worst values of a run, and their limits.
pub fn margins(rows: &[Margin]) -> Table {
    Table::default()
        .with("name", rows, |m| m.of.name().to_owned())
        .with("unit", rows, |m| m.of.unit().to_owned())
        .with("worst", rows, Margin::worst)
        .with("limit", rows, Margin::limit)
        .with("left", rows, Margin::left)
        .with("used", rows, Margin::used)
}

/// The hottest of wires and skin over time.
pub fn warmth(rows: &[Warmth]) -> Table {
    Table::default()
        .with("time_us", rows, |w| (w.t_s * 1e6).round() as u64)
        .with("wire_c", rows, |w| w.wire_c)
        .with("skin_c", rows, |w| w.shallow_c)
        .with("deep_c", rows, |w| w.deep_c)
        .with("mean_c", rows, |w| w.mean_c)
}

/// Readings of every taxel, frame by frame. `numbers` gives the modules' numbers where they are another's.
pub fn taxels(readings: Option<&Readings>, numbers: &[u16]) -> Table {
    let modules = readings.map_or(&[][..], Readings::modules);
    let places: Vec<(u16, u16)> = (0u16..)
        .zip(modules)
        .flat_map(|(m, module)| {
            let number = numbers.get(usize::from(m)).copied().unwrap_or(m);
            (0..module.taxels.len() as u16).map(move |taxel| (number, taxel))
        })
        .collect();
    let frames = readings.map_or(&[][..], Readings::frames);
    let rows: Vec<(u64, (u16, u16), [u16; 4])> = frames
        .iter()
        .flat_map(|frame| {
            let each = places.iter().zip(frame.readings.iter());
            each.map(|(place, reading)| (frame.t_us, *place, *reading))
        })
        .collect();
    Table::default()
        .with("time_us", &rows, |r| r.0)
        .with("module", &rows, |r| r.1.0)
        .with("taxel", &rows, |r| r.1.1)
        .with("x", &rows, |r| r.2[0])
        .with("y", &rows, |r| r.2[1])
        .with("z", &rows, |r| r.2[2])
        .with("change", &rows, |r| r.2[3])
}
