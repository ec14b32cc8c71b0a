//! Rows of figures 4.5 and 4.6: a sphere that rolls over one module from the bottom to the top.

use palpate_files::PathKind;
use palpate_records::trace::{PlaceUm, event};
use palpate_run::{Failure, Outcome};
use serde_json::json;

use super::frame::PITCH_MM;
use super::row::{Answer, Mark, Row};
use super::setups::{CLUSTERS, changed, hertz, played as run, rate_hz, roll};

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "claim-4.4.1-rate",
        says: "The module is read at about 100 Hz.",
        assumed: "Boards on one CAN bus of 1 Mbit/s.",
        compute: rate,
    },
    Row {
        id: "fig-4.5-A",
        says: "The contact lies where the pressure is, and its path is very smooth.",
        assumed: "Close is within a tenth of the pitch (0.47 mm) of the sphere, over the inner taxels. From edge to edge in 1.08 s, force rising from 0.5 to 1 N: neither is printed.",
        compute: path,
    },
    Row {
        id: "fig-4.5-B",
        says: "Readouts that just count as contact have the first of K_I = 10 static levels.",
        assumed: "The roll of fig-4.5-A.",
        compute: rug,
    },
    Row {
        id: "fig-4.6-A",
        says: "At most 12 of 16 taxels are in contact, while the sphere is at the top border.",
        assumed: "The roll of fig-4.5-A with the threshold of (4.3) and no margin. The skin's coupling is assumed.",
        compute: fullest,
    },
    Row {
        id: "fig-4.6-B",
        says: "Compression is faster than the sensor's 100 Hz for K_C of 1 to 8, and slower for K_C = 16.",
        assumed: "This machine, one core: the whole loop from CAN frames to wires.",
        compute: speed,
    },
    Row {
        id: "fig-4.6-C",
        says: "More clusters cover more of the contact, until K_C = 16 gives every taxel in contact.",
        assumed: "The fullest frame of fig-4.6-A.",
        compute: cover,
    },
];

/// Highest taxel, mm.
const EDGE_MM: f64 = 7.05;

/// Runs the roll of figure 4.5.
fn rising(kc: u32) -> Result<Outcome, Failure> {
    run(&roll(kc, 0.5, 0.5)?)
}

fn rate() -> Result<Answer, Failure> {
    let outcome = run(&changed("sphere-along", |_| {})?)?;
    let refresh = outcome.summary.taxels.refresh_hz;
    let hz = refresh.map_or(0.0, |r| r.median);
    let frames = rate_hz(&outcome);
    Ok(Answer::new(
        Mark::new((95.0..=105.0).contains(&frames), || {
            "the boards have another rate".into()
        }),
        format!("{frames:.1} frames per second; a taxel changes {hz:.1} times per second."),
        json!({ "frames_hz": frames }),
    ))
}

/// Frames of a run: time, taxels in contact, true place of the sphere, the contact.
struct Seen {
    t_us: u64,
    in_contact: u16,
    truth: Option<(f64, f64)>,
    contacts: Vec<event::Contact>,
}

fn mm(place: PlaceUm) -> (f64, f64) {
    (f64::from(place.x) * 1e-3, f64::from(place.y) * 1e-3)
}

fn frames(outcome: &Outcome) -> Vec<Seen> {
    let seen = |frame: &event::Frame| Seen {
        t_us: frame.t_us,
        in_contact: frame.in_contact,
        truth: None,
        contacts: Vec::new(),
    };
    let mut all: Vec<Seen> = outcome.trace.each().map(seen).collect();
    let frame = |all: &[Seen], t_us: u64| all.binary_search_by_key(&t_us, |seen| seen.t_us).ok();
    for truth in outcome.trace.each::<event::Truth>() {
        if let Some(at) = frame(&all, truth.t_us) {
            all[at].truth = Some(mm(truth.place));
        }
    }
    for contact in outcome.trace.each::<event::Contact>() {
        if let Some(at) = frame(&all, contact.t_us) {
            all[at].contacts.push(*contact);
        }
    }
    all
}

fn path() -> Result<Answer, Failure> {
    let outcome = rising(1)?;
    let (mut inside, mut all, mut step) = (Vec::new(), Vec::new(), 0.0_f64);
    let mut last: Option<f64> = None;
    for seen in frames(&outcome) {
        let (Some(truth), Some(contact)) = (seen.truth, seen.contacts.first()) else {
            continue;
        };
        let (x, y) = mm(contact.place);
        let off = (x - truth.0).hypot(y - truth.1);
        all.push(off * off);
        if truth.1.abs() <= f64::from(PITCH_MM) / 2.0 {
            inside.push(off * off);
            if let Some(last) = last {
                step = step.max((y - last).abs());
            }
            last = Some(y);
        }
    }
    let rmse = |v: &[f64]| (v.iter().sum::<f64>() / v.len().max(1) as f64).sqrt();
    let (inner, whole) = (rmse(&inside), rmse(&all));
    let even = 2.0 * EDGE_MM / 108.0;
    Ok(Answer::new(
        Mark::new(inner <= 0.1 * f64::from(PITCH_MM), || {
            format!(
                "threshold and edge pull the centroid: {inner:.2} mm between the inner taxels, {whole:.2} mm from edge to edge"
            )
        }),
        format!(
            "{inner:.2} mm RMSE between the inner taxels, {whole:.2} mm from edge to edge. The largest step is {step:.2} mm, an even one {even:.2} mm."
        ),
        json!({ "rmse_inside_mm": inner, "rmse_mm": whole, "largest_step_mm": step }),
    ))
}

