//! Survey of a machine for a real bench: its means, its lacks, and the commands that mend them. Changes nothing: looks,
//! opens and measures.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use nix::errno::Errno;
use palpate_core::units::{Duration, Instant};
use serde::Serialize;
use socketcan::{CanSocket, Socket};

use crate::can::{CanState, Controller, is_up};
use crate::guardian::{Latch, Sweeper, Watch, WatchedBus, haptics, stops_folder};
use crate::hardware::Hardware;
use crate::i2c::{Line, LinuxAdapter, number};
use crate::lock::BusLock;
use crate::pacer::{Pacer, RunClock};
use crate::sys::{lock_memory_limit, set_fifo_priority};

/// Longest time that an adapter takes to read its boards.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(1);

/// Finding on one thing of the machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Subject of the finding, in a word or two.
    pub about: &'static str,
    /// `true` where the machine is as a real bench wants it.
    pub ok: bool,
    /// `true` where a real bench cannot do without.
    #[serde(skip)]
    pub needed: bool,
    /// Words of the finding.
    pub says: String,
    /// Command that mends it, where something is to be done.
    pub remedy: Option<String>,
}

impl Finding {
    fn good(about: &'static str, says: String) -> Self {
        Self {
            about,
            ok: true,
            needed: true,
            says,
            remedy: None,
        }
    }

    fn bad(about: &'static str, says: String, remedy: String) -> Self {
        Self {
            about,
            ok: false,
            needed: true,
            says,
            remedy: Some(remedy),
        }
    }

    fn optional(mut self) -> Self {
        self.needed = false;
        self
    }
}

/// Looks at everything; with a bench, at its interfaces and adapters only.
pub fn survey(can: Option<&[String]>, watch: Option<&Watch>) -> Vec<Finding> {
    let mut findings = look_at_can(can);
    findings.extend(look_at_i2c(watch));
    findings.push(look_at_stops());
    findings.push(look_at_oe(watch));
    findings.push(look_at_clock());
    findings.extend(look_at_real_time());
    findings
}

/// The entries of a folder whose names begin so, in order of their numbers.
fn nodes(folder: &str, prefix: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let named = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default();
        name.to_string_lossy().starts_with(prefix)
    };
    let mut found: Vec<PathBuf> = entries.map(|e| e.path()).filter(named).collect();
    found.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
    found
}

fn look_at_can(wanted: Option<&[String]>) -> Vec<Finding> {
    const ABOUT: &str = "CAN";
    let probe = CanSocket::open("no-such-can").err();
    let errno = probe
        .as_ref()
        .and_then(io::Error::raw_os_error)
        .map(Errno::from_raw);
    if matches!(errno, Some(Errno::EAFNOSUPPORT | Errno::EPROTONOSUPPORT)) {
        let says = "this kernel has no CAN sockets".into();
        return vec![Finding::bad(ABOUT, says, "modprobe can_raw".into())];
    }
    let is_can = |path: &PathBuf| {
        let kind = fs::read_to_string(path.join("type"));
        kind.is_ok_and(|kind| kind.trim() == "280") // ARPHRD_CAN
    };
    let name = |path: &PathBuf| path.file_name().map(|n| n.to_string_lossy().into_owned());
    let all = nodes("/sys/class/net", "");
    let there: Vec<String> = all.iter().filter(|p| is_can(p)).filter_map(name).collect();
    let names = wanted.map_or(there.clone(), <[String]>::to_vec);
    if names.is_empty() {
        return vec![Finding::bad(
            ABOUT,
            "no CAN interface".into(),
            "plug an adapter in, or: modprobe vcan; ip link add vcan0 type vcan; ip link set vcan0 up".into(),
        )];
    }
    let look = |name: &String| {
        if !there.contains(name) {
            let says = format!("{name}: no such CAN interface");
            let list = if there.is_empty() {
                "none".into()
            } else {
                there.join(", ")
            };
            return Finding::bad(ABOUT, says, format!("there are: {list}"));
        }
        let Controller {
            bitrate,
            state,
            restart_ms,
        } = Controller::ask(name).unwrap_or_default();
        if !is_up(name) {
            let kind = if bitrate.is_some() {
                " type can bitrate 1000000 restart-ms 100"
            } else {
                ""
            };
            return Finding::bad(
                ABOUT,
                format!("{name}: down"),
                format!("ip link set {name} up{kind}"),
            );
        }
        if state == Some(CanState::BusOff) {
            return Finding::bad(
                ABOUT,
                format!("{name}: up, bus-off: short circuit, wrong bit rate or bad wiring"),
                format!("ip link set {name} down; ip link set {name} up"),
            );
        }
        let Some(bitrate) = bitrate.filter(|rate| *rate > 0) else {
            let kind = match state {
                Some(_) => "on a serial line whose bit rate the kernel does not know",
                None => "virtual",
            };
            return Finding::good(ABOUT, format!("{name}: up, {kind}"));
        };
        let restart = restart_ms.unwrap_or(0);
        let says = format!(
            "{name}: up, {bitrate} bit/s, {}, restart-ms {restart}",
            state.map_or("state unknown".into(), |s| format!("{s:?}"))
        );
        if bitrate != 1_000_000 {
            let remedy = format!(
                "ip link set {name} down; ip link set {name} up type can bitrate 1000000 restart-ms 100"
            );
            return Finding::bad(ABOUT, format!("{says}; the boards send at 1000000"), remedy);
        }
        if restart == 0 {
            let remedy = format!(
                "after bus-off it stays off: ip link set {name} down; ip link set {name} up type can restart-ms 100"
            );
            return Finding::bad(ABOUT, says, remedy).optional();
        }
        Finding::good(ABOUT, says)
    };
    names.iter().map(look).collect()
}

