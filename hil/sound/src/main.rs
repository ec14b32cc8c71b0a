//! The `palpate-sound` program: plays the WAV stream of `hil run --wav -` on a sound card.

mod player;

use std::io::{self, BufReader, IsTerminal as _, Write as _};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, SyncSender};
use std::time::Duration;

use clap::Parser;
use cpal::traits::{DeviceTrait as _, HostTrait as _, StreamTrait as _};
use cpal::{
    BufferSize, Device, DeviceId, ErrorKind, FromSample, SampleFormat, SizedSample, StreamConfig,
    SupportedBufferSize, SupportedStreamConfigRange,
};
use palpate_run::Failure;
use player::{Player, Stream};

/// Frames that the card is asked to take at a time: 10 ms at 48 kHz. It has two such buffers.
const PERIOD: u32 = 480;
/// Longest time that a card which is to be silent is waited for.
const PATIENCE: Duration = Duration::from_secs(2);
/// Formats of samples, the best first.
const FORMATS: [SampleFormat; 3] = [SampleFormat::I16, SampleFormat::I32, SampleFormat::F32];

/// Plays a WAV stream of 16 bits from standard input on a sound card, all channels: `hil run coils-circle --wav - |
/// palpate-sound`. The card is silent where there are no samples, and after the end or Ctrl-C.
#[derive(Debug, Parser)]
#[command(name = "palpate-sound", version)]
struct Arguments {
    /// Device, by a name of `--list`. Left out: the system's own.
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// Prints the names of the devices, and plays nothing.
    #[arg(long, conflicts_with = "device")]
    list: bool,
}

/// News of the card to the main thread.
enum News {
    Over,
    Failed(cpal::Error),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let said = match arguments.list {
        true => list(),
        false => play(arguments.device.as_deref()),
    };
    match said.and_then(|text| {
        let written = io::stdout().write_all(text.as_bytes());
        written.map_err(Failure::written("standard output"))
    }) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Standard error may be closed as well.
            let _ = writeln!(io::stderr(), "palpate-sound: {failure}");
            ExitCode::from(failure.status())
        }
    }
}

/// A line per device that may play: its name and its description.
fn list() -> Result<String, Failure> {
    let mut text = String::new();
    for device in devices()? {
        let (Ok(id), Ok(about)) = (device.id(), device.description()) else {
            continue;
        };
        text += &format!("{:<40} {}\n", id.id(), about.name());
    }
    match text.is_empty() {
        true => Err(no_device()),
        false => Ok(text),
    }
}

/// The devices that may play.
fn devices() -> Result<impl Iterator<Item = Device>, Failure> {
    let devices = cpal::default_host().output_devices();
    devices.map_err(|error| Failure::Device(format!("sound devices cannot be listed: {error}")))
}

fn no_device() -> Failure {
    Failure::Device("expected a sound device, found none: connect one".into())
}

/// The device of this name, or the system's own.
fn find(name: Option<&str>) -> Result<Device, Failure> {
    let host = cpal::default_host();
    let Some(name) = name else {
        return host.default_output_device().ok_or_else(no_device);
    };
    if let Some(device) = host.device_by_id(&DeviceId::new(host.id(), name)) {
        return Ok(device);
    }
    let is_named = |device: &Device| device.description().is_ok_and(|d| d.name() == name);
    devices()?.find(is_named).ok_or_else(|| {
        Failure::Device(format!(
            "--device {name}: expected a device of `palpate-sound --list`"
        ))
    })
}

/// How a device with these ranges plays a stream: at its rate, on as many channels or the next higher number.
fn configure(
    ranges: impl Iterator<Item = SupportedStreamConfigRange>,
    name: &str,
    stream: &Stream,
) -> Result<(StreamConfig, SampleFormat), Failure> {
    let refused = |expected: String, found: String| {
        Failure::Device(format!(
            "sound device `{name}`: expected {expected}, as the WAV has, found {found}; name another with --device"
        ))
    };
    let Stream {
        rate_hz, channels, ..
    } = *stream;
    let ranges: Vec<_> = ranges
        .filter(|range| FORMATS.contains(&range.sample_format()))
        .collect();
    let enough = || ranges.iter().filter(|range| range.channels() >= channels);
    let has_rate = |range: &&SupportedStreamConfigRange| {
        (range.min_sample_rate()..=range.max_sample_rate()).contains(&rate_hz)
    };
    let best = enough().filter(has_rate).min_by_key(|range| {
        let format = FORMATS.iter().position(|f| *f == range.sample_format());
        (range.channels(), format)
    });
    match (best, enough().next()) {
        (Some(best), _) => {
            let buffer_size = match best.buffer_size() {
                SupportedBufferSize::Range { min, max } => {
                    BufferSize::Fixed(PERIOD.max(*min).min(*max))
                }
                SupportedBufferSize::Unknown => BufferSize::Default,
            };
            let config = StreamConfig {
                channels: best.channels(),
                sample_rate: rate_hz,
                buffer_size,
            };
            Ok((config, best.sample_format()))
        }
        (None, Some(other)) => Err(refused(
            format!("{rate_hz} Hz"),
            format!(
                "{} to {} Hz",
                other.min_sample_rate(),
                other.max_sample_rate()
            ),
        )),
        (None, None) => {
            let most = ranges
                .iter()
                .map(SupportedStreamConfigRange::channels)
                .max();
            let found = format!("{} at most", most.unwrap_or(0));
            Err(refused(format!("{channels} channels"), found))
        }
    }
}

