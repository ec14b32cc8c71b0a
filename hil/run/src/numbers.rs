//! Translates a finger's trace into the numbers of bench and skin, and into the records that all fingers share.

use std::collections::BTreeMap;

use palpate_core::units::{Board, Instant};
use palpate_files::Setup;
use palpate_records::trace::{DisplayInfo, Event, Header, event};

use crate::place::Place;
use crate::verdict::STOPPED_BY;

impl Place {
    /// Name of the display; empty for the only one of a bench.
    #[must_use]
    pub fn display(&self) -> &str {
        self.name.as_deref().unwrap_or_default()
    }

    fn of_board(&self, own: u8) -> u8 {
        self.boards.get(usize::from(own)).copied().unwrap_or(own)
    }

    /// Gives the boards of its header the bench's numbers; wires stay its own.
    pub fn number_header(&self, header: &mut Header) {
        for wire in &mut header.wires {
            wire.board = self.of_board(wire.board);
        }
    }

    /// Gives an event's boards and modules the numbers of bench and skin; wires stay its own.
    pub fn number(&self, event: &mut Event) {
        match event {
            Event::Schedule(entry) => entry.board = Board(self.of_board(entry.board.0)),
            Event::PreScale(event::PreScale { board, .. })
            | Event::AllOff(event::AllOff { board, .. })
            | Event::Edge(event::Edge { board, .. }) => *board = self.of_board(*board),
            Event::Contact(now) => {
                let number = self.modules.get(usize::from(now.module));
                now.module = number.map_or(now.module, |m| *m as u16); // a skin has fewer modules than that
            }
            _ => {}
        }
    }

    /// A numbered event for the common trace: notes name their display. Sensations are each display's own, and events
    /// of a whole board come from [`whole_boards`]. The only display's trace is the common one.
    #[must_use]
    pub fn joined(&self, event: &Event) -> Option<Event> {
        let mut event = event.clone();
        if self.name.is_none() {
            return Some(event);
        }
        match &mut event {
            Event::Truth(_) | Event::Felt(_) | Event::Latent(_) | Event::PreScale(_) => {
                return None;
            }
            Event::AllOff(off) => {
                if ["start", "end"].contains(&off.cause) {
                    return None;
                }
                let text = format!("its wires on board {} off: {}", off.board, off.cause);
                event = Event::note(
                    Instant::from_micros(off.t_us),
                    format!("{}: {text}", self.display()),
                );
            }
            // A run is stopped as a whole: one note is enough.
            Event::Note(note) if note.text.starts_with(STOPPED_BY) => return None,
            Event::Note(note) => note.text = format!("{}: {}", self.display(), note.text),
            Event::Wire(now) | Event::Skin(now) => now.wire += self.first_wire as u16,
            _ => {}
        }
        Some(event)
    }
}

/// The header of all fingers' records, from theirs with the bench's numbers.
pub fn joined_header(setup: &Setup, fingers: &[(&Place, &Header)]) -> Header {
    let mut header = fingers[0].1.clone();
    header.bench.clone_from(&setup.bench.value.name);
    let wires = fingers.iter().flat_map(|(_, own)| own.wires.clone());
    header.wires = wires.collect();
    let displayed = |(place, _): &(&Place, &Header)| DisplayInfo {
        name: place.display().to_owned(),
        wires: place.wires,
        modules: place.modules.iter().map(|m| *m as u16).collect(),
    };
    header.displays = fingers.iter().map(displayed).collect();
    header
}

/// Records of whole boards, where all displays on a board have them alike, once.
pub fn whole_boards(fingers: &[(&Place, &[Event])]) -> Vec<Event> {
    let mut alike: BTreeMap<(u64, u8, String), (usize, Event)> = BTreeMap::new();
    for event in fingers.iter().flat_map(|(_, events)| *events) {
        if let Event::AllOff(event::AllOff { t_us, board, .. })
        | Event::PreScale(event::PreScale { t_us, board, .. }) = event
        {
            let key = (*t_us, *board, format!("{event:?}"));
            alike.entry(key).or_insert_with(|| (0, event.clone())).0 += 1;
        }
    }
    let on = |board: u8| {
        let places = fingers.iter().map(|(place, _)| place);
        places.filter(|p| p.boards.contains(&board)).count()
    };
    let whole = alike
        .into_iter()
        .filter(|((_, board, _), (count, _))| *count == on(*board));
    whole.map(|(_, (_, event))| event).collect()
}