fn look_at_i2c(watch: Option<&Watch>) -> Vec<Finding> {
    const ABOUT: &str = "I2C";
    let listed = |path| WatchedBus {
        path,
        boards: Vec::new(),
        converters: Vec::new(),
        motors: Vec::new(),
    };
    let listed = || nodes("/dev", "i2c-").into_iter().map(listed).collect();
    let buses: Vec<WatchedBus> = watch.map_or_else(listed, |watch| watch.buses.clone());
    if buses.is_empty() {
        return vec![Finding::bad(
            ABOUT,
            "no /dev/i2c-* here".into(),
            "modprobe i2c-dev; on a Raspberry Pi also dtparam=i2c_arm=on; or plug a USB adapter in"
                .into(),
        )];
    }
    let mut findings = Vec::new();
    for bus in buses {
        let path = bus.path.clone();
        let named = |n: u32| fs::read_to_string(format!("/sys/class/i2c-dev/i2c-{n}/name")).ok();
        let adapter = number(&path).and_then(named).unwrap_or_default();
        let shown = format!("{} ({})", path.display(), adapter.trim());
        match LinuxAdapter::open(&path, &bus.addresses()) {
            Ok(_) => findings.push(Finding::good(
                ABOUT,
                format!("{shown}: opens, whole transfers"),
            )),
            Err(error) => {
                // Error texts end with the way out.
                let (says, remedy) = error.reason.split_once("; ").unwrap_or((&error.reason, ""));
                findings.push(Finding::bad(
                    ABOUT,
                    format!("{shown}: {says}"),
                    remedy.into(),
                ));
                continue;
            }
        }
        let off = match bus.motors.is_empty() {
            true => format!("hil off --unlatch --i2c {}", path.display()),
            false => "hil off --unlatch --bench FILE".to_owned(),
        };
        if let Some(watch) = watch.filter(|_| !bus.motors.is_empty()) {
            findings.extend(look_at_motors(&bus, watch));
        } else if let Some(watch) = watch.filter(|_| !bus.boards.is_empty()) {
            findings.extend(look_at_boards(bus, watch));
        }
        findings.extend(look_at_latch(&path, &off));
    }
    findings
}

fn look_at_boards(bus: WatchedBus, watch: &Watch) -> Vec<Finding> {
    const ABOUT: &str = "board";
    let Ok(mut sweeper) = Sweeper::open(&[bus]) else {
        return Vec::new(); // its adapter has been reported
    };
    let boards = sweeper
        .look(PATIENCE.max(watch.transfer))
        .into_iter()
        .map(|board| {
            let says = board.to_string();
            if board.seen.is_err() {
                Finding::bad(ABOUT, says, "i2cdetect -y shows who answers".into())
            } else if board.was_driving() {
                Finding::bad(ABOUT, says, "unless a run is on: hil off".into())
            } else {
                Finding::good(ABOUT, says)
            }
        });
    boards.collect()
}

/// Looks at every driver of motors behind its switch. That moves the switch, so a run on the bus forbids it.
fn look_at_motors(bus: &WatchedBus, watch: &Watch) -> Vec<Finding> {
    const ABOUT: &str = "motor";
    let hardware = Hardware::adapter(&bus.path).map_err(|error| error.to_string());
    let lock = hardware.and_then(|own| BusLock::take(&own).map_err(|error| error.to_string()));
    let opened = lock.and_then(|lock| {
        let adapter = LinuxAdapter::open(&bus.path, &bus.addresses());
        let adapter = adapter.map_err(|error| error.to_string())?;
        let line = Line::new(adapter, watch.transfer).map_err(|error| error.to_string())?;
        let haptics = haptics(line, &bus.motors).map_err(|error| error.to_string())?;
        Ok((lock, haptics))
    });
    let (_lock, mut haptics) = match opened {
        Ok(opened) => opened,
        Err(says) => {
            let remedy = "end the run that holds the bus, or: hil off --bench FILE".into();
            return vec![Finding::bad(ABOUT, says, remedy)];
        }
    };
    let look = |(number, behind): (u8, &Option<(u8, u8)>)| {
        let place = behind.map_or_else(
            || "alone on the bus".to_owned(),
            |(switch, channel)| format!("channel {channel} of the switch at {switch:#04x}"),
        );
        let about = format!("{number}, {place}");
        let seen = haptics.identify(number);
        match seen.and_then(|()| haptics.is_driving(number)) {
            Ok(false) => Finding::good(ABOUT, format!("{about}: a DRV2605L, at rest")),
            Ok(true) => {
                let says = format!("{about}: its driver drives it");
                Finding::bad(ABOUT, says, "hil off --bench FILE".into())
            }
            Err(fault) => {
                let fault = fault.to_string();
                let (says, remedy) = fault.split_once("; ").unwrap_or((&fault, ""));
                Finding::bad(ABOUT, format!("{about}: {says}"), remedy.into())
            }
        }
    };
    (0..).zip(&bus.motors).map(look).collect()
}

