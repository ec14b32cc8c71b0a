//! A run on device nodes under the eyes of a page, in a browser of another machine: STOP there is the latched stop.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::time::{Duration, Instant};

use serde_json::json;

use super::tools::{hil, in_lab, number_of, scene, sh, text};
use super::ward::{Fate, Ward, patiently};

/// The page says STOP within this time of the lab's own, which a busy host makes short.
const MOST: Duration = Duration::from_secs(300);

/// Part of what the run says of its page.
const URL: &str = "live view: http://";

/// `ci/browser.d/lab.mjs` has the page: it reads where it is, looks on, and says STOP.
#[test]
fn a_run_is_shown_to_a_browser_and_stopped_by_it() {
    let port = number_of("PALPATE_LAB_PORT", 0);
    if !in_lab("the page over a run on device nodes") {
        return;
    }
    if port == 0 {
        println!("SKIPPED the page over a run on device nodes: ci/lab-suite has its browser");
        return;
    }
    patiently(|| {
        let press = scene("press.toml");
        let mut ward = Ward::open(&press, &[]);
        let options = ["--serve", &format!("0.0.0.0:{port}")];
        // It begins when the page is there.
        let mut is_told = false;
        let mut run = ward.run_heard("driving", &press, &options, |said| {
            let rest = said.split(URL).nth(1);
            let url = rest.and_then(|rest| rest.split_once(';'));
            if let Some((url, _)) = url.filter(|_| !is_told) {
                println!("page http://{url}");
                is_told = true;
            }
        });
        let begun = Instant::now();
        while run.child.try_wait().unwrap().is_none() {
            assert!(begun.elapsed() < MOST, "no page has said STOP");
            ward.emulator.hear(Duration::from_millis(20));
        }
        let status = run.end();
        ward.check_speed()?;
        let said = ward.said();
        assert_eq!(status.code(), Some(4), "{said}");
        assert!(said.contains("STOP on a page"), "{said}");
        assert!(matches!(ward.fate(0), Fate::Off(_)), "outputs are on");
        let held = ward.latch().read().unwrap();
        assert!(held.verified, "{held:?}");

        let refused = ward.command(&press, &[]).output().unwrap();
        let refused = (refused.status.code(), text(&refused.stderr));
        assert_eq!(refused.0, Some(4), "{refused:?}");
        assert!(refused.1.contains("STOP on a page"), "{refused:?}");
        let bench = ward.bench().display();
        let cleared = sh(&format!(
            "{} off --unlatch --bench {bench}",
            hil().display()
        ));
        assert!(cleared.contains("the stop is cleared"), "{cleared}");
        assert!(ward.latch().read().is_none());
        let mut again = ward.run(&press, &[]);
        again.child.kill().unwrap();
        again.end();

        let record = ward.emulator.stop();
        assert_eq!(record["driving"], json!([]));
        println!("page stopped");
        Ok(())
    });
}
