//! The stimuli in time to come: as many as one command carries, replaced by each.

use alloc::boxed::Box;
use alloc::vec;

use palpate_core::codec::link::{MOST_PLANNED, Planned};
use palpate_core::illusion::DisplayWire;
use palpate_core::units::{Board, Channel, Duration, Instant};

/// A stimulus further ahead than this is left out: the guard's rows refill meanwhile, and a host that plans so far ahead
/// says nothing of a hand that moves.
const HORIZON: Duration = Duration::from_millis(1000);

/// The newest plan, and the stimuli of it that have begun.
#[derive(Debug)]
pub(crate) struct Schedule {
    planned: Box<[Planned]>,
    count: usize,
    wires: Wires,
    /// The onset of each wire's newest stimulus that has begun: none of the same or an earlier time begins again.
    begun: Box<[Option<Instant>]>,
}

/// Index of the wire on each channel, by board and channel.
#[derive(Debug)]
pub(crate) struct Wires([[Option<u16>; 16]; 16]);

impl Wires {
    fn new(wires: &[DisplayWire]) -> Self {
        let mut table = [[None; 16]; 16];
        for (index, wire) in (0..).zip(wires) {
            let board = table.get_mut(usize::from(wire.board.0));
            if let Some(slot) = board.and_then(|b| b.get_mut(usize::from(wire.channel.0))) {
                *slot = Some(index);
            }
        }
        Self(table)
    }

    fn number(&self, board: Board, channel: Channel) -> Option<u16> {
        let board = self.0.get(usize::from(board.0))?;
        *board.get(usize::from(channel.0))?
    }

    /// Channels that carry a wire, a bit each, by board.
    pub(crate) fn bits(&self) -> [u16; 16] {
        self.0.map(|board| {
            let each = board.iter().enumerate();
            each.fold(0, |bits, (n, wire)| bits | u16::from(wire.is_some()) << n)
        })
    }
}

impl Schedule {
    pub(crate) fn new(wires: &[DisplayWire]) -> Self {
        Self {
            planned: vec![Planned::NONE; MOST_PLANNED].into(),
            count: 0,
            wires: Wires::new(wires),
            begun: vec![None; wires.len()].into(),
        }
    }

    pub(crate) const fn wires(&self) -> &Wires {
        &self.wires
    }

    pub(crate) const fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes a plan over. Returns how many of its stimuli it leaves out: without a wire, or too far ahead.
    pub(crate) fn replace(&mut self, now: Instant, plan: impl Iterator<Item = Planned>) -> u32 {
        self.clear();
        let mut left_out = 0;
        for planned in plan {
            let Some(wire) = self.wires.number(planned.board, planned.channel) else {
                left_out += 1;
                continue;
            };
            let begun = self.begun.get(usize::from(wire)).copied().flatten();
            if begun.is_some_and(|at| planned.at <= at) {
                continue;
            }
            match self.planned.get_mut(self.count) {
                Some(slot) if planned.at <= now + HORIZON => {
                    *slot = planned;
                    self.count += 1;
                }
                _ => left_out += 1,
            }
        }
        left_out
    }

    /// Onset of the next stimulus.
    pub(crate) fn next(&self) -> Option<Instant> {
        self.planned[..self.count].iter().map(|p| p.at).min()
    }

    /// Takes the stimuli of one board that begin together out of the plan, the earliest that are due first. They stand
    /// in `out` with their wires. Returns board, onset and number.
    pub(crate) fn due(
        &mut self,
        now: Instant,
        out: &mut [(u16, Planned); 16],
    ) -> Option<(Board, Instant, usize)> {
        let planned = &self.planned[..self.count];
        let due = planned.iter().filter(|p| p.at <= now);
        let first = due.min_by_key(|p| (p.at, p.board))?;
        let (at, board) = (first.at, first.board);
        let mut taken = 0;
        let mut kept = 0;
        for index in 0..self.count {
            let planned = self.planned[index];
            let wire = self.wires.number(planned.board, planned.channel);
            let goes = (planned.at, planned.board) == (at, board);
            match (wire, out.get_mut(taken)) {
                (Some(wire), Some(slot)) if goes => {
                    *slot = (wire, planned);
                    taken += 1;
                    if let Some(begun) = self.begun.get_mut(usize::from(wire)) {
                        *begun = Some(at);
                    }
                }
                // More than sixteen: a channel is named twice, and its first line counts.
                _ if goes => {}
                _ => {
                    self.planned[kept] = planned;
                    kept += 1;
                }
            }
        }
        self.count = kept;
        Some((board, at, taken))
    }
}
