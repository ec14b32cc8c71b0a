//! The way of samples from a stream to a card's buffers: whole frames, or silence.

use std::io::Read;
use std::iter;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread::{self, JoinHandle};

use cpal::{FromSample, Sample, StreamConfig};
use hound::{SampleFormat, WavIntoSamples, WavReader};
use palpate_run::Failure;

/// Most channels of a stream.
const MOST: u16 = 32;
/// Frames that wait for the card: what a pipe may stall without silence, 0.2 s at 48 kHz.
const WAITING: usize = 9600;

/// A sample of each channel. Whole frames wait, so that no stall moves a sample to another channel.
type Frame = [i16; MOST as usize];

/// The head of a WAV stream.
#[derive(Debug)]
pub struct Stream {
    pub rate_hz: u32,
    pub channels: u16,
    pub frames: u64,
}

impl Stream {
    /// Reads the head of a WAV stream; the samples come after it.
    ///
    /// # Errors
    /// [`Failure::Input`] for anything but PCM of 16 bits.
    pub fn open<R: Read>(input: R) -> Result<(Self, WavIntoSamples<R, i16>), Failure> {
        let reader = WavReader::new(input).map_err(|error| {
            Failure::Input(format!(
                "standard input: expected a WAV stream, as of `hil run --wav -`: {error}"
            ))
        })?;
        let spec = reader.spec();
        let is_16 = spec.sample_format == SampleFormat::Int && spec.bits_per_sample == 16;
        if !is_16 || spec.channels > MOST || spec.sample_rate == 0 {
            return Err(Failure::Input(format!(
                "standard input: expected PCM of 16 bits and at most {MOST} channels, found {} bits ({:?}), {} channels, {} Hz",
                spec.bits_per_sample, spec.sample_format, spec.channels, spec.sample_rate
            )));
        }
        let stream = Self {
            rate_hz: spec.sample_rate,
            channels: spec.channels,
            frames: reader.duration().into(),
        };
        Ok((stream, reader.into_samples()))
    }
}

/// Reads samples into frames in a thread of its own, which ends with the stream and returns the error that cut it
/// short. The receiver between the two closes once there is enough to begin with.
pub fn feed<R: Read + Send + 'static>(
    mut samples: WavIntoSamples<R, i16>,
    channels: u16,
) -> (
    Receiver<Frame>,
    Receiver<()>,
    JoinHandle<Result<(), hound::Error>>,
) {
    let (send, frames) = mpsc::sync_channel(WAITING);
    let (wait, ready) = mpsc::sync_channel::<()>(0);
    let reading = thread::spawn(move || {
        let mut wait = Some(wait);
        for count in 0.. {
            if count == WAITING / 2 {
                wait = None;
            }
            let mut frame = [0; MOST as usize];
            for sample in &mut frame[..channels.into()] {
                match samples.next() {
                    Some(read) => *sample = read?,
                    None => return Ok(()),
                }
            }
            if send.send(frame).is_err() {
                break;
            }
        }
        drop(wait);
        Ok(())
    });
    (frames, ready, reading)
}

/// Counts of what a card has taken.
#[derive(Debug, Default)]
pub struct Counts {
    /// Frames of samples.
    pub played: AtomicU64,
    /// Frames of silence between samples.
    pub silent: AtomicU64,
    /// Buffers that came too late for the card.
    pub late: AtomicU64,
}

/// Fills the card's buffers.
#[derive(Debug)]
pub struct Player {
    frames: Receiver<Frame>,
    /// Channels of the device: at least those of the stream. The others get silence.
    channels: usize,
    stop: Arc<AtomicBool>,
    counts: Arc<Counts>,
    /// Frames of silence since the last sample.
    gap: u64,
    has_ended: bool,
    /// Frames of silence after which the last sample has left any card's buffers: half a second.
    tail: u64,
}

