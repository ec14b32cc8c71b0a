//! The program on devices that ALSA makes of a pipe: what a card would play can be read there, at a pace of the test's own.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use palpate_records::wav::write_wav;

const CHANNELS: usize = 8;
const RATE_HZ: u32 = 48_000;

/// A folder with a configuration of ALSA's own: `default` writes into a FIFO what it plays, `two` has two channels.
struct Card(PathBuf);

impl Card {
    fn new(name: &str) -> Self {
        let folder = format!("palpate-sound-{}-{name}", std::process::id());
        let folder = std::env::temp_dir().join(folder);
        fs::create_dir_all(&folder).unwrap();
        let fifo = folder.join("played");
        let made = Command::new("mkfifo").arg(&fifo).status().unwrap();
        assert!(made.success());
        let settings = format!(
            r#"
pcm.null {{ type null }}
pcm.default {{ type file slave.pcm "null" file "{}" format "raw" hint {{ show on description "a pipe" }} }}
pcm.two {{
  type multi
  slaves.a {{ pcm "null" channels 2 }}
  bindings.0 {{ slave a channel 0 }}
  bindings.1 {{ slave a channel 1 }}
  hint {{ show on description "two channels" }}
}}
"#,
            fifo.display()
        );
        fs::write(folder.join("asound.conf"), settings).unwrap();
        Self(folder)
    }

