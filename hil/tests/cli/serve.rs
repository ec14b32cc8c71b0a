//! The page over a run: who gets it, what it gets, and what it can do.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::process::Child;

use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::handshake::client::Response;
use tungstenite::{Error, Message, WebSocket, client};

use super::*;

/// A run that is served, and the address that it printed.
pub(super) struct Served {
    pub(super) run: Child,
    /// `127.0.0.1:PORT`.
    pub(super) host: String,
    pub(super) token: Option<String>,
}

/// Ends a program that its test left running.
impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.run.kill();
        let _ = self.run.wait();
    }
}

pub(super) fn served(folder: &Folder, args: &[&str]) -> Served {
    let mut command = command(args, &folder.0);
    let mut run = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let mut told = BufReader::new(run.stderr.take().unwrap());
    told.read_line(&mut line).unwrap();
    // What comes later must find a reader.
    std::thread::spawn(move || std::io::copy(&mut told, &mut std::io::sink()));
    let url = line.split("://").nth(1).unwrap_or_else(|| panic!("{line}"));
    let url = url.split([';', ' ', '\n']).next().unwrap();
    let (host, rest) = url.split_once('/').unwrap_or((url, ""));
    Served {
        run,
        host: host.replace("0.0.0.0", "127.0.0.1"),
        token: rest.strip_prefix("#token=").map(str::to_owned),
    }
}

impl Served {
    pub(super) fn stream(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        let patience = Some(std::time::Duration::from_secs(20));
        stream.set_read_timeout(patience).unwrap();
        stream
    }

    /// The answer to a request as it is.
    fn said(&self, request: &str) -> String {
        let mut stream = self.stream();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        let _ = stream.read_to_string(&mut answer);
        answer
    }

