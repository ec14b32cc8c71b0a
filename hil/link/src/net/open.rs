//! Opens a session. Plain text stays on loopback; everything else is TLS, with certificates on both ends.

use std::net::{IpAddr, TcpListener, ToSocketAddrs};
use std::path::PathBuf;

use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_core::units::{Duration, Instant};
use palpate_live::output::note;
use palpate_run::Failure;
use serde_json::{Value, json};
use thiserror::Error;
use zenoh::{Config, Session, Wait};

use super::access::Access;
use super::certificates::Lab;
use super::words;

/// Address at which sessions of one machine meet.
const MEETING: &str = "127.0.0.1:7450";

/// Largest message, bytes: zenoh silently throws away the pieces of a larger one as they come; the link stays.
const MOST_BYTES: u32 = 1 << 20;

/// Time between two looks at the expiry of the own certificate.
const LOOK: Duration = Duration::from_millis(100);

/// Longest wait for others at the start; they may come later.
const FIRST: Duration = Duration::from_millis(1500);

/// Longest attempt to reach a relay, milliseconds; between two of them a signal is looked for.
const ATTEMPT_MS: i64 = 1000;

/// Zenoh's words when nothing answered, which may be otherwise a second later.
const UNREACHED: &str = "Unable to connect";

/// Role of a session in the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Speaks with those that it is connected to, or through a relay where [`At::relay`] names one.
    Peer,
    /// Introduces peers that connect to it to each other, and passes on messages of those that speak through it.
    Router,
}

impl Mode {
    /// Zenoh's word. Its routers pass nothing from one of their peers to another, but everything to and from clients.
    const fn word(self, through_relay: bool) -> &'static str {
        match self {
            _ if through_relay => "client",
            Self::Peer => "peer",
            Self::Router => "router",
        }
    }
}

/// Addresses to listen at and to connect to, and their protection.
#[derive(Clone, Debug, Default)]
pub struct At {
    /// Addresses to listen on, host:port.
    pub listen: Vec<String>,
    /// Addresses to connect to.
    pub connect: Vec<String>,
    /// The folder of certificates and access list; without it text is plain.
    pub keys: Option<PathBuf>,
    /// `true` where plain text may leave this machine.
    pub plain: bool,
    /// The relay that everything goes through; without it ends speak directly.
    pub relay: Option<String>,
}

impl At {
    /// Addresses for a second session of the same end: it connects where the first one does, and needs no port of its
    /// own.
    #[must_use]
    pub fn beside(&self) -> Self {
        Self {
            listen: Vec::new(),
            ..self.clone()
        }
    }

    /// Tells whether the end connects to another machine.
    #[must_use]
    pub fn leaves_machine(&self) -> bool {
        !connect_is_local(self.connect.iter().chain(&self.relay))
    }
}

/// Errors of a session that cannot be opened.
#[derive(Debug, Error)]
pub enum NetError {
    /// A text that is no address.
    #[error("{option} {address}: expected HOST:PORT, such as 192.168.1.5:7450 or [::1]:7450")]
    Address {
        /// Name of the option.
        option: &'static str,
        /// Value of the option.
        address: String,
    },
    /// Plain text would leave the machine.
    #[error(
        "{option} {address}: expected --keys DIR for an address that is not of this machine: readings and stimuli would cross the network in plain text. Make certificates with `palpate-link keys`, or say --plain"
    )]
    Plain {
        /// Name of the option.
        option: &'static str,
        /// Value of the option.
        address: String,
    },
    /// Error of certificates or the access list.
    #[error(transparent)]
    Lab(#[from] super::certificates::LabError),
    /// The relay never answered.
    #[error("--relay {0}: no relay answered before the end")]
    Silent(String),
    /// Error of zenoh.
    #[error("zenoh: {0}")]
    Zenoh(String),
}