impl Player {
    /// Plays these frames until they end or `stop` is set.
    pub fn new(frames: Receiver<Frame>, config: &StreamConfig, stop: Arc<AtomicBool>) -> Self {
        Self {
            frames,
            channels: config.channels.into(),
            stop,
            counts: Arc::default(),
            gap: 0,
            has_ended: false,
            tail: u64::from(config.sample_rate / 2),
        }
    }

    /// The counts, which go on while it plays.
    pub fn counts(&self) -> Arc<Counts> {
        Arc::clone(&self.counts)
    }

    /// Returns true once nothing but silence is left in the card.
    pub fn is_over(&self) -> bool {
        self.has_ended && self.gap >= self.tail
    }

    /// Fills a buffer of whole frames, without waiting.
    pub fn fill<T: Sample + FromSample<i16>>(&mut self, out: &mut [T]) {
        self.has_ended |= self.stop.load(Ordering::Relaxed);
        for out in out.chunks_mut(self.channels) {
            let frame = match self.has_ended {
                true => Err(TryRecvError::Disconnected),
                false => self.frames.try_recv(),
            };
            self.has_ended = frame == Err(TryRecvError::Disconnected);
            self.gap += 1;
            if frame.is_ok() {
                if self.counts.played.fetch_add(1, Ordering::Relaxed) > 0 {
                    self.counts
                        .silent
                        .fetch_add(self.gap - 1, Ordering::Relaxed);
                }
                self.gap = 0;
            }
            let silence = [0; MOST as usize];
            let samples = frame.unwrap_or(silence).into_iter().chain(iter::repeat(0));
            for (out, sample) in out.iter_mut().zip(samples) {
                *out = T::from_sample(sample);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A player of two channels on a device of three.
    fn player() -> (mpsc::SyncSender<Frame>, Player, Arc<AtomicBool>) {
        let (send, frames) = mpsc::sync_channel(WAITING);
        let config = StreamConfig {
            channels: 3,
            sample_rate: 8,
            buffer_size: cpal::BufferSize::Default,
        };
        let stop = Arc::default();
        (send, Player::new(frames, &config, Arc::clone(&stop)), stop)
    }

    fn frame(left: i16, right: i16) -> Frame {
        let mut frame = [0; MOST as usize];
        frame[..2].copy_from_slice(&[left, right]);
        frame
    }

    #[test]
    fn a_stall_is_silence_and_no_sample_is_lost() {
        let (send, mut player, _) = player();
        let mut out = [9_i16; 6];
        player.fill(&mut out);
        assert_eq!(out, [0; 6], "before the first");
        send.send(frame(1, 2)).unwrap();
        player.fill(&mut out);
        assert_eq!(out, [1, 2, 0, 0, 0, 0]);
        send.send(frame(3, -4)).unwrap();
        drop(send);
        player.fill(&mut out);
        assert_eq!(out, [3, -4, 0, 0, 0, 0]);
        let counts = player.counts();
        assert_eq!(counts.played.load(Ordering::Relaxed), 2);
        assert_eq!(counts.silent.load(Ordering::Relaxed), 1);
        assert!(!player.is_over());
        player.fill(&mut [0_i16; 9]);
        assert!(player.is_over());
    }

    #[test]
    fn a_stop_is_silent_with_the_next_buffer() {
        let (send, mut player, stop) = player();
        send.send(frame(1, 2)).unwrap();
        stop.store(true, Ordering::Relaxed);
        let mut out = [9_i16; 12];
        player.fill(&mut out);
        assert_eq!(out, [0; 12]);
        assert!(player.is_over());
    }

    #[test]
    fn samples_keep_their_share_of_full_scale_in_other_formats() {
        let (send, mut player, _) = player();
        send.send(frame(i16::MIN, 16384)).unwrap();
        send.send(frame(i16::MIN, 16384)).unwrap();
        let (mut float, mut wide) = ([0.0_f32; 3], [0_i32; 3]);
        player.fill(&mut float);
        player.fill(&mut wide);
        assert_eq!(float.map(f32::to_bits), [-1.0, 0.5, 0.0].map(f32::to_bits));
        assert_eq!(wide, [i32::MIN, 1 << 30, 0]);
    }
}
