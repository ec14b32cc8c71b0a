//! Playback of a recording onto buses: every frame again, at its time.

use palpate_buses::pacer::{Lateness, RunClock};
use palpate_buses::served::can::Interface;
use palpate_core::units::{Duration, Instant};
use serde::Serialize;

use crate::progress::Progress;
use crate::recording::CanRecording;
use palpate_buses::signals::Signals;
use palpate_run::Failure;

/// Time between two looks for a signal.
const TURN: Duration = Duration::from_millis(50);

/// Counts of a playback.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Played {
    /// Frames that the interfaces took.
    pub sent: u64,
    /// Frames that the interfaces did not take: queue full, interface down.
    pub lost: u64,
    /// Frames that were left when a signal came.
    pub left: u64,
    /// Lateness that half of the frames did not exceed, microseconds.
    pub late_median_us: u64,
    /// Lateness of the latest frame, microseconds.
    pub late_worst_us: u64,
    /// Length, milliseconds.
    pub length_ms: u64,
}

/// Plays a recording, bus n onto the n-th interface, the first frame at once.
///
/// # Errors
/// [`Failure::Device`] for an interface that is not there or goes away.
pub fn play(recording: &CanRecording, interfaces: &[String]) -> Result<Played, Failure> {
    let gone = |name: &str, e: std::io::Error| Failure::Device(format!("{name}: {e}"));
    let open = |name: &String| Interface::open(name).map_err(|e| gone(name, e));
    let mut open: Vec<Interface> = interfaces.iter().map(open).collect::<Result<_, _>>()?;
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    let (clock, mut lateness) = (RunClock::start(), Lateness::default());
    let progress = Progress::of_part("replay");
    let end = recording.frames.end();
    let mut first = None;
    let (mut stopped, mut left) = (false, 0);
    for received in recording.frames.frames()? {
        let received = received?;
        if stopped {
            left += 1;
            continue;
        }
        let first = *first.get_or_insert(received.at);
        let due = Instant::ZERO + received.at.since(first);
        let mut now = clock.now();
        while now < due && signals.caught().is_none() {
            clock.sleep_until(due.min(now + TURN));
            now = clock.now();
        }
        if signals.caught().is_some() {
            (stopped, left) = (true, 1);
            continue;
        }
        lateness.note(due, now);
        if let Some(interface) = open.get_mut(usize::from(received.bus)) {
            let sent = interface.send(&received.frame);
            sent.map_err(|e| gone(interface.name(), e))?;
        }
        let (gone, whole) = (received.at.since(first), end.since(first));
        progress.part(gone.as_micros() as f64 / whole.as_micros().max(1) as f64);
    }
    Ok(Played {
        sent: open.iter().map(|i| i.counts().sent).sum(),
        lost: open.iter().map(|i| i.counts().lost).sum(),
        left,
        late_median_us: lateness.quantile_us(0.5),
        late_worst_us: lateness.worst_us(),
        length_ms: clock.now().as_micros() / 1000,
    })
}