/// Plays standard input, and returns what there is to say of it.
fn play(name: Option<&str>) -> Result<String, Failure> {
    if io::stdin().is_terminal() {
        return Err(Failure::Input(
            "expected a WAV stream on standard input: hil run coils-circle --wav - | palpate-sound"
                .into(),
        ));
    }
    let device = find(name)?;
    let name = device.id().map_or_else(
        |_| name.unwrap_or_default().to_owned(),
        |id| id.id().to_owned(),
    );
    let stop = Arc::new(AtomicBool::new(false));
    let (stream, samples) = Stream::open(BufReader::new(io::stdin()))?;
    let ranges = device.supported_output_configs().map_err(|error| {
        Failure::Device(format!(
            "sound device `{name}` cannot be opened: {error}; `palpate-sound --list` names the devices"
        ))
    })?;
    let (config, format) = configure(ranges, &name, &stream)?;
    for signal in [
        signal_hook::consts::SIGINT,
        signal_hook::consts::SIGTERM,
        signal_hook::consts::SIGHUP,
    ] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| Failure::Device(format!("signals cannot be caught: {error}")))?;
    }
    let (frames, ready, fed) = player::feed(samples, stream.channels);
    let player = Player::new(frames, &config, Arc::clone(&stop));
    let counts = player.counts();
    let (tell, news) = mpsc::sync_channel(1);
    let playing = match format {
        SampleFormat::I32 => begin::<i32>(&device, config, player, tell),
        SampleFormat::F32 => begin::<f32>(&device, config, player, tell),
        _ => begin::<i16>(&device, config, player, tell),
    };
    let failed = |error: cpal::Error| Failure::Device(format!("sound device `{name}`: {error}"));
    let playing = playing.map_err(failed)?;
    while ready.recv_timeout(Duration::from_millis(50)) == Err(RecvTimeoutError::Timeout)
        && !stop.load(Ordering::Relaxed)
    {}
    playing.play().map_err(failed)?;
    let mut waited = Duration::ZERO;
    let moment = Duration::from_millis(50);
    loop {
        match news.recv_timeout(moment) {
            Ok(News::Over) => break,
            Ok(News::Failed(error)) => return Err(failed(error)),
            Err(RecvTimeoutError::Timeout) if waited < PATIENCE => {
                waited += match stop.load(Ordering::Relaxed) {
                    true => moment,
                    false => Duration::ZERO,
                };
            }
            Err(_) => {
                let text = format!("sound device `{name}`: it takes no samples: switch it off");
                return Err(Failure::Device(text));
            }
        }
    }
    drop(playing);
    let s = |frames: u64| frames as f64 / f64::from(stream.rate_hz);
    let played = s(counts.played.load(Ordering::Relaxed));
    let text = format!(
        "played {played:.2} s on `{name}`, {} channels; silent for {:.2} s in between, {} buffers late\n",
        stream.channels,
        s(counts.silent.load(Ordering::Relaxed)),
        counts.late.load(Ordering::Relaxed),
    );
    if stop.load(Ordering::Relaxed) {
        return Err(Failure::Stopped(format!("stopped: {}", text.trim_end())));
    }
    match fed.join() {
        Ok(Err(error)) => Err(Failure::Input(format!(
            "standard input: expected {:.2} s of samples, found {played:.2} s, which were played: {error}",
            s(stream.frames),
        ))),
        _ => Ok(text),
    }
}

/// Opens the device and gives it the player.
fn begin<T: SizedSample + FromSample<i16>>(
    device: &Device,
    config: StreamConfig,
    mut player: Player,
    tell: SyncSender<News>,
) -> Result<cpal::Stream, cpal::Error> {
    let (over, counts) = (tell.clone(), player.counts());
    device.build_output_stream(
        config,
        move |out: &mut [T], _| {
            player.fill(out);
            if player.is_over() {
                // It is said again with the next buffer.
                let _ = over.try_send(News::Over);
            }
        },
        move |error| match error.kind() {
            // Late samples are played late; the card was silent meanwhile.
            ErrorKind::Xrun => {
                counts.late.fetch_add(1, Ordering::Relaxed);
            }
            ErrorKind::RealtimeDenied => {}
            _ => {
                let _ = tell.try_send(News::Failed(error));
            }
        },
        None,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(channels: u16, hz: [u32; 2], format: SampleFormat) -> SupportedStreamConfigRange {
        let buffers = SupportedBufferSize::Range { min: 16, max: 256 };
        SupportedStreamConfigRange::new(channels, hz[0], hz[1], buffers, format)
    }

    #[test]
    fn a_device_plays_as_many_channels_or_the_next_higher_number() {
        let eight = Stream {
            rate_hz: 48_000,
            channels: 8,
            frames: 1,
        };
        let all = [8_000, 96_000];
        let ranges = [
            range(2, all, SampleFormat::I16),
            range(16, all, SampleFormat::I16),
            range(10, all, SampleFormat::F32),
            range(10, all, SampleFormat::I32),
            range(8, [44_100; 2], SampleFormat::I16),
            range(8, all, SampleFormat::U8),
        ];
        let (config, format) = configure(ranges.into_iter(), "card", &eight).unwrap();
        assert_eq!((config.channels, format), (10, SampleFormat::I32));
        assert_eq!(config.sample_rate, 48_000);
        assert_eq!(config.buffer_size, BufferSize::Fixed(256));
        for (ranges, words) in [
            (
                &ranges[..1],
                "expected 8 channels, as the WAV has, found 2 at most",
            ),
            (
                &ranges[4..],
                "expected 48000 Hz, as the WAV has, found 44100 to 44100 Hz",
            ),
            (&ranges[..0], "found 0 at most"),
        ] {
            let refused = configure(ranges.iter().copied(), "card", &eight).unwrap_err();
            assert!(refused.to_string().contains(words), "{refused}");
            assert_eq!(refused.status(), 3);
        }
    }
}