impl From<NetError> for Failure {
    fn from(error: NetError) -> Self {
        match error {
            NetError::Zenoh(_) | NetError::Silent(_) => Self::Device(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

/// A session, and the member that it is.
#[derive(Debug)]
pub struct Net {
    /// The session.
    pub session: Session,
    /// The access list, where there is one.
    pub access: Option<Access>,
    /// The name in the own certificate.
    pub name: Option<String>,
}

/// Opens a session. A relay is tried until it answers or a signal comes.
///
/// # Errors
/// [`NetError`] for addresses, certificates, and refusals of zenoh.
pub fn open(at: &At, mode: Mode, signals: &Signals) -> Result<Net, NetError> {
    words::begin();
    let planned = Planned::new(at, mode)?;
    let config = planned.config;
    let session = match &at.relay {
        None => zenoh::open(config).wait().map_err(zenoh)?,
        Some(relay) => through(relay, &config, signals)?,
    };
    if planned.connects {
        await_others(&session);
    }
    let access = planned.lab.as_ref().map(|lab| lab.access.clone());
    let name = planned.lab.as_ref().map(|lab| lab.name.clone());
    if let Some(lab) = planned.lab {
        until_expiry(lab, session.clone(), true)?;
    }
    Ok(Net {
        session,
        access,
        name,
    })
}

/// Closes a session when the own certificate has expired, and notes that if it `tells`. Zenoh closes the links that it
/// has then, and makes new ones within the same second, since TLS counts whole ones; of those it never looks at the
/// certificate again.
fn until_expiry(lab: Lab, session: Session, tells: bool) -> Result<(), NetError> {
    let watch = move || {
        let clock = RunClock::start();
        while !lab.has_expired() {
            clock.sleep_until(clock.now() + LOOK);
        }
        if tells {
            let name = &lab.name;
            note(&format!(
                "the certificate of `{name}` has expired: make another with `palpate-link keys`"
            ));
        }
        // A session that is closed already needs no closing.
        let _ = session.close().wait();
    };
    let thread = std::thread::Builder::new().name("expiry".into());
    // The thread ends with the program.
    let started = thread.spawn(watch).map(drop);
    started.map_err(|e| NetError::Zenoh(format!("a thread: {e}")))
}

/// Opens a second session of an end that has one. It must not keep the first from its work: an error is told, and no
/// more.
pub fn open_beside(at: &At) -> Option<Session> {
    let opened = Planned::new(&at.beside(), Mode::Peer).and_then(|planned| {
        let session = zenoh::open(planned.config).wait().map_err(zenoh)?;
        if let Some(lab) = planned.lab {
            until_expiry(lab, session.clone(), false)?;
        }
        Ok(session)
    });
    opened
        .inspect_err(|e| {
            note(&format!(
                "no second connection, so a lost packet is a pause: {e}"
            ));
        })
        .ok()
}

/// A session that is to be opened.
struct Planned {
    config: Config,
    connects: bool,
    lab: Option<Lab>,
}

impl Planned {
    fn new(at: &At, mode: Mode) -> Result<Self, NetError> {
        let lab = at.keys.as_deref().map(Lab::member).transpose()?;
        let (listen, connect) = endpoints(at, lab.is_some())?;
        let mut settings = settings(mode.word(at.relay.is_some()), &listen, &connect);
        if let Some(lab) = &lab {
            settings["transport"]["link"]["tls"] = lab.settings();
            settings["access_control"] = lab.access.settings();
        }
        Ok(Self {
            config: Config::from_json5(&settings.to_string()).map_err(zenoh)?,
            connects: !connect.is_empty(),
            lab,
        })
    }
}

/// An error of zenoh as one of the network.
pub(crate) fn zenoh(error: zenoh::Error) -> NetError {
    NetError::Zenoh(error.to_string())
}

/// Opens a session through a relay, as soon as that answers.
fn through(relay: &str, config: &Config, signals: &Signals) -> Result<Session, NetError> {
    let mut is_told = false;
    loop {
        match zenoh::open(config.clone()).wait() {
            Ok(session) => return Ok(session),
            Err(e) if !e.to_string().contains(UNREACHED) => return Err(zenoh(e)),
            Err(_) if signals.caught().is_some() => return Err(NetError::Silent(relay.into())),
            Err(_) if !is_told => {
                note(&format!("no relay answers at {relay}; trying on"));
                is_told = true;
            }
            Err(_) => {}
        }
    }
}

/// Addresses to listen at and to connect to, as zenoh writes them.
fn endpoints(at: &At, secure: bool) -> Result<(Vec<String>, Vec<String>), NetError> {
    let protocol = if secure { "tls" } else { "tcp" };
    let endpoint = |option, address: &String| -> Result<String, NetError> {
        let address = checked(option, address, at.plain || secure)?;
        Ok(format!("{protocol}/{address}"))
    };
    if let Some(relay) = &at.relay {
        return Ok((Vec::new(), vec![endpoint("--relay", relay)?]));
    }
    let all = |option, addresses: &[String]| -> Result<Vec<String>, NetError> {
        addresses.iter().map(|a| endpoint(option, a)).collect()
    };
    let (mut listen, mut connect) = (all("--listen", &at.listen)?, all("--connect", &at.connect)?);
    if listen.is_empty() && connect.is_empty() {
        // The first one here is where the others meet; they find each other through it, and need it no more.
        match TcpListener::bind(MEETING) {
            Ok(_free) => listen.push(format!("{protocol}/{MEETING}")),
            Err(_) => {
                listen.push(format!("{protocol}/127.0.0.1:0"));
                connect.push(format!("{protocol}/{MEETING}"));
            }
        }
    }
    if listen.is_empty() {
        // Peers do not pass on messages of others: programs that list or record have to reach this one too.
        let local = connect_is_local(&at.connect);
        let any = if local { "127.0.0.1:0" } else { "0.0.0.0:0" };
        listen.push(format!("{protocol}/{any}"));
    }
    Ok((listen, connect))
}

/// Waits until another session is reached, so that questions at the start find those who are there already.
fn await_others(session: &Session) {
    let clock = RunClock::start();
    let info = session.info();
    while clock.now().since(Instant::ZERO) < FIRST {
        if info.peers_zid().wait().count() + info.routers_zid().wait().count() > 0 {
            return;
        }
        clock.sleep_until(clock.now() + Duration::from_millis(10));
    }
}

/// Tells whether all of these addresses are of this machine.
fn connect_is_local<'a>(addresses: impl IntoIterator<Item = &'a String>) -> bool {
    let local = |address: &String| checked("--connect", address, false).is_ok();
    addresses.into_iter().all(local)
}

/// Checks an address: text to and from it may be plain.
fn checked(option: &'static str, address: &str, anywhere: bool) -> Result<String, NetError> {
    let is_address = address
        .rsplit_once(':')
        .is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
    if !is_address {
        return Err(NetError::Address {
            option,
            address: address.into(),
        });
    }
    let local = || {
        let mut all = address.to_socket_addrs().ok()?.peekable();
        all.peek()?;
        Some(all.all(|a| match a.ip() {
            IpAddr::V4(ip) => ip.is_loopback(),
            IpAddr::V6(ip) => ip.is_loopback(),
        }))
    };
    if anywhere || local() == Some(true) {
        return Ok(address.into());
    }
    Err(NetError::Plain {
        option,
        address: address.into(),
    })
}

/// Settings of a session. With zenoh's own defaults a cut of five seconds is no event, and ends in a burst of old
/// frames.
fn settings(mode: &str, listen: &[String], connect: &[String]) -> Value {
    // A client's session is open when it is connected, and not before.
    let (timeout_ms, exit) = match mode {
        "client" => (ATTEMPT_MS, true),
        _ => (-1, false),
    };
    let retry = json!({"period_init_ms": 100, "period_max_ms": 400, "period_increase_factor": 2});
    json!({
        "mode": mode,
        "listen": {"endpoints": listen, "exit_on_failure": true, "retry": retry},
        "connect": {
            "endpoints": connect, "timeout_ms": timeout_ms, "exit_on_failure": exit, "retry": retry,
        },
        "open": {"return_conditions": {"connect_scouted": false, "declares": false}},
        "scouting": {
            "delay": 0,
            "multicast": {"enabled": false},
            "gossip": {"enabled": true},
        },
        "transport": {
            "unicast": {"open_timeout": 2000, "accept_timeout": 2000},
            "link": {
                "tx": {"lease": 1000, "keep_alive": 4},
                "rx": {"max_message_size": MOST_BYTES},
            },
        },
    })
}

#[cfg(test)]
#[path = "open_tests.rs"]
mod tests;