fn rug() -> Result<Answer, Failure> {
    let outcome = rising(1)?;
    let contacts = outcome.trace.each::<event::Contact>();
    let found = contacts.map(|c| (c.intensity_milli, c.level));
    let weakest = found.clone().min().unwrap_or_default();
    let levels = found.map(|(_, level)| level).max().unwrap_or(0);
    let counts = f64::from(weakest.0) * 1e-3;
    Ok(Answer::new(
        Mark::new(weakest.1 == 1, || {
            "the weakest contact has another level".into()
        }),
        format!(
            "The weakest contact, {counts:.0} counts, has level {}; the highest level is {levels}.",
            weakest.1
        ),
        json!({ "weakest_counts": counts, "weakest_level": weakest.1, "levels": levels }),
    ))
}

/// Most taxels in contact, and the sphere's height then, mm.
fn most(outcome: &Outcome) -> (u16, f64) {
    let all = frames(outcome);
    let fuller = all.iter().filter(|seen| seen.truth.is_some()).rev();
    let fullest = fuller.max_by_key(|seen| seen.in_contact);
    let y = fullest.and_then(|seen| seen.truth).map_or(0.0, |t| t.1);
    (fullest.map_or(0, |seen| seen.in_contact), y)
}

/// Height from which the sphere counts as at the top border, mm.
fn border_mm() -> f64 {
    EDGE_MM - f64::from(PITCH_MM) / 2.0
}

/// Most taxels in contact and the sphere's height then, for an even roll of 0.05 N that ends with a press of so many
/// newtons at the top, and a threshold of (4.3) and so many counts.
fn pressed(newtons: f64, counts: f64) -> Result<(u16, f64), Failure> {
    let mut setup = roll(1, 0.05, 0.0)?;
    let scene = &mut setup.scene.value;
    scene.threshold_margin = counts;
    if let Some(mut press) = scene.touches.first().cloned() {
        (press.start_s, press.end_s, press.ramp_s) = (2.1, 2.35, 0.05);
        press.path.kind = PathKind::Hold;
        press.path.points_mm = vec![[0.0, EDGE_MM]];
        press.force_n.mean = newtons;
        scene.touches.push(press);
    }
    Ok(most(&run(&setup)?))
}

fn fullest() -> Result<Answer, Failure> {
    let (count, y) = most(&rising(1)?);
    let is_printed = |(count, y): (u16, f64)| count == 12 && y >= border_mm();
    let (mut sweep, mut printed, mut plain) = (Vec::new(), Vec::new(), Vec::new());
    for newtons in [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0] {
        for counts in [0.0, 2.0, 5.0, 10.0, 20.0] {
            let found = pressed(newtons, counts)?;
            sweep.push((newtons, counts, found));
            if is_printed(found) {
                printed.push(format!("{newtons} N with {counts} counts"));
            }
            if counts < 1.0 {
                plain.push(format!("{newtons} N {} at {:.1} mm", found.0, found.1));
            }
        }
    }
    let mark = match (is_printed((count, y)), printed.as_slice()) {
        (true, _) => Mark::Agrees,
        (false, []) => Mark::Unexplained,
        (false, some) => Mark::Differs(format!(
            "force over the path and threshold: neither is printed. An even roll of 0.05 N that ends with a press at the top gives it for {}. With no count more than (4.3): {}",
            some.join(", "),
            plain.join(", ")
        )),
    };
    Ok(Answer::new(
        mark,
        format!(
            "At most {count} taxels, with the sphere at {y:.1} mm of {EDGE_MM} mm; {} of {} other rolls give 12 at the top.",
            printed.len(),
            sweep.len()
        ),
        json!({ "most": count, "at_mm": y, "sweep": sweep }),
    ))
}

fn speed() -> Result<Answer, Failure> {
    let mut slower = Vec::new();
    for kc in CLUSTERS {
        if hertz(&rising(kc)?) < 100.0 {
            slower.push(kc);
        }
    }
    let found = match slower.is_empty() {
        true => "Faster than 100 Hz for every K_C, 16 too.".to_owned(),
        false => format!("Slower than 100 Hz for K_C of {slower:?}."),
    };
    let mark = match slower == [16] {
        true => Mark::Agrees,
        false => Mark::Unexplained,
    };
    Ok(Answer::new(mark, found, json!({ "slower_at": slower })))
}

fn cover() -> Result<Answer, Failure> {
    let mut found = Vec::new();
    let mut count = 0;
    for kc in CLUSTERS {
        let all = frames(&rising(kc)?);
        let fullest = all.iter().max_by_key(|seen| seen.in_contact);
        found.push(fullest.map_or(0, |seen| seen.contacts.len()));
        count = fullest.map_or(0, |seen| seen.in_contact);
    }
    let expected = CLUSTERS.map(|kc| kc.min(u32::from(count)) as usize);
    Ok(Answer::new(
        Mark::new(found == expected, || "clusters are left out".into()),
        format!("{found:?} contacts for K_C of {CLUSTERS:?}, with {count} taxels in contact."),
        json!({ "clusters": CLUSTERS, "contacts": found, "taxels_in_contact": count }),
    ))
}