/// Looks at the stop of an adapter, which the command `off` clears.
fn look_at_latch(path: &Path, off: &str) -> Option<Finding> {
    let held = Latch::new(&Hardware::adapter(path).ok()?).look()?;
    let known = if held.verified {
        "everything was off"
    } else {
        "not everything was known to be off"
    };
    let says = format!(
        "{}: stopped earlier: {}; {known}",
        path.display(),
        held.cause
    );
    let remedy = format!("look at the bench, then: {off}");
    Some(Finding::bad("stop", says, remedy))
}

/// Looks at the folder of stops: without it nothing is driven.
fn look_at_stops() -> Finding {
    const ABOUT: &str = "stops";
    match stops_folder() {
        Ok(folder) => Finding::good(ABOUT, format!("kept in {}", folder.display())),
        Err((says, remedy)) => Finding::bad(ABOUT, says, remedy),
    }
}

fn look_at_oe(watch: Option<&Watch>) -> Finding {
    const ABOUT: &str = "OE line";
    let chips: Vec<String> = nodes("/dev", "gpiochip")
        .iter()
        .map(|p| p.display().to_string())
        .collect();
    match watch.map(|watch| &watch.oe) {
        Some(Some((chip, line))) if chip.exists() => {
            Finding::good(ABOUT, format!("{} line {line}", chip.display()))
        }
        Some(Some((chip, _))) => Finding::bad(
            ABOUT,
            format!("{}: no such GPIO chip", chip.display()),
            "gpiodetect lists what is there".into(),
        ),
        _ if chips.is_empty() => Finding::bad(
            ABOUT,
            "no GPIO chip".into(),
            "without an OE line outputs can only be cut over I2C".into(),
        )
        .optional(),
        _ => Finding::bad(
            ABOUT,
            format!("none named; {}", chips.join(", ")),
            "name it in the bench: real.oe = { chip = \"/dev/gpiochip0\", line = 17 }".into(),
        )
        .optional(),
    }
}

/// Measures the lateness of turns for a tenth of a second.
fn look_at_clock() -> Finding {
    let clock = RunClock::start();
    let mut pacer = Pacer::new(clock);
    let mut now = Instant::ZERO;
    for _ in 0..100 {
        now = pacer.wait(Pacer::next(now, Duration::from_millis(1)));
    }
    let late = pacer.lateness();
    let says = format!(
        "turns of 1 ms begin {} us late (median), {} us at most",
        late.quantile_us(0.5),
        late.worst_us()
    );
    if late.worst_us() < 5_000 {
        return Finding::good("clock", says);
    }
    let remedy =
        "a busy or virtual machine; give the loop real-time priority: real.realtime = true".into();
    Finding::bad("clock", says, remedy).optional()
}

fn look_at_real_time() -> Vec<Finding> {
    // On a thread of its own: the priority goes with it.
    let tried = std::thread::spawn(|| set_fifo_priority(50)).join();
    let allowed = matches!(tried, Ok(Ok(())));
    let remedy = "setcap cap_sys_nice,cap_ipc_lock=ep on the program, or an rtprio limit of 60 in /etc/security/limits.conf";
    let priority = if allowed {
        Finding::good("real time", "real-time priority is allowed".into())
    } else {
        Finding::bad(
            "real time",
            "real-time priority is not allowed".into(),
            remedy.into(),
        )
    };
    let kernel = fs::read_to_string("/sys/kernel/realtime").is_ok_and(|t| t.trim() == "1");
    let kernel = if kernel {
        "a real-time kernel (PREEMPT_RT)"
    } else {
        "an ordinary kernel"
    };
    let memory = match lock_memory_limit() {
        None => Finding::good(
            "memory",
            format!("all of it may be locked, and the guardian's is; {kernel}"),
        ),
        Some(bytes) => {
            let says = format!(
                "{} KiB may be locked: where that is too little the guardian's is touched beforehand, and may be paged out; {kernel}",
                bytes / 1024
            );
            Finding::bad("memory", says, "ulimit -l unlimited".into())
        }
    };
    vec![priority.optional(), memory.optional()]
}

#[cfg(test)]
#[path = "survey_tests.rs"]
mod tests;
