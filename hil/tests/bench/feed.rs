//! A skin that is touched, on the CAN sockets of a bench: what the emulated boards send, over and over.

use std::fs;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// The touch has lasted for a while at this time: from here on it is played again.
const LOOP_FROM: Duration = Duration::from_millis(1000);
/// A skin that could not send for this long goes on from where it is.
const BEHIND: Duration = Duration::from_millis(50);

/// A frame as the kernel hands it over, and when.
type Sent = (Duration, [u8; 16]);

/// A scene: nothing for a moment, by which the skin is known at rest, then a sphere rests over one wire.
pub fn scene(length_s: f64) -> String {
    format!(
        "name = \"rest\"\ndescription = \"A sphere rests over one wire\"\ngeneration = \"2021\"\nthreshold = \"maximum\"\n\
         length_s = {length_s:?}\n[illusion]\nmodel = \"inverse\"\nrender = \"auto\"\n\
         [[touches]]\nstart_s = 0.55\npath = {{ kind = \"hold\", points_mm = [[0.0, -2.35]] }}\nforce_n = {{ mean = 0.7 }}\n"
    )
}

/// Frames of the emulated boards in two seconds of it.
fn touched() -> &'static [Sent] {
    static FRAMES: OnceLock<Vec<Sent>> = OnceLock::new();
    FRAMES.get_or_init(|| sent("touched", &scene(2.0)))
}

/// Frames of the emulated boards in two seconds without a touch.
fn at_rest() -> &'static [Sent] {
    static FRAMES: OnceLock<Vec<Sent>> = OnceLock::new();
    FRAMES.get_or_init(|| {
        let text = scene(2.0);
        let (rest, _) = text.split_once("[[touches]]").unwrap();
        sent("at-rest", rest)
    })
}

/// Frames of the emulated boards in a scene.
fn sent(name: &str, scene: &str) -> Vec<Sent> {
    let name = format!("hil-bench-feed-{}-{name}", std::process::id());
    let folder = std::env::temp_dir().join(name);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("scene.toml"), scene).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
    let command = command.current_dir(&folder);
    let words = ["run", "scene.toml", "--record", "skin.log", "--quiet"];
    let said = command.args(words).output().unwrap();
    let log = fs::read_to_string(folder.join("skin.log"));
    let log = log.unwrap_or_else(|e| panic!("no recording of a skin: {e}, {said:?}"));
    fs::remove_dir_all(&folder).unwrap();
    log.lines().map(frame).collect()
}

/// A line of a candump log: `(seconds.micros) interface ID#DATA`.
fn frame(line: &str) -> Sent {
    let words: Vec<&str> = line.split(' ').collect();
    let at: f64 = words[0].trim_matches(['(', ')']).parse().unwrap();
    let (id, data) = words[2].split_once('#').unwrap();
    let mut bytes = [0; 16];
    bytes[..4].copy_from_slice(&u32::from_str_radix(id, 16).unwrap().to_ne_bytes());
    bytes[4] = (data.len() / 2) as u8;
    for (n, byte) in bytes[8..].iter_mut().take(data.len() / 2).enumerate() {
        *byte = u8::from_str_radix(&data[2 * n..2 * n + 2], 16).unwrap();
    }
    (Duration::from_secs_f64(at), bytes)
}

/// A touched skin, until it is dropped.
pub struct Feed {
    over: Arc<AtomicBool>,
    /// Nothing is sent meanwhile.
    pub paused: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Feed {
    /// From the moment at which somebody listens at `place`, on a board of this number.
    pub fn start(place: PathBuf, board: u8) -> Self {
        Self::new(touched(), place, board)
    }

    /// A skin that nothing touches, from the same moment.
    pub fn at_rest(place: PathBuf, board: u8) -> Self {
        Self::new(at_rest(), place, board)
    }

    fn new(frames: &'static [Sent], place: PathBuf, board: u8) -> Self {
        let (over, paused) = (Arc::default(), Arc::default());
        let (ended, waits): (Arc<AtomicBool>, Arc<AtomicBool>) =
            (Arc::clone(&over), Arc::clone(&paused));
        let thread = thread::spawn(move || {
            while !place.exists() && !ended.load(Ordering::Relaxed) {
                thread::sleep(Duration::from_millis(1));
            }
            play((frames, board), &place, &ended, &waits);
        });
        Self {
            over,
            paused,
            thread: Some(thread),
        }
    }
}

fn play((frames, board): (&[Sent], u8), place: &Path, over: &AtomicBool, paused: &AtomicBool) {
    let socket = UnixDatagram::unbound().unwrap();
    // Who is stopped reads nothing.
    socket
        .set_write_timeout(Some(Duration::from_millis(5)))
        .unwrap();
    let start = frames.partition_point(|(at, _)| *at < LOOP_FROM);
    let mut begun = Instant::now();
    let mut number = 0;
    while !over.load(Ordering::Relaxed) {
        let (at, bytes) = &frames[number];
        let now = Instant::now();
        let due = begun + *at;
        if due > now {
            thread::sleep(due - now);
        } else if now - due > BEHIND {
            begun += now - due;
        }
        if !paused.load(Ordering::Relaxed) {
            let mut bytes = *bytes;
            // An identifier ends in its board's number.
            bytes[0] = bytes[0] & 0xF0 | board;
            // Nobody may be there any more.
            let _ = socket.send_to(&bytes, place);
        }
        number += 1;
        if number == frames.len() {
            begun += *at - frames[start].0 + Duration::from_millis(10);
            number = start;
        }
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        let _ = self.thread.take().unwrap().join();
    }
}
