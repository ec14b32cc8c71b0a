//! `palpate-link list`: publishers and wearers of fingers, by their own words.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_live::output::{print, print_json};
use palpate_records::mcap::decode;
use palpate_run::Failure;
use serde::Serialize;
use zenoh::Wait as _;
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample;

use crate::cli::{ListArgs, after};
use crate::message::{About, VERSION, Wearer};
use crate::name::{FingerName, ROOT};
use crate::net::{self, Mode, Net, NetError, zenoh};

/// A publisher of a finger.
#[derive(Debug, Serialize)]
struct Publisher {
    session: String,
    sends: String,
    scene: String,
    layout: String,
    version: u32,
}

/// Wearer of a finger.
#[derive(Debug, Serialize)]
struct Worn {
    wearer: String,
    feels: Option<String>,
    trouble: String,
    stopped: String,
}

/// A finger with its publishers and wearers.
#[derive(Debug, Default, Serialize)]
struct Listed {
    finger: String,
    publishers: Vec<Publisher>,
    wearers: Vec<Worn>,
    /// Publishers that are there and gave no answer.
    silent: Vec<String>,
}

/// The finger of a key, and the rest of the key after it.
fn split(key: &str) -> Option<(FingerName, &str)> {
    let rest = key.strip_prefix(ROOT)?.strip_prefix('/')?;
    let at = rest.match_indices('/').nth(2)?.0;
    Some((rest[..at].parse().ok()?, &rest[at + 1..]))
}

/// Newest message of each wearer, by finger and name.
type Said = BTreeMap<(String, String), Wearer>;

/// Keeps messages of wearers.
fn listen(net: &Net, said: Arc<Mutex<Said>>) -> Result<Subscriber<()>, NetError> {
    let hear = move |sample: Sample| {
        let wearer = net::bytes(&sample).and_then(|bytes| decode::<Wearer>(&bytes));
        let place = split(sample.key_expr().as_str());
        if let (Some((finger, rest)), Some(wearer)) = (place, wearer)
            && let Some(name) = rest.strip_prefix("wearers/")
        {
            let key = (finger.to_string(), name.to_owned());
            said.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .insert(key, wearer);
        }
    };
    net::subscribe(&net.session, format!("{ROOT}/*/*/*/wearers/*"), hear)
}

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &ListArgs) -> Result<(), Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(e.to_string()))?;
    let net = net::open(&args.at.at(), Mode::Peer, &signals)?;
    let said = Arc::new(Mutex::new(Said::new()));
    let hears = listen(&net, Arc::clone(&said))?;
    let wait = Duration::from_secs_f64(args.seconds);
    let clock = RunClock::start();
    clock.sleep_until(after(args.seconds.min(0.5)));
    let mut fingers: BTreeMap<String, Listed> = BTreeMap::new();
    let all = format!("{ROOT}/*/*/*/about");
    let answers = net.session.get(all).timeout(wait).wait().map_err(zenoh)?;
    for sample in net::samples(answers) {
        let about = decode::<About>(&sample.payload().to_bytes());
        if let (Some((finger, _)), Some(about)) = (split(sample.key_expr().as_str()), about) {
            listed(&mut fingers, &finger.to_string())
                .publishers
                .push(Publisher {
                    session: format!("{:016x}", about.session),
                    sends: about.kind,
                    scene: about.scene,
                    layout: about.layout_name,
                    version: about.version,
                });
        }
    }
    let tokens = net
        .session
        .liveliness()
        .get(format!("{ROOT}/*/*/*/alive/**"));
    let tokens = tokens.timeout(wait).wait().map_err(zenoh)?;
    for sample in net::samples(tokens) {
        let Some((finger, rest)) = split(sample.key_expr().as_str()) else {
            continue;
        };
        let finger = listed(&mut fingers, &finger.to_string());
        if let Some(session) = rest.strip_prefix("alive/skin/") {
            if !finger.publishers.iter().any(|p| p.session == session) {
                finger.silent.push(session.to_owned());
            }
        } else if let Some(wearer) = rest.strip_prefix("alive/wearer/") {
            let said = said.lock().unwrap_or_else(PoisonError::into_inner);
            let said = said
                .get(&(finger.finger.clone(), wearer.to_owned()))
                .cloned()
                .unwrap_or_default();
            finger.wearers.push(Worn {
                wearer: wearer.to_owned(),
                feels: (said.feels != 0).then(|| format!("{:016x}", said.feels)),
                trouble: said.trouble,
                stopped: said.stopped,
            });
        }
    }
    drop(hears);
    tell(args, &fingers.into_values().collect::<Vec<_>>())
}

fn listed<'a>(fingers: &'a mut BTreeMap<String, Listed>, finger: &str) -> &'a mut Listed {
    fingers.entry(finger.to_owned()).or_insert_with(|| Listed {
        finger: finger.to_owned(),
        ..Listed::default()
    })
}

fn tell(args: &ListArgs, fingers: &[Listed]) -> Result<(), Failure> {
    if args.json {
        return print_json(fingers);
    }
    print(|out| {
        if fingers.is_empty() {
            return writeln!(
                out,
                "no publisher and no wearer answered within {} s",
                args.seconds
            );
        }
        for finger in fingers {
            writeln!(out, "{}", finger.finger)?;
            for p in &finger.publishers {
                let version = match p.version == VERSION {
                    true => String::new(),
                    false => format!(", version {} (here {VERSION})", p.version),
                };
                writeln!(
                    out,
                    "  published by {}: {} of layout {}, {}{version}",
                    p.session, p.sends, p.layout, p.scene
                )?;
            }
            for session in &finger.silent {
                writeln!(out, "  publisher {session} is there and gave no answer")?;
            }
            for w in &finger.wearers {
                let how = match (&w.feels, w.stopped.is_empty(), w.trouble.is_empty()) {
                    (_, false, _) => format!("off: {}", w.stopped),
                    (Some(session), _, true) => format!("feels {session}"),
                    (Some(session), _, false) => {
                        format!("feels {session}, with trouble: {}", w.trouble)
                    }
                    (None, _, false) => format!("feels nothing: {}", w.trouble),
                    (None, _, true) => "feels nothing".into(),
                };
                writeln!(out, "  worn by {}: {how}", w.wearer)?;
            }
        }
        Ok(())
    })
}
