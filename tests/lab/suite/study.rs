//! A participant's session on a bench of device nodes: stimuli through the kernel, STOP from a page.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket, client};

use super::tools::{hil, in_lab, scene, scratch, sh, text, try_sh};
use super::ward::{Fate, TooSlow, Ward, now_ns, patiently};

/// Outputs are off so long after STOP at the latest.
const MOST: Duration = Duration::from_millis(100);

const PROTOCOL: &str = r#"
name = "lab"
description = "Where two wires are felt"
pause_s = 0.2
stimulus_s = 3.0
[localisation]
wires = [0, 5]
level_db = 0.0
repeats = 1
simulated = { bias_mm = { mean = 0.0, sd = 1.0 }, noise_mm = 2.0, slips = 0.0 }
"#;

struct Session {
    child: Child,
    page: WebSocket<TcpStream>,
}

fn begin(ward: &Ward, protocol: &str, out: &str, more: &[&str]) -> Session {
    ward.stop_boards();
    let mut command = Command::new(hil());
    command.args([
        "study",
        "run",
        protocol,
        "--participant",
        "1",
        "--out",
        out,
        "--at",
        "0",
        "--bench",
    ]);
    command.arg(ward.bench()).args(more).stdin(Stdio::null());
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    told.read_line(&mut line).unwrap();
    std::thread::spawn(move || std::io::copy(&mut told, &mut std::io::sink()));
    let host = line
        .split("http://")
        .nth(1)
        .unwrap_or_else(|| panic!("{line}"));
    let host = host.split('/').next().unwrap();
    let mut request = format!("ws://{host}/live").into_client_request().unwrap();
    let origin = format!("http://{host}").parse().unwrap();
    request.headers_mut().insert("Origin", origin);
    let stream = TcpStream::connect(host).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_millis(500)))
        .unwrap();
    let (mut page, _) = client(request, stream).unwrap();
    page.send(Message::text(r#"{"who":"participant"}"#))
        .unwrap();
    Session { child, page }
}

impl Session {
    fn say(&mut self, words: &Value) {
        self.page.send(Message::text(words.to_string())).unwrap();
    }

    /// Waits until the page shows a screen; returns its number.
    fn on(&mut self, screen: &str) -> u64 {
        let until = Instant::now() + Duration::from_secs(60);
        loop {
            assert!(Instant::now() < until, "no screen `{screen}`");
            match self.page.read() {
                Ok(Message::Text(said)) => {
                    let said: Value = serde_json::from_str(&said).unwrap();
                    if said["shows"]["screen"] == screen {
                        return said["view"].as_u64().unwrap();
                    }
                }
                Ok(_) => {}
                Err(tungstenite::Error::Io(_)) => self.say(&json!({ "alive": true })),
                Err(error) => panic!("the page's socket: {error}"),
            }
        }
    }
}

fn attempt(name: &str) -> Result<(), TooSlow> {
    // Pages are served on it, whichever test came before.
    sh("ip link set lo up");
    let mut ward = Ward::open(&scene("press.toml"), &[]);
    let [protocol, out] = ["protocol.toml", name].map(scratch);
    std::fs::write(&protocol, PROTOCOL).unwrap();
    let (protocol, out) = (protocol.display().to_string(), out.display().to_string());
    let mut session = begin(&ward, &protocol, &out, &[]);
    let view = session.on("begin");
    session.say(&json!({ "view": view, "reply": "read" }));
    session.on("play");
    ward.wait_for_outputs(true)?;
    let struck = now_ns();
    session.say(&json!({ "stop": true }));
    let status = session.child.wait().unwrap();
    match ward.fate(struck) {
        Fate::On => panic!("outputs are on after STOP"),
        Fate::Off(after_ns) => {
            let after = Duration::from_nanos(after_ns.unwrap_or(0));
            println!("STOP to outputs off: {:.1} ms", after.as_secs_f64() * 1e3);
            assert!(after <= MOST, "{after:?}");
        }
    }
    ward.check_speed()?;
    assert_eq!(status.code(), Some(4));
    // The stop is latched: the session goes on once a person has looked.
    let bench = ward.bench().display();
    let resumed = format!(
        "{} study run {protocol} --participant 1 --out {out} --at 0 --bench {bench} --resume",
        hil().display()
    );
    let refused = try_sh(&resumed);
    assert_eq!(refused.status.code(), Some(4), "{}", text(&refused.stderr));
    sh(&format!(
        "{} off --unlatch --bench {bench}",
        hil().display()
    ));
    let mut session = begin(&ward, &protocol, &out, &["--resume"]);
    let view = session.on("begin");
    session.say(&json!({ "view": view, "reply": "read" }));
    for _ in 0..2 {
        let view = session.on("place");
        session.say(&json!({ "view": view, "reply": { "answer": { "place": [1.0, 2.0] } } }));
    }
    session.on("done");
    assert!(session.child.wait().unwrap().success());
    let record = std::fs::read_to_string(format!("{out}/records/participant-1.jsonl")).unwrap();
    let lines: Vec<Value> = record
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines[0]["session"]["source"], "real");
    assert!(lines.iter().any(|line| line.get("stopped").is_some()));
    let void = |line: &&Value| line["reply"]["reply"].get("void").is_some();
    assert_eq!(lines.iter().filter(void).count(), 1);
    let played = lines
        .iter()
        .filter(|line| !void(line))
        .filter_map(|line| line["reply"]["trial"]["intervals"][0]["bursts"].as_array());
    let bursts: Vec<usize> = played.map(Vec::len).collect();
    assert!(
        bursts.len() == 2 && bursts.iter().all(|count| *count > 5),
        "{bursts:?}"
    );
    let record = ward.emulator.stop();
    assert_eq!(record["driving"], json!([]));
    Ok(())
}

#[test]
fn a_session_on_device_nodes_is_stopped_by_its_page_and_goes_on() {
    if !in_lab("a participant's session on device nodes") {
        return;
    }
    let mut tries = 0;
    patiently(|| {
        tries += 1;
        attempt(&format!("study-{tries}"))
    });
}
