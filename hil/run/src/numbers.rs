//! What a finger's run says, in the numbers of bench and skin, and as the records have it that all fingers share.

use std::collections::BTreeMap;

use palpate_core::units::Board;
use palpate_files::Setup;
use palpate_records::trace::{DisplayInfo, Event, Header};

use crate::place::Place;
use crate::verdict::STOPPED_BY;

impl Place {
    /// Its name; empty for the only display of a bench.
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
            Event::PreScale { board, .. }
            | Event::AllOff { board, .. }
            | Event::Edge { board, .. } => *board = self.of_board(*board),
            Event::Contact { module, .. } => {
                let own = usize::from(*module);
                *module = self.modules.get(own).map_or(*module, |m| *m as u16); // a skin has fewer modules than that
            }
            _ => {}
        }
    }

    /// A numbered event as the common trace has it: notes say whose they are; what is felt of which touch is each
    /// display's own, and what befalls a whole board is told by [`whole_boards`].
    #[must_use]
    pub fn joined(&self, event: &Event) -> Option<Event> {
        let first = self.first_wire as u16;
        match event.clone() {
            Event::Truth { .. } | Event::Felt { .. } | Event::Latent { .. } => None,
            Event::PreScale { .. } => None,
            Event::AllOff { t_us, board, cause } => match cause {
                "start" | "end" => None,
                _ => Some(Event::Note {
                    t_us,
                    text: format!(
                        "{}: its wires on board {board} off: {cause}",
                        self.display()
                    ),
                }),
            },
            // A run is stopped as a whole: one note says so.
            Event::Note { text, .. } if text.starts_with(STOPPED_BY) => None,
            Event::Note { t_us, text } => Some(Event::Note {
                t_us,
                text: format!("{}: {text}", self.display()),
            }),
            Event::Wire {
                t_us,
                wire,
                milli_c,
            } => Some(Event::Wire {
                t_us,
                wire: first + wire,
                milli_c,
            }),
            Event::Skin {
                t_us,
                wire,
                milli_c,
            } => Some(Event::Skin {
                t_us,
                wire: first + wire,
                milli_c,
            }),
            event => Some(event),
        }
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
        if let Event::AllOff { t_us, board, .. } | Event::PreScale { t_us, board, .. } = event {
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
