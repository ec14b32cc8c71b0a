//! The guard of an image decides as the same guard does here, whatever it is asked.
//!
//! `PALPATE_DECISIONS` says how many schedules of 20 questions (default 1000).

use palpate_core::guard::{Guard, Plant};
use palpate_core::random::RandomStream;
use palpate_core::units::{Board, Duration, Instant, Ticks};
use palpate_image::rig::{Kind, Outcome};
use palpate_image::{ANSWER, QUESTION, Question, answer};
use palpate_qemu::{Guest, LIMITS, Machine, Network, WIRES};

use super::machines::{image, in_qemu};

/// A guard in an image, and one like it here.
pub struct Pair {
    guest: Guest,
    here: Guard,
}

impl Pair {
    /// Both, new.
    pub fn new(machine: Machine) -> Self {
        let guest = Guest::start(machine, &image(&machine, "guard"), Network::Rig);
        Self {
            guest: guest.unwrap(),
            here: Guard::last_word(LIMITS, Plant::default(), &WIRES, None).unwrap(),
        }
    }

    /// Asks both. Returns what the image's clock counted; both answers are the same.
    pub fn ask(&mut self, at: Instant, question: &Question<'_>) -> u32 {
        let mut bytes = [0; QUESTION];
        let bytes = question.write(at, &mut bytes);
        let mut told = [0; ANSWER];
        let (length, _) = answer(&mut self.here, bytes, || 0, &mut told);
        let (head, _) = self.guest.question().unwrap();
        assert_eq!(head.kind(), Some(Kind::Ask));
        self.guest.answer(0, Outcome::Done, bytes).unwrap();
        let (head, there) = self.guest.question().unwrap();
        assert_eq!(head.kind(), Some(Kind::Tell), "the image began anew");
        self.guest.answer(0, Outcome::Done, &[]).unwrap();
        let (took, there) = there.split_first_chunk().unwrap();
        assert_eq!(there, &told[..length], "{question:?} at {at}");
        u32::from_le_bytes(*took)
    }

    /// What the image runs on.
    pub const fn machine(&self) -> &Machine {
        self.guest.machine()
    }

    /// The guard here, to look at.
    pub fn here(&self) -> &Guard {
        &self.here
    }
}

/// Stimuli that dwell, move, overlap and ask for too much.
fn stimuli(s: &mut RandomStream, board: u8) -> Vec<(u16, Ticks, Duration)> {
    let count = s.next_u64() % 9;
    let one = |_| {
        // Now and then a wire of the other board, or none.
        let wire = match s.next_u64() % 32 {
            0 => s.next_u64() % 20,
            _ => u64::from(board) * 8 + s.next_u64() % 8,
        };
        let width = match s.next_u64() % 4 {
            0 => s.next_u64() % 4097,
            _ => s.next_u64() % 200,
        };
        let length = match s.next_u64() % 8 {
            0 => s.next_u64() % 5_000_000,
            _ => s.next_u64() % 60_000,
        };
        (
            wire as u16,
            Ticks::new(width as u16),
            Duration::from_micros(length),
        )
    };
    (0..count).map(one).collect()
}

in_qemu!(an_image_decides_as_the_guard_does_here);

fn an_image_decides_as_the_guard_does_here(machine: Machine) {
    let schedules = std::env::var("PALPATE_DECISIONS").map_or(1000, |n| n.parse().unwrap());
    let mut pair = Pair::new(machine);
    let mut s = RandomStream::new(1, "hostile decisions");
    let mut at = Instant::from_micros(1000);
    let (mut on, mut latched) = (0u64, 0u64);
    for schedule in 0..schedules {
        // Budgets are full again after a minute; most schedules find them as they are.
        at += match schedule % 10 {
            0 => Duration::from_millis(61_000),
            _ => Duration::from_millis(s.next_u64() % 2000),
        };
        for question in [Question::Watch, Question::Hear, Question::Reset] {
            pair.ask(at, &question);
        }
        for _ in 0..20 {
            at += Duration::from_micros(s.next_u64() % 30_000);
            let board = Board((s.next_u64() % 2) as u8);
            // A loop that looks is the rule.
            if !s.next_u64().is_multiple_of(32) {
                pair.ask(at, &Question::Watch);
            }
            let question = match s.next_u64() % 20 {
                0..=3 => Question::Expire(board),
                4..=8 => Question::Hear,
                9 if s.next_u64().is_multiple_of(16) => Question::Stop,
                _ => {
                    pair.ask(at, &Question::Change(board, &stimuli(&mut s, board.0)));
                    on += u64::from(pair.here().next_expiry().is_some());
                    continue;
                }
            };
            pair.ask(at, &question);
            latched += u64::from(pair.here().latched().is_some());
        }
    }
    println!("{schedules} schedules of 20 questions; {on} left wires on, {latched} met a latch");
    assert!(
        on > 4 * schedules && latched * 4 > schedules,
        "too tame: {on} {latched}"
    );
}