    fn start(&self, arguments: &[&str]) -> Child {
        Command::new(env!("CARGO_BIN_EXE_palpate-sound"))
            .args(arguments)
            .env("ALSA_CONFIG_PATH", self.0.join("asound.conf"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    /// Runs the program on this input.
    fn said(&self, arguments: &[&str], input: &[u8]) -> Output {
        let mut child = self.start(arguments);
        // It may refuse before it reads.
        let _ = child.stdin.take().unwrap().write_all(input);
        child.wait_with_output().unwrap()
    }

    /// Takes what the card plays, at twice the pace of a card, until the program closes it.
    #[allow(clippy::disallowed_methods)] // a card's pace is time itself
    fn plays(&self) -> JoinHandle<Vec<i16>> {
        let fifo = self.0.join("played");
        thread::spawn(move || {
            let mut fifo = File::open(fifo).unwrap();
            let (mut played, mut block) = (Vec::new(), vec![0; 480 * 2 * CHANNELS]);
            loop {
                match fifo.read(&mut block).unwrap() {
                    0 => break,
                    n => played.extend_from_slice(&block[..n]),
                }
                thread::sleep(Duration::from_millis(5));
            }
            let samples = played.chunks_exact(2);
            samples.map(|b| i16::from_le_bytes([b[0], b[1]])).collect()
        })
    }
}

impl Drop for Card {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Samples of half a second, none of them zero, and the WAV stream of them.
fn stream(channels: usize) -> (Vec<i16>, Vec<u8>) {
    let count = RATE_HZ as usize / 2 * channels;
    let samples: Vec<i16> = (0..count).map(|i| (i * 7919 % 32_749) as i16 + 1).collect();
    let mut wav = Vec::new();
    write_wav(RATE_HZ, channels, &samples, &mut wav).unwrap();
    (samples, wav)
}

/// The runs of whole silent frames (`true`) and of others, with their lengths in samples.
fn runs(played: &[i16]) -> Vec<(bool, usize)> {
    let mut runs: Vec<(bool, usize)> = Vec::new();
    for frame in played.chunks(CHANNELS) {
        let silent = frame.iter().all(|s| *s == 0);
        match runs.last_mut() {
            Some((was, n)) if *was == silent => *n += frame.len(),
            _ => runs.push((silent, frame.len())),
        }
    }
    runs
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_stream_is_played_sample_by_sample_and_silence_follows() {
    let card = Card::new("whole");
    let (samples, wav) = stream(CHANNELS);
    let playing = card.plays();
    let said = card.said(&[], &wav);
    assert_eq!(said.status.code(), Some(0), "{}", text(&said.stderr));
    let words = text(&said.stdout);
    assert!(
        words.starts_with("played 0.50 s on `default`, 8 channels; silent for 0.00 s"),
        "{words}"
    );
    let played = playing.join().unwrap();
    let sound: Vec<i16> = played.iter().copied().filter(|s| *s != 0).collect();
    assert!(sound == samples, "{:?}", runs(&played));
    let runs = runs(&played);
    let (silent, tail) = runs[runs.len() - 1];
    assert!(silent && tail > CHANNELS * RATE_HZ as usize / 4, "{runs:?}");
    assert_eq!(
        runs.iter().filter(|(silent, _)| !silent).count(),
        1,
        "{runs:?}"
    );
}

#[test]
#[allow(clippy::disallowed_methods)] // a stall is time itself
fn a_stalled_pipe_is_silence_and_the_rest_is_played_after_it() {
    let card = Card::new("stall");
    let (samples, wav) = stream(CHANNELS);
    let playing = card.plays();
    let mut child = card.start(&[]);
    let mut pipe = child.stdin.take().unwrap();
    let (first, rest) = wav.split_at(wav.len() / 2 + 5); // within a sample
    pipe.write_all(first).unwrap();
    thread::sleep(Duration::from_millis(1500));
    pipe.write_all(rest).unwrap();
    drop(pipe);
    let said = child.wait_with_output().unwrap();
    assert_eq!(said.status.code(), Some(0), "{}", text(&said.stderr));
    let played = playing.join().unwrap();
    let sound: Vec<i16> = played.iter().copied().filter(|s| *s != 0).collect();
    let runs = runs(&played);
    assert!(sound == samples, "{runs:?}");
    // Sound, silence of about what the pipe stalled, sound, silence.
    let stalled = runs.iter().rev().nth(2).unwrap();
    assert!(
        stalled.0 && stalled.1 > CHANNELS * RATE_HZ as usize / 2,
        "{runs:?}"
    );
}

#[test]
#[allow(clippy::disallowed_methods)] // a signal comes in the midst of it
fn an_interrupt_silences_the_card() {
    let card = Card::new("interrupt");
    let (_, wav) = stream(CHANNELS);
    let playing = card.plays();
    let mut child = card.start(&[]);
    let mut pipe = child.stdin.take().unwrap();
    pipe.write_all(&wav[..wav.len() - 16]).unwrap(); // the last frame never comes
    thread::sleep(Duration::from_millis(100));
    let interrupt = ["-INT", &child.id().to_string()];
    assert!(
        Command::new("kill")
            .args(interrupt)
            .status()
            .unwrap()
            .success()
    );
    let said = child.wait_with_output().unwrap();
    assert_eq!(said.status.code(), Some(130), "{}", text(&said.stderr));
    assert!(text(&said.stderr).contains("palpate-sound: stopped: played 0."));
    let runs = runs(&playing.join().unwrap());
    let (silent, tail) = runs[runs.len() - 1];
    assert!(silent && tail > CHANNELS * RATE_HZ as usize / 4, "{runs:?}");
}

#[test]
fn what_cannot_be_played_is_refused_in_a_sentence() {
    let card = Card::new("refused");
    let (_, wav) = stream(CHANNELS);
    let wide = [&wav[..34], &24_u16.to_le_bytes(), &wav[36..]].concat();
    for (arguments, input, status, words) in [
        (
            &["--device", "none"][..],
            &wav[..],
            3,
            "expected a device of `palpate-sound --list`",
        ),
        (
            &["--device", "two"],
            &wav,
            3,
            "`two`: expected 8 channels, as the WAV has, found 2 at most",
        ),
        (
            &[],
            b"",
            2,
            "expected a WAV stream, as of `hil run --wav -`",
        ),
        (
            &[],
            b"[display]\n",
            2,
            "expected a WAV stream, as of `hil run --wav -`",
        ),
        (&[], &wide, 2, "standard input: expected"),
    ] {
        let said = card.said(arguments, input);
        let error = text(&said.stderr);
        assert_eq!(said.status.code(), Some(status), "{arguments:?}: {error}");
        assert!(error.contains(words), "{arguments:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    }
    let listed = text(&card.said(&["--list"], b"").stdout);
    assert!(
        listed.contains("two channels") && listed.contains("a pipe"),
        "{listed}"
    );
}

#[test]
fn a_pipe_that_closes_early_is_said_after_what_came_was_played() {
    let card = Card::new("closed");
    let (samples, wav) = stream(CHANNELS);
    let playing = card.plays();
    let said = card.said(&[], &wav[..wav.len() / 2]);
    let error = text(&said.stderr);
    assert_eq!(said.status.code(), Some(2), "{error}");
    let words = "standard input: expected 0.50 s of samples, found 0.25 s, which were played";
    assert!(error.contains(words), "{error}");
    let played = playing.join().unwrap();
    let sound: Vec<i16> = played.iter().copied().filter(|s| *s != 0).collect();
    // Half the stream has the whole head, and whole frames are played.
    let head = wav.len() - 2 * samples.len();
    let frames = (wav.len() / 2 - head) / (2 * CHANNELS);
    assert!(sound == samples[..frames * CHANNELS]);
}

/// The real stream of a run.
#[test]
fn a_run_of_voice_coils_is_played_as_its_file() {
    let Some(file) = std::env::var_os("PALPATE_SOUND_WAV") else {
        println!("skipped: PALPATE_SOUND_WAV names no WAV of a run; ci/sound makes one");
        return;
    };
    let card = Card::new("run");
    let wav = fs::read(Path::new(&file)).unwrap();
    let playing = card.plays();
    let said = card.said(&["--device", "default"], &wav);
    assert_eq!(said.status.code(), Some(0), "{}", text(&said.stderr));
    let played = playing.join().unwrap();
    let data = wav.windows(4).position(|w| w == b"data").unwrap() + 8;
    let samples: Vec<i16> = wav[data..]
        .chunks_exact(2)
        .map(|b| i16::from_le_bytes([b[0], b[1]]))
        .collect();
    let first = |samples: &[i16]| samples.iter().position(|s| *s != 0).unwrap();
    let (from, start) = (first(&played), first(&samples));
    let sound = &samples[start..];
    assert!(played[from..].starts_with(sound));
    assert!(played[from + sound.len()..].iter().all(|s| *s == 0));
    assert!(sound.len() > samples.len() / 2);
}
