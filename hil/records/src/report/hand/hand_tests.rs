//! Tests of `mod.rs`.

use super::*;
use crate::report::tests::{show, written};
use crate::synthetic;
use crate::trace::{Event, PlaceUm, event};
use crate::verdict::Verdict;

fn pad(name: &str, y: f64) -> Pad {
    let side = |i: usize| 4.7 * i as f64 - 7.05;
    Pad {
        name: name.to_owned(),
        place_mm: [0.0, y],
        taxels_mm: (0..16).map(|i| [side(i % 4), -side(i / 4)]).collect(),
    }
}

fn page(traces: &[Trace], names: &[&str], merged: bool, pads: &[Pad]) -> String {
    let ended = [Conclusion::default(), {
        let mut stopped = Conclusion::default();
        stopped.add(Verdict::Stopped, "display `<b>`: board gone");
        stopped
    }];
    let modules: Vec<[usize; 2]> = (0..names.len()).map(|n| [2 * n, 2 * n + 1]).collect();
    let files: Vec<String> = names.iter().map(|n| format!("a page-{n}.html")).collect();
    let fingers = names.iter().enumerate().map(|(n, name)| FingerReport {
        name,
        file: &files[n],
        trace: &traces[n],
        modules: &modules[n],
        merged,
        conclusion: &ended[n % 2],
    });
    let fingers: Vec<FingerReport<'_>> = fingers.collect();
    hand_html(&HandReport {
        trace: &traces[0],
        pads,
        fingers: &fingers,
        made: &[("command", "hil run <a>".to_owned())],
        conclusion: &ended[0],
    })
}

fn moved(mut trace: Trace, to: u16) -> Trace {
    for event in &mut trace.events {
        if let Event::Contact(event::Contact { module, .. }) = event {
            *module += to;
        }
    }
    trace
}

#[test]
fn every_finger_is_drawn_twice_and_leads_to_its_page() {
    let traces = [0, 2, 4].map(|to| moved(synthetic::circle(5), to));
    let names = ["index", "ring", "thumb"];
    let pads: Vec<Pad> = (0..6)
        .map(|n| pad(&format!("m{n}"), f64::from(-30 * (n % 2))))
        .collect();
    let page = page(&traces, &names, false, &pads);
    show("hand.html", &page);
    written(&page);
    for name in names {
        let link = format!("href=\"./a%20page-{name}.html\"");
        assert_eq!(page.matches(&link).count(), 3, "two hands and a card");
    }
    assert_eq!(page.matches("class=\"thimble\"").count(), 3);
    assert_eq!(page.matches("class=\"taxel\" d=").count(), 6);
    assert!(page.contains("m0 drives; m1 recorded") && page.contains("8 wires on board 0"));
    assert!(page.contains("STOPPED") && page.contains("&lt;b&gt;"));
    assert!(page.contains(" felt</span>") && page.contains(" mm</text>"));
}

#[test]
fn what_is_missing_or_absurd_leaves_a_hand() {
    let written_of = |traces: &[Trace], names: &[&str], merged, pads: &[Pad]| {
        written(&page(traces, names, merged, pads));
    };
    written_of(&[synthetic::empty()], &["<i>"], false, &[]);
    let mut odd = synthetic::circle(1);
    odd.header.wires.clear();
    odd.header.soa_us = u64::MAX;
    odd.events.push(Event::Contact(event::Contact {
        t_us: u64::MAX,
        frame: 0,
        module: u16::MAX,
        contact: u32::MAX,
        place: PlaceUm {
            x: i32::MIN,
            y: i32::MAX,
        },
        intensity_milli: 0,
        level: u16::MAX,
        members: 0,
    }));
    let wide = Pad {
        taxels_mm: vec![[-400.0, 0.0], [400.0, 0.0]],
        ..pad("wide", 0.0)
    };
    let all = page(&[odd], &["left-thumb"], true, std::slice::from_ref(&wide));
    written(&all);
    assert!(all.contains("of the hand's scale") && all.contains("The robot's left hand"));
}
