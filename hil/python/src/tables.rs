//! What happened, as tables: one per kind of event, with the columns that Python sees.

use palpate_records::margin::Margin;
use palpate_records::readings::Readings;
use palpate_records::report::Warmth;
use palpate_records::trace::{Event, FeltAt, Header, PlaceUm};

use crate::table::Table;

/// What of a run its tables need beside the events.
#[derive(Clone, Debug)]
pub struct About {
    /// Board and channel of each wire.
    outputs: Vec<(u8, u8)>,
    period_ns: u64,
}

impl About {
    /// Of a run.
    pub fn new(header: &Header) -> Self {
        Self {
            outputs: header.wires.iter().map(|w| (w.board, w.channel)).collect(),
            period_ns: header.pre_scale.period_ns(),
        }
    }
}

fn mm(um: i32) -> f64 {
    f64::from(um) * 1e-3
}

fn milli(value: impl Into<f64>) -> f64 {
    value.into() * 1e-3
}

/// The table of this name; none where there is no such.
pub fn of(name: &str, events: &[Event], about: &About) -> Option<Table> {
    Some(match name {
        "frames" => frames(events),
        "contacts" => contacts(events),
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
    let frame = |event: &Event| match *event {
        Event::Frame {
            t_us,
            frame,
            in_contact,
            peak_counts,
        } => Some((frame, t_us, in_contact, peak_counts)),
        _ => None,
    };
    let rows: Vec<_> = events.iter().filter_map(frame).collect();
    Table::default()
        .with("frame", &rows, |r| r.0)
        .with("time_us", &rows, |r| r.1)
        .with("taxels_in_contact", &rows, |r| r.2)
        .with("peak_counts", &rows, |r| r.3)
}

/// Contacts of every frame.
pub fn contacts(events: &[Event]) -> Table {
    let contact = |event: &Event| match *event {
        Event::Contact {
            t_us,
            frame,
            module,
            contact,
            place,
            intensity_milli,
            level,
            members,
        } => Some((
            (frame, t_us, module, contact),
            (place, intensity_milli, level, members),
        )),
        _ => None,
    };
    let rows: Vec<_> = events.iter().filter_map(contact).collect();
    Table::default()
        .with("frame", &rows, |r| r.0.0)
        .with("time_us", &rows, |r| r.0.1)
        .with("module", &rows, |r| r.0.2)
        .with("contact", &rows, |r| r.0.3)
        .with("x_mm", &rows, |r| mm(r.1.0.x))
        .with("y_mm", &rows, |r| mm(r.1.0.y))
        .with("intensity", &rows, |r| milli(r.1.1))
        .with("level", &rows, |r| r.1.2)
        .with("members", &rows, |r| r.1.3)
}

fn truth(events: &[Event]) -> Table {
    let truth = |event: &Event| match *event {
        Event::Truth {
            t_us,
            place,
            force_mn,
        } => Some((t_us, place, force_mn)),
        _ => None,
    };
    let rows: Vec<_> = events.iter().filter_map(truth).collect();
    Table::default()
        .with("time_us", &rows, |r| r.0)
        .with("x_mm", &rows, |r| mm(r.1.x))
        .with("y_mm", &rows, |r| mm(r.1.y))
        .with("force_n", &rows, |r| milli(r.2))
}

/// What the wires were told.
pub fn stimuli(events: &[Event], about: &About) -> Table {
    let entry = |event: &Event| match event {
        Event::Schedule(entry) => Some(*entry),
        _ => None,
    };
    let rows: Vec<_> = events.iter().filter_map(entry).collect();
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
    let edge = |event: &Event| match *event {
        Event::Edge {
            t_ns,
            board,
            channel,
            high,
        } => Some((t_ns, board, channel, high)),
        _ => None,
    };
    let rows: Vec<_> = events.iter().filter_map(edge).collect();
    Table::default()
        .with("time_ns", &rows, |r| r.0)
        .with("board", &rows, |r| r.1)
        .with("channel", &rows, |r| r.2)
        .with("high", &rows, |r| r.3)
}

fn felt(events: &[Event]) -> Table {
    let felt = |event: &Event| match *event {
        Event::Felt {
            t_us,
            target,
            inside,
            met,
            energy,
        } => Some((t_us, target, inside, met, energy)),
        _ => None,
    };
    let rows: Vec<_> = events.iter().filter_map(felt).collect();
    // Where no wire moved there is no place.
    let place = |met: Option<FeltAt>, of: fn(FeltAt) -> PlaceUm| met.map(of);
    let x = |at: Option<PlaceUm>| at.map_or(f64::NAN, |p| mm(p.x));
    let y = |at: Option<PlaceUm>| at.map_or(f64::NAN, |p| mm(p.y));
    let level = |met: Option<FeltAt>| met.map_or(f64::NEG_INFINITY, |m| milli(m.level_mdb));
    Table::default()
        .with("time_us", &rows, |r| r.0)
        .with("target_x_mm", &rows, |r| mm(r.1.x))
        .with("target_y_mm", &rows, |r| mm(r.1.y))
        .with("inside", &rows, |r| r.2)
        .with("felt", &rows, |r| r.3.is_some_and(|met| met.is_felt()))
        .with("x_mm", &rows, |r| x(place(r.3, |m| m.energy)))
        .with("y_mm", &rows, |r| y(place(r.3, |m| m.energy)))
        .with("amplitude_x_mm", &rows, |r| x(place(r.3, |m| m.amplitude)))
        .with("amplitude_y_mm", &rows, |r| y(place(r.3, |m| m.amplitude)))
        .with("level_db", &rows, |r| level(r.3))
        .with("tap", &rows, |r| r.3.is_some_and(|met| met.tap))
        .with("energy_requested", &rows, |r| milli(r.4.requested))
        .with("energy_applied", &rows, |r| milli(r.4.applied))
        .with("energy_felt", &rows, |r| milli(r.4.felt))
}

fn temperatures(events: &[Event]) -> Table {
    let mut rows: Vec<(u64, u16, f64, f64)> = Vec::new();
    for event in events {
        match *event {
            Event::Wire {
                t_us,
                wire,
                milli_c,
            } => rows.push((t_us, wire, milli(milli_c), f64::NAN)),
            // The skin under a wire is looked at with the wire.
            Event::Skin {
                t_us,
                wire,
                milli_c,
            } => {
                let mut now = rows.iter_mut().rev().take_while(|r| r.0 == t_us);
                match now.find(|r| r.1 == wire) {
                    Some(row) => row.3 = milli(milli_c),
                    None => rows.push((t_us, wire, f64::NAN, milli(milli_c))),
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
        Event::Note { t_us, text } => Some((*t_us, text.clone())),
        Event::AllOff { t_us, board, cause } => {
            Some((*t_us, format!("board {board}: all off: {cause}")))
        }
        _ => None,
    };
    let rows: Vec<_> = events.iter().filter_map(note).collect();
    Table::default()
        .with("time_us", &rows, |r| r.0)
        .with("text", &rows, |r| r.1.clone())
}

/// The worst of a run beside its limits.
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

/// What every taxel read, frame by frame; its modules by these numbers, where they are another's.
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
