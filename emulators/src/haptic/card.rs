//! A sound card with an amplifier behind each of its channels: a queue of samples that plays out at the card's clock.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use palpate_core::driver::{AudioFault, AudioSink};

/// State of a card's stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// No stream was begun.
    Stopped,
    /// The queue plays out.
    Playing,
    /// The queue ran dry, so that the card stopped.
    Dry,
}

/// A sound card. Silence comes out wherever its queue has nothing.
#[derive(Debug)]
pub struct Card {
    /// Samples in a frame.
    width: usize,
    /// Frames of silence before those that are written first.
    latency: u32,
    queue: VecDeque<i16>,
    state: State,
    stalled: bool,
    underruns: u64,
    /// Every sample that was played, if they are kept.
    played: Option<Vec<i16>>,
}

impl Card {
    /// A card at rest.
    pub const fn new(width: usize, latency: u32) -> Self {
        Self {
            width,
            latency,
            queue: VecDeque::new(),
            state: State::Stopped,
            stalled: false,
            underruns: 0,
            played: None,
        }
    }

    /// Plays the next frame into `frame`.
    pub fn play(&mut self, frame: &mut [i16]) {
        frame.fill(0);
        if self.state == State::Playing && !self.stalled {
            if self.queue.len() < self.width {
                self.starve();
            } else {
                for (out, sample) in frame.iter_mut().zip(self.queue.drain(..self.width)) {
                    *out = sample;
                }
            }
        }
        if let Some(played) = &mut self.played {
            played.extend_from_slice(frame);
        }
    }

    /// Lets the queue run dry now.
    pub fn starve(&mut self) {
        if self.state == State::Playing {
            self.queue.clear();
            self.state = State::Dry;
            self.underruns += 1;
        }
    }

    /// Stalls the card: it plays silence, and its queue fills up; or lets it go on.
    pub const fn set_stalled(&mut self, stalled: bool) {
        self.stalled = stalled;
    }

    /// Times the queue has run dry.
    pub const fn underruns(&self) -> u64 {
        self.underruns
    }

    /// Keeps every sample that is played from here on.
    pub fn keep(&mut self) {
        self.played.get_or_insert_default();
    }

    /// Takes the samples that were played and kept.
    pub fn take_played(&mut self) -> Vec<i16> {
        self.played.take().unwrap_or_default()
    }
}

/// A shared card: a driver holds one handle, the coils another.
#[derive(Clone, Debug)]
pub struct CardHandle(Arc<Mutex<Card>>);

impl CardHandle {
    /// Takes the card in.
    pub fn new(card: Card) -> Self {
        Self(Arc::new(Mutex::new(card)))
    }

    /// The card.
    pub fn card(&self) -> MutexGuard<'_, Card> {
        // A thread that panicked in here leaves a card that is still a card.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl AudioSink for CardHandle {
    fn latency(&self) -> u32 {
        self.card().latency
    }

    fn restart(&mut self) -> Result<(), AudioFault> {
        let mut card = self.card();
        if card.stalled {
            return Err(AudioFault::Full);
        }
        let silence = card.latency as usize * card.width;
        card.queue.clear();
        card.queue.resize(silence, 0);
        card.state = State::Playing;
        Ok(())
    }

    fn write(&mut self, samples: &[i16]) -> Result<(), AudioFault> {
        let mut card = self.card();
        // Room for as much again as plays before what is written now.
        let room = 2 * card.latency as usize * card.width;
        match card.state {
            State::Dry | State::Stopped => Err(AudioFault::Underrun),
            State::Playing if card.queue.len() + samples.len() > room => Err(AudioFault::Full),
            State::Playing => {
                card.queue.extend(samples);
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn played(card: &CardHandle) -> [i16; 2] {
        let mut frame = [7; 2];
        card.card().play(&mut frame);
        frame
    }

    #[test]
    fn frames_come_out_after_the_latency_and_silence_where_there_are_none() {
        let mut card = CardHandle::new(Card::new(2, 3));
        assert_eq!(card.write(&[1, 2]), Err(AudioFault::Underrun));
        assert_eq!(played(&card), [0, 0]);
        card.card().keep();
        card.restart().unwrap();
        card.write(&[1, 2, 3, 4]).unwrap();
        let out: Vec<_> = (0..5).map(|_| played(&card)).collect();
        assert_eq!(out, [[0, 0], [0, 0], [0, 0], [1, 2], [3, 4]]);
        assert_eq!(card.card().underruns(), 0);
        assert_eq!(card.card().take_played(), [0, 0, 0, 0, 0, 0, 1, 2, 3, 4]);
        // The queue is dry: silence, whatever is written, until a restart.
        assert_eq!(played(&card), [0, 0]);
        assert_eq!(card.write(&[5, 6]), Err(AudioFault::Underrun));
        assert_eq!(card.card().underruns(), 1);
        assert_eq!(played(&card), [0, 0]);
        card.restart().unwrap();
        assert_eq!(card.write(&[5, 6]), Ok(()));
    }

    #[test]
    fn a_stalled_card_fills_up_and_begins_anew_once_it_plays() {
        let mut card = CardHandle::new(Card::new(2, 3));
        card.restart().unwrap();
        card.card().set_stalled(true);
        card.write(&[9; 6]).unwrap();
        assert_eq!(played(&card), [0, 0]);
        assert_eq!(card.write(&[9; 2]), Err(AudioFault::Full));
        assert_eq!(card.restart(), Err(AudioFault::Full));
        card.card().set_stalled(false);
        card.restart().unwrap();
        let out: Vec<_> = (0..3).map(|_| played(&card)).collect();
        assert_eq!(out, [[0, 0]; 3]);
    }
}
