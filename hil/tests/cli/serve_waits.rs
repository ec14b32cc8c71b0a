//! When a run before pages begins, begins anew and ends.

use super::serve::{next, served, stop};
use super::*;

#[test]
fn a_run_waits_for_its_page_and_begins_anew() {
    let folder = Folder::new("serve-loop");
    let args = ["run", "idle", "--serve", "0", "--loop"];
    let run = served(&folder, &[&args[..], &["--set", "length_s=1.2"]].concat());
    // Whatever passed before, the first page sees the run from its begin.
    let mut page = run.own_page();
    let mut runs = Vec::new();
    for _ in 0..2 {
        let hello = next(&mut page, "hello")["hello"].clone();
        runs.push(hello["run"].as_str().unwrap().to_owned());
        let first = next(&mut page, "picture")["picture"]["now_us"].as_u64();
        assert!(first < Some(500_000), "{first:?}");
        let over = next(&mut page, "over")["over"].as_str().unwrap().to_owned();
        assert!(over.starts_with("OK"), "{over}");
    }
    assert_ne!(runs[0], runs[1]);
    stop(&mut page);
    let (status, out) = run.ended();
    // The summary is that of the last whole one.
    assert!(status == Some(0) && out.contains("\nOK"), "{out}");
}

#[test]
fn a_run_that_no_page_sees_ends_with_a_signal() {
    let folder = Folder::new("serve-unseen");
    let run = served(
        &folder,
        &["run", "idle", "--serve", "0", "--record", "a.csv"],
    );
    assert_eq!(run.interrupted(), Some(130));
    assert!(!folder.path("a.csv").exists());
}

#[test]
fn what_no_loop_and_no_browser_can_have_is_refused() {
    let folder = Folder::new("serve-refused");
    let real = real_bench(&folder);
    for (args, words) in [
        (&["--loop"][..], &["--serve"][..]),
        (&["--open"], &["--serve"]),
        (
            &["--serve", "0", "--loop", "--out", "o"],
            &["--loop", "--out"],
        ),
        (
            &["--serve", "0", "--loop", "--bench", &real],
            &["--loop", "an emulated bench"],
        ),
        (
            &["--serve", "0.0.0.0:0", "--open"],
            &["--open", "this computer alone"],
        ),
    ] {
        refused_with(&[&["run", "idle"], args].concat(), words);
    }
}

#[test]
fn an_address_that_is_taken_or_none_is_refused() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let said = hil(&["run", "idle", "--serve", &address]);
    assert_eq!(said.status, Some(3), "{}", said.err);
    assert!(said.err.contains("port 0 takes a free one"), "{}", said.err);
    refused_with(
        &["run", "--serve", "sphere-along"],
        &["--serve", "ADDRESS:PORT"],
    );
}