    pub(super) fn get(&self, path: &str, host: &str) -> String {
        self.said(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"))
    }

    /// A page's socket.
    pub(super) fn page(
        &self,
        query: &str,
        origin: Option<&str>,
    ) -> Result<WebSocket<TcpStream>, u16> {
        let mut request = format!("ws://{}/live{query}", self.host)
            .into_client_request()
            .unwrap();
        if let Some(origin) = origin {
            request
                .headers_mut()
                .insert("Origin", origin.parse().unwrap());
        }
        match client(request, self.stream()) {
            Ok((socket, _)) => Ok(socket),
            Err(tungstenite::HandshakeError::Failure(Error::Http(refused))) => {
                let refused: Response = refused.as_ref().clone();
                Err(refused.status().as_u16())
            }
            Err(other) => panic!("{other}"),
        }
    }

    pub(super) fn own_page(&self) -> WebSocket<TcpStream> {
        self.page("", Some(&format!("http://{}", self.host)))
            .unwrap()
    }

    pub(super) fn ended(mut self) -> (Option<i32>, String) {
        let mut out = String::new();
        let mut stdout = self.run.stdout.take().unwrap();
        stdout.read_to_string(&mut out).unwrap();
        (self.run.wait().unwrap().code(), out)
    }
}

/// What comes next under a key; anything else is passed over.
pub(super) fn next(page: &mut WebSocket<TcpStream>, key: &str) -> Value {
    loop {
        let text = match page.read() {
            Ok(Message::Text(text)) => text,
            Ok(_) => continue,
            Err(Error::Io(cause)) if cause.kind() == ErrorKind::Interrupted => continue,
            Err(error) => panic!("{error}"),
        };
        let value: Value = serde_json::from_str(&text).unwrap();
        if value.get(key).is_some() {
            return value;
        }
    }
}

pub(super) fn stop(page: &mut WebSocket<TcpStream>) {
    page.send(Message::text(r#"{"stop":true}"#)).unwrap();
}

#[test]
fn two_pages_see_a_run_and_either_can_stop_it() {
    let folder = Folder::new("serve-two");
    let run = served(
        &folder,
        &[
            "run",
            "sphere-circle",
            "--serve",
            "0",
            "--set",
            "length_s=120",
        ],
    );
    let index = run.get("/", &run.host);
    assert!(
        index.starts_with("HTTP/1.1 200") && index.contains("palpate/live.js"),
        "{index}"
    );
    assert!(index.contains(&format!("connect-src 'self' ws://{};", run.host)));
    let (mut one, mut two) = (run.own_page(), run.own_page());
    for page in [&mut one, &mut two] {
        let hello = &next(page, "hello")["hello"];
        assert_eq!(hello["heads"][0]["scene"], "sphere-circle");
        assert_eq!(hello["heads"][0]["wires_mm"].as_array().unwrap().len(), 8);
    }
    // From the third second on something is touched, driven, and felt.
    let mut last = (0, 0);
    let (mut bursts, mut felt) = (0, 0);
    while last.1 < 2_500_000 {
        let made = next(&mut one, "picture");
        let (number, picture) = (made["number"].as_u64().unwrap(), &made["picture"]);
        let now = picture["now_us"].as_u64().unwrap();
        assert!(number > last.0 && now > last.1, "{made}");
        last = (number, now);
        bursts += picture["bursts"].as_array().unwrap().len();
        felt += picture["felt"].as_array().unwrap().len();
        // None before the first scan.
        assert!([0, 16].contains(&picture["counts"].as_array().unwrap().len()));
        assert_eq!(picture["used"].as_array().unwrap().len(), 11);
        assert!(picture["warm"][7][1].as_f64().unwrap() > 29.5);
    }
    assert!(bursts > 10 && felt > 5, "{bursts} bursts, {felt} felt");
    // The other page has not looked until now, and has them in order.
    let seen = [(); 3].map(|()| next(&mut two, "picture")["number"].as_u64().unwrap());
    assert!(seen.is_sorted_by(|a, b| a < b), "{seen:?}");
    stop(&mut two);
    for page in [&mut one, &mut two] {
        let over = next(page, "over")["over"].as_str().unwrap().to_owned();
        assert!(over.starts_with("STOPPED"), "{over}");
    }
    let (status, out) = run.ended();
    assert_eq!(status, Some(0), "{out}");
    let last = out.lines().last().unwrap();
    assert_eq!(last, "STOPPED: by the person who watched");
}

#[test]
fn pages_of_another_site_get_nothing() {
    let folder = Folder::new("serve-sites");
    let run = served(
        &folder,
        &["run", "idle", "--serve", "0", "--set", "length_s=120"],
    );
    let own = format!("http://{}", run.host);
    for host in [
        "evil.example",
        "evil.example:80",
        "10.0.0.1",
        "",
        "127.0.0.1.evil.example",
    ] {
        assert!(run.get("/", host).starts_with("HTTP/1.1 403"), "{host}");
    }
    for host in ["localhost:1", "127.0.0.1", "[::1]:8137"] {
        assert!(
            run.get("/style.css", host).starts_with("HTTP/1.1 200"),
            "{host}"
        );
    }
    for path in ["/../Cargo.toml", "/main.js", "/palpate.wasm", "//"] {
        assert!(
            run.get(path, &run.host).starts_with("HTTP/1.1 404"),
            "{path}"
        );
    }
    assert!(run.get("/live", &run.host).starts_with("HTTP/1.1 403"));
    let twice = format!("GET / HTTP/1.1\r\nHost: {0}\r\nHost: {0}\r\n\r\n", run.host);
    assert!(run.said(&twice).starts_with("HTTP/1.1 403"));
    let post = format!("POST / HTTP/1.1\r\nHost: {}\r\n\r\n", run.host);
    assert!(run.said(&post).starts_with("HTTP/1.1 400"));
    assert!(run.said("hello\r\n\r\n").starts_with("HTTP/1.1 400"));
    let long = format!(
        "GET / HTTP/1.1\r\nHost: {}\r\nCookie: {}\r\n",
        run.host,
        "x".repeat(9000)
    );
    let answer = run.said(&long);
    assert!(
        answer.is_empty() || answer.starts_with("HTTP/1.1 400"),
        "{answer}"
    );
    for origin in [
        None,
        Some("http://evil.example"),
        Some("null"),
        Some("https://127.0.0.1:1"),
    ] {
        assert_eq!(run.page("", origin).err(), Some(403), "{origin:?}");
    }
    // What is no wish of a page ends its socket and nothing else.
    let mut rude = run.own_page();
    rude.send(Message::text(r#"{"drive":true}"#)).unwrap();
    while rude.read().is_ok() {}
    let mut page = run.page("", Some(&own)).unwrap();
    next(&mut page, "picture");
    stop(&mut page);
    assert_eq!(run.ended().0, Some(0));
}

#[test]
fn another_address_needs_the_token() {
    let folder = Folder::new("serve-token");
    let run = served(
        &folder,
        &[
            "run",
            "idle",
            "--serve",
            "0.0.0.0:0",
            "--set",
            "length_s=120",
        ],
    );
    let own = format!("http://{}", run.host);
    let token = run.token.clone().unwrap();
    assert!(token.len() == 32 && token.chars().all(|c| c.is_ascii_hexdigit()));
    for query in ["", "?token=", "?token=00000000000000000000000000000000"] {
        assert_eq!(run.page(query, Some(&own)).err(), Some(403), "{query}");
    }
    let query = format!("?token={token}");
    assert_eq!(
        run.page(&query, Some("http://evil.example")).err(),
        Some(403)
    );
    let mut page = run.page(&query, Some(&own)).unwrap();
    next(&mut page, "picture");
    stop(&mut page);
    assert_eq!(run.ended().0, Some(0));
}

#[test]
fn a_run_that_is_served_has_the_same_records() {
    let endings = ["jsonl", "csv", "mcap", "vcd", "snap"];
    let records = |name: &str, more: &[&str]| {
        let folder = Folder::new(name);
        let mut args = vec!["run", "sphere-diagonal", "--set", "length_s=3"];
        let files = endings.map(|ending| format!("a.{ending}"));
        files
            .iter()
            .for_each(|file| args.extend(["--record", file]));
        args.extend(more);
        (
            folder,
            args.iter().map(|a| (*a).to_owned()).collect::<Vec<_>>(),
        )
    };
    let (plain, args) = records("serve-plain", &["--quiet"]);
    assert_eq!(hil_in(&plain.0, &args).status, Some(0));
    let (seen, args) = records("serve-seen", &["--serve", "0"]);
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let run = served(&seen, &args);
    let mut page = run.own_page();
    while next(&mut page, "picture")["picture"]["now_us"]
        .as_u64()
        .unwrap()
        < 2_900_000
    {}
    let over = next(&mut page, "over");
    assert!(over["over"].as_str().unwrap().starts_with("OK"));
    // Names and words as in the summary's margins.
    let measured = over["measured"].as_array().unwrap();
    assert!(measured.len() > 8, "{measured:?}");
    assert!(
        measured
            .iter()
            .any(|row| row[0] == "burst" && row[1] == "61 %")
    );
    // A page that opens now sees how it ended, and what there was last.
    let mut late = run.own_page();
    assert_eq!(
        next(&mut late, "hello")["hello"]["heads"][0]["scene"],
        "sphere-diagonal"
    );
    assert_eq!(next(&mut late, "over"), over);
    assert!(next(&mut late, "picture")["picture"]["now_us"].as_u64() >= Some(2_900_000));
    assert_eq!(run.interrupted(), Some(0));
    for ending in endings {
        let read = |folder: &Folder| fs::read(folder.path(&format!("a.{ending}"))).unwrap();
        assert!(read(&plain) == read(&seen), "{ending}");
    }
}

/// A run of the circle as a record.
pub(super) fn recorded(folder: &Folder, name: &str, more: &[&str]) {
    let mut args = vec!["run", "sphere-circle", "--set", "length_s=4", "--quiet"];
    args.extend(["--record", name]);
    args.extend(more);
    let said = hil_in(&folder.0, &args);
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
}

/// What a page is told when it says something.
pub(super) fn answer(page: &mut WebSocket<TcpStream>, wish: &str, key: &str) -> Value {
    page.send(Message::text(wish.to_owned())).unwrap();
    next(page, key)[key].clone()
}

impl Served {
    /// What it ends with when a signal comes.
    pub(super) fn interrupted(self) -> Option<i32> {
        let kill = Command::new("kill")
            .args(["-INT", &self.run.id().to_string()])
            .status();
        assert!(kill.unwrap().success());
        self.ended().0
    }
}

#[test]
fn a_recording_is_shown_at_the_moment_that_a_page_asks_for() {
    let folder = Folder::new("serve-recording");
    recorded(&folder, "a.mcap", &["--record", "a.csv"]);
    let run = served(&folder, &["serve", "a.mcap", "--at", "0"]);
    let index = run.get("/", &run.host);
    assert!(index.contains("palpate/recording.js"), "{index}");
    let mut page = run.own_page();
    let hello = answer(&mut page, r#"{"run":0}"#, "hello");
    assert_eq!(hello["heads"][0]["scene"], "sphere-circle");
    assert_eq!(hello["recording"]["of"][0]["file"], "a.mcap");
    assert_eq!(hello["recording"]["lacks"], serde_json::json!([]));
    assert!(hello["recording"]["damaged"].is_null());
    let end = hello["end_us"].as_u64().unwrap();
    assert!((3_900_000..=4_000_000).contains(&end), "{end}");
    let mut show = |at: u64| answer(&mut page, &format!(r#"{{"at_us":{at}}}"#), "moment");
    // There, on, and back: contacts and readings are those of the contacts' own record.
    let table = folder.text("a.csv");
    for at in [2_000_000, 2_500_000, 3_500_000, 1_500_000, 2_000_000] {
        let moment = show(at);
        let picture = &moment["picture"];
        assert_eq!(picture["now_us"], at);
        assert_eq!(picture["counts"].as_array().unwrap().len(), 16);
        let newest = table.lines().skip(1).filter_map(|line| {
            let t_us: u64 = line.split(',').nth(1)?.parse().ok()?;
            (t_us <= at).then_some(line)
        });
        let row: Vec<&str> = newest.last().unwrap().split(',').collect();
        let contact = &picture["contacts"][0];
        assert_eq!(contact["id"].to_string(), row[3], "{row:?}");
        let x_mm: f64 = row[4].parse().unwrap();
        assert!((contact["at_mm"][0].as_f64().unwrap() - x_mm).abs() < 2e-3);
        assert!(contact["on_mm"].is_array() && !picture["spheres"].as_array().unwrap().is_empty());
        assert!(picture["warm"][7][1].as_f64().unwrap() > 29.5);
        assert!(moment["totals"]["stimuli"].as_u64().unwrap() > 10);
    }
    let moment = show(u64::MAX);
    assert_eq!(moment["picture"]["now_us"].as_u64(), Some(end));
    // What is no wish of a page over recordings ends its socket and nothing else.
    for wish in [r#"{"stop":true}"#, r#"{"run":1}"#, r#"{"at_us":-1}"#] {
        let mut rude = run.own_page();
        rude.send(Message::text(wish)).unwrap();
        assert!(rude.read().is_err(), "{wish}");
    }
    // Without a recording chosen there is no moment.
    let mut early = run.own_page();
    early.send(Message::text(r#"{"at_us":5}"#)).unwrap();
    answer(&mut early, r#"{"run":0}"#, "hello");
    assert_eq!(run.interrupted(), Some(0));
}

#[test]
fn two_recordings_have_a_page_each_with_the_options_of_their_runs() {
    let folder = Folder::new("serve-pair");
    recorded(&folder, "a.mcap", &[]);
    recorded(&folder, "b.mcap", &["--illusion", "phantom", "--seed", "7"]);
    let run = served(&folder, &["serve", "a.mcap", "b.mcap", "--at", "0"]);
    for (number, illusion, seed) in [(0, "inverse", 1), (1, "phantom", 7)] {
        let mut page = run.own_page();
        let hello = answer(&mut page, &format!(r#"{{"run":{number}}}"#), "hello");
        let head = &hello["heads"][0];
        assert_eq!(head["illusion"], illusion);
        assert_eq!(head["seed"], seed);
        assert_eq!(hello["recording"]["shown"], number);
        assert_eq!(hello["recording"]["of"].as_array().unwrap().len(), 2);
        let moment = answer(&mut page, r#"{"at_us":2000000}"#, "moment");
        assert!(!moment["picture"]["bursts"].as_array().unwrap().is_empty());
    }
    assert_eq!(run.interrupted(), Some(0));
}

#[test]
fn a_recording_that_was_cut_is_shown_up_to_the_cut() {
    let folder = Folder::new("serve-cut");
    recorded(&folder, "a.mcap", &[]);
    let bytes = fs::read(folder.path("a.mcap")).unwrap();
    fs::write(folder.path("a.mcap"), &bytes[..bytes.len() * 2 / 3]).unwrap();
    let run = served(&folder, &["serve", "a.mcap", "--at", "0"]);
    let mut page = run.own_page();
    let hello = answer(&mut page, r#"{"run":0}"#, "hello");
    let damaged = hello["recording"]["damaged"].as_str().unwrap();
    assert!(
        damaged.contains("cut short") && damaged.contains("shown until"),
        "{damaged}"
    );
    answer(&mut page, r#"{"at_us":2000000}"#, "moment");
    answer(&mut page, r#"{"at_us":9000000}"#, "moment");
    // A file that is written over while it is shown is no file of ours any more.
    fs::write(folder.path("a.mcap"), vec![0; bytes.len()]).unwrap();
    let failed = answer(&mut page, r#"{"at_us":1000000}"#, "failed");
    assert!(
        failed.as_str().unwrap().contains("serve it again"),
        "{failed}"
    );
    fs::write(folder.path("a.mcap"), &bytes[..bytes.len() * 2 / 3]).unwrap();
    answer(&mut page, r#"{"at_us":1000000}"#, "moment");
    assert_eq!(run.interrupted(), Some(0));
}

#[test]
fn what_is_no_recording_of_a_run_is_not_served() {
    let folder = Folder::new("serve-bad");
    recorded(&folder, "a.mcap", &["--record", "a.vcd"]);
    let path = |name: &str| folder.path(name).display().to_string();
    let (whole, pins) = (path("a.mcap"), path("a.vcd"));
    fs::write(folder.path("empty.mcap"), b"").unwrap();
    fs::write(folder.path("torn.mcap"), &fs::read(&whole).unwrap()[..100]).unwrap();
    for (args, words) in [
        (vec![path("none.mcap")], &["none.mcap", "no such file"][..]),
        (vec![path("empty.mcap")], &["empty.mcap", "an MCAP file"]),
        (vec![path("torn.mcap")], &["torn.mcap", "cut short"]),
        (
            vec![pins.clone()],
            &[
                "a.vcd",
                "a scene (TOML) or a recording",
                "value change dump",
            ],
        ),
        (vec![whole.clone(), pins], &["a.vcd", "value change dump"]),
        (
            vec![whole.clone(), "sphere-along".into()],
            &["sphere-along", "one or two recordings"],
        ),
        (
            vec![whole.clone(), "--bench".into(), "thesis".into()],
            &["--bench", "has its bench with it"],
        ),
        (
            vec![whole.clone(), "--loop".into()],
            &["--loop", "its page plays it again"],
        ),
    ] {
        let args: Vec<String> = ["serve".to_owned()].into_iter().chain(args).collect();
        refused_with(&args, words);
    }
    refused_with(
        &["serve", &whole, &whole, &whole],
        &["no more were expected"],
    );
}
