//! More connections than the server of a page takes: who has the token gets in, whatever the others do.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use super::serve::{Served, next, served, stop};
use super::*;

/// Connections that the server takes of each kind.
const MOST: usize = 64;
const LONG: [&str; 4] = ["run", "idle", "--set", "length_s=120"];

fn serving(folder: &Folder, at: &str) -> Served {
    served(folder, &[&LONG[..], &["--serve", at]].concat())
}

/// Who begins a request and does not end it.
fn stranger(run: &Served) -> TcpStream {
    let mut stream = run.stream();
    let begun = format!("GET / HTTP/1.1\r\nHost: {}\r\nX: ", run.host);
    stream.write_all(begun.as_bytes()).unwrap();
    stream
}

#[test]
fn strangers_keep_no_page_with_the_token_out() {
    let folder = Folder::new("crowd-strangers");
    let run = serving(&folder, "0.0.0.0:0");
    let (own, query) = (
        format!("http://{}", run.host),
        format!("?token={}", run.token.clone().unwrap()),
    );
    let mut strangers = Vec::new();
    for _ in 0..4 {
        strangers.extend((0..MOST).map(|_| stranger(&run)));
        let mut page = run.page(&query, Some(&own)).unwrap();
        next(&mut page, "picture");
        // The files of the page as well.
        assert!(run.get("/live.js", &run.host).starts_with("HTTP/1.1 200"));
    }
    let mut page = run.page(&query, Some(&own)).unwrap();
    stop(&mut page);
    assert_eq!(run.ended().0, Some(0));
}

#[test]
fn a_request_that_drips_has_its_time() {
    let folder = Folder::new("crowd-drip");
    let run = serving(&folder, "0");
    let mut slow = stranger(&run);
    let step = Duration::from_millis(250);
    slow.set_read_timeout(Some(step)).unwrap();
    // A byte each step, for twice the time that a request has.
    let drips = (0..40).take_while(|_| {
        let waits = |e: std::io::Error| e.kind() == std::io::ErrorKind::WouldBlock;
        slow.write_all(b"a").is_ok() && slow.read(&mut [0; 64]).is_err_and(waits)
    });
    let drips = drips.count();
    assert!((10..40).contains(&drips), "{drips}");
    stop(&mut run.own_page());
    assert_eq!(run.ended().0, Some(0));
}

#[test]
fn of_too_many_pages_the_first_stay_and_the_newest_gets_in() {
    let folder = Folder::new("crowd-pages");
    let run = serving(&folder, "0");
    let mut pages: Vec<_> = (0..MOST + 3).map(|_| run.own_page()).collect();
    next(&mut pages[0], "picture");
    for gone in &mut pages[MOST - 1..MOST + 2] {
        while gone.read().is_ok() {}
    }
    let mut newest = pages.pop().unwrap();
    next(&mut newest, "picture");
    stop(&mut newest);
    next(&mut pages[0], "over");
    assert_eq!(run.ended().0, Some(0));
}
