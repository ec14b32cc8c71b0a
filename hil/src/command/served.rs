//! A run before pages: it waits for the first one, begins anew where that is wanted, and its page stays until a signal comes.

use std::net::SocketAddr;
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use std::thread;

use palpate_buses::served::wait::{monotonic_ns, wait};
use palpate_buses::signals::Signals;
use palpate_live::output::note;
use palpate_live::serve::{Foxglove, Live};
use palpate_run::{Failure, Outcome};

/// Time between two looks for a page or a signal, nanoseconds.
const GLANCE_NS: u64 = 20_000_000;

/// The pages of a run, and the signals that end it.
pub(super) struct Served {
    /// The pages.
    pub live: Live,
    signals: Signals,
}

impl Served {
    /// Listens, says where, and waits for the first page. `paced` says whether the wall clock holds the run.
    ///
    /// # Errors
    /// [`Failure::Device`] for an address that cannot be listened at, [`Failure::Stopped`] where a signal comes before a page.
    pub fn open(at: SocketAddr, opens: bool, paced: bool) -> Result<Self, Failure> {
        openable(at, opens)?;
        let signals = catch()?;
        let live = Live::open(at)?;
        note(&format!(
            "live view: {}; the run begins when a page opens there{}",
            live.url,
            pace(paced)
        ));
        if opens {
            browse(&live.url);
        }
        expect(&signals, "a page opened", || live.is_seen())?;
        Ok(Self { live, signals })
    }

    /// The pages are told how the run ended, and what it measured of its limits.
    pub fn over(&self, played: &Result<Outcome, Failure>) {
        match played {
            Ok(outcome) => {
                let summary = &outcome.summary;
                self.live.over(&summary.conclusion.line(), &summary.margins);
            }
            Err(failure) => self.live.over(&failure.to_string(), &[]),
        }
    }

    /// Keeps the pages of a run that is over until a signal comes.
    pub fn stay(&self) {
        if self.signals.caught().is_none() {
            note(&format!("the page stays at {} until Ctrl-C", self.live.url));
        }
        while self.signals.caught().is_none() {
            glance();
        }
    }
}

/// Listens for Foxglove, says where, and waits for the first client. `paced` says whether the wall clock holds the run.
///
/// # Errors
/// The errors of [`Served::open`].
pub(super) fn foxglove(port: u16, paced: bool) -> Result<Foxglove, Failure> {
    let signals = catch()?;
    let foxglove = Foxglove::open(port)?;
    note(&format!(
        "--foxglove: {}; the run begins when Foxglove connects there{}",
        foxglove.url,
        pace(paced)
    ));
    expect(&signals, "Foxglove connected", || foxglove.is_seen())?;
    Ok(foxglove)
}

fn catch() -> Result<Signals, Failure> {
    Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))
}

const fn pace(paced: bool) -> &'static str {
    match paced {
        true => ", and keeps to the wall clock",
        false => "",
    }
}

/// Waits until somebody looks.
///
/// # Errors
/// [`Failure::Stopped`] where a signal comes before.
fn expect(signals: &Signals, event: &str, is_seen: impl Fn() -> bool) -> Result<(), Failure> {
    while !is_seen() {
        if let Some(name) = signals.caught() {
            return Err(Failure::Stopped(format!(
                "stopped by {name} before {event}: nothing ran"
            )));
        }
        glance();
    }
    Ok(())
}

/// Sleeps for a moment; a signal ends it early. A clock that fails is no reason to stop looking.
fn glance() {
    let _ = wait(&[], monotonic_ns() + GLANCE_NS);
}

/// Refuses to open an address whose token would stand in the browser's command line, where other users can read it.
///
/// # Errors
/// [`Failure::Input`] for an address that other computers reach.
pub(super) fn openable(at: SocketAddr, opens: bool) -> Result<(), Failure> {
    match opens && !at.ip().is_loopback() {
        true => Err(Failure::Input(format!(
            "--open: expected an address of this computer alone, found {at}, whose token other users could read; open what is \
             printed"
        ))),
        false => Ok(()),
    }
}

/// Opens an address in the browser that the desktop names. Without one a note says so.
pub(super) fn browse(url: &str) {
    let mut browser = Command::new("xdg-open");
    browser.arg(url).stdin(Stdio::null());
    browser.stdout(Stdio::null()).stderr(Stdio::null());
    // Ctrl-C is for this program alone.
    browser.process_group(0);
    let url = url.to_owned();
    let failed = move |why: &str| note(&format!("--open: xdg-open {why}; open {url} in a browser"));
    match browser.spawn() {
        Ok(mut child) => {
            thread::spawn(move || match child.wait() {
                Ok(status) if status.success() => {}
                Ok(_) => failed("found no browser"),
                Err(error) => failed(&error.to_string()),
            });
        }
        Err(error) => failed(&format!("cannot be started ({error})")),
    }
}
