//! A generator of truth: skins that drift, warm up, keep a remainder of touches, fall silent, and have bad taxels, held
//! against the same touches without any of that.

#![allow(clippy::unwrap_used, clippy::needless_range_loop)]

use std::collections::HashMap;

use palpate_core::contact::{Compressor, Settings};
use palpate_core::random::RandomStream;
use palpate_core::skin::{Axes, BaselineSettings, HealthSettings, Scan, Sense, ThresholdRule};
use palpate_core::units::{Duration, Instant, Point};

#[path = "rest/before.rs"]
mod before;
#[path = "rest/skins.rs"]
mod skins;

use before::before;
use skins::{Skin, skins};

const RATE_HZ: usize = 100;
const FRAMES: usize = 40 * RATE_HZ;

/// What disturbs a skin.
#[derive(Clone, Copy, Debug, Default)]
struct Trouble {
    drift: f64,
    warmth: f64,
    hysteresis: f64,
    gaps: bool,
    early: bool,
    glitches: f64,
    /// What becomes of one taxel.
    bad: Option<Bad>,
    /// True if drift, warmth, remainders and glitches are known to a count, and taken off the readings.
    known: bool,
    /// True if the noise is another draw than that of the undisturbed skin.
    redrawn: bool,
}

impl Trouble {
    /// The same skin undisturbed: a taxel that is left out is missing without other trouble too.
    fn clean(self) -> Self {
        Self {
            bad: self.bad.filter(|bad| *bad != Bad::Worn),
            ..Self::default()
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Bad {
    Zero,
    Full,
    Stuck,
    Worn,
}

/// One touch: frames, way, largest counts, width.
struct Touch {
    from: usize,
    to: usize,
    ramp: usize,
    way: [Point; 2],
    force: f64,
    width: f64,
}

impl Touch {
    fn at(&self, frame: usize) -> Option<(Point, f64)> {
        if !(self.from..self.to).contains(&frame) {
            return None;
        }
        let edge = (frame - self.from + 1).min(self.to - frame);
        let part = (edge as f64 / self.ramp as f64).min(1.0);
        let way = (frame - self.from) as f32 / (self.to - self.from) as f32;
        let [a, b] = self.way;
        let place = Point::new(a.x + way * (b.x - a.x), a.y + way * (b.y - a.y));
        Some((place, part * self.force))
    }
}

fn touches(skin: &Skin, early: bool, random: &mut RandomStream) -> Vec<Touch> {
    let module = &skin.layout.modules()[0];
    let points = module.points();
    let half = |of: fn(&Point) -> f32| points.iter().map(of).fold(0.0, f32::max);
    let (w, h) = (half(|p| p.x), half(|p| p.y));
    let pitch = f64::from((points[1].x - points[0].x).abs());
    let mut all = Vec::new();
    let mut from = match early {
        true => (random.uniform() * 60.0) as usize,
        false => 100 + (random.uniform() * 100.0) as usize,
    };
    while from + 100 < FRAMES {
        let length = 80 + (random.uniform() * random.uniform() * 1200.0) as usize;
        let to = (from + length).min(FRAMES - 60);
        let mut place = || {
            let x = (random.uniform() * 1.6 - 0.8) as f32 * w;
            Point::new(x, (random.uniform() * 1.6 - 0.8) as f32 * h)
        };
        let (a, other) = (place(), place());
        let b = if random.uniform() < 0.5 { a } else { other };
        all.push(Touch {
            from,
            to,
            ramp: 1 + (random.uniform() * 8.0) as usize,
            way: [a, b],
            force: skin.force[0] * f64::powf(skin.force[1] / skin.force[0], random.uniform()),
            width: pitch * (0.8 + 0.5 * random.uniform()),
        });
        from = to + 60 + (random.uniform() * 300.0) as usize;
    }
    all
}

struct Frame {
    at: Instant,
    counts: Vec<[u16; 3]>,
    /// Counts that the touch adds to the most pressed taxel.
    pressed: f64,
}

/// The frames of a skin under trouble.
fn frames(skin: &Skin, touches: &[Touch], trouble: Trouble, seed: u64) -> Vec<Frame> {
    let mut random = RandomStream::new(seed, "trouble");
    let mut noise = RandomStream::new(seed, "noise");
    let points = skin.layout.modules()[0].points();
    let single = skin.layout.modules()[0].axes() == 1;
    let n = points.len();
    let own: Vec<[f64; 3]> = (0..n)
        .map(|_| {
            [0, 1, 2].map(|a| {
                if skin.rest[a] == 0.0 {
                    0.0
                } else {
                    skin.rest[a] + 300.0 * (noise.uniform() - 0.5) * skin.most / 65_535.0
                }
            })
        })
        .collect();
    if trouble.redrawn {
        noise = RandomStream::new(seed, "another noise");
    }
    let gain: Vec<f64> = (0..n).map(|_| 0.65 + 0.6 * random.uniform()).collect();
    let scale = if skin.most < 256.0 { 0.1 } else { 1.0 };
    let sign = if random.uniform() < 0.5 && !single {
        -1.0
    } else {
        1.0
    };
    let warm_at = FRAMES / 4 + (random.uniform() * FRAMES as f64 / 2.0) as usize;
    let bad_at = (random.uniform() * FRAMES as f64 / 2.0) as usize;
    let bad = (random.uniform() * n as f64) as usize;
    let mut stuck = None;
    let mut left = vec![0.0f64; n];
    let mut late = 0u64;
    let mut all = Vec::new();
    for k in 0..FRAMES {
        if trouble.gaps && k > 200 && random.uniform() < 0.001 {
            late += 200_000 + (random.uniform() * 3e6) as u64;
        }
        let touch = touches.iter().find_map(|t| t.at(k).map(|at| (t, at)));
        let t = k as f64 / RATE_HZ as f64 + late as f64 * 1e-6;
        let warm = match k.checked_sub(warm_at) {
            Some(k) => trouble.warmth * (1.0 - f64::exp(-(k as f64) / (4.0 * RATE_HZ as f64))),
            None => 0.0,
        };
        let common = sign * scale * (trouble.drift * t + warm);
        let glitch = (random.uniform() < trouble.glitches).then(|| {
            let which = (random.uniform() * n as f64) as usize;
            (which, scale * (200.0 + 4000.0 * random.uniform()) * sign)
        });
        let mut pressed = 0.0f64;
        let mut counts: Vec<[u16; 3]> = Vec::with_capacity(n);
        for i in 0..n {
            let press = touch.map_or(0.0, |(t, (place, force))| {
                let (dx, dy) = (
                    f64::from(points[i].x - place.x),
                    f64::from(points[i].y - place.y),
                );
                force * f64::exp(-(dx * dx + dy * dy) / (2.0 * t.width * t.width))
            });
            pressed = pressed.max(press);
            // What stays after a touch, and goes within two seconds.
            left[i] = (left[i] * (1.0 - 0.5 / RATE_HZ as f64)).max(trouble.hysteresis * press);
            let jump = glitch.filter(|(which, _)| *which == i);
            let jump = jump.map_or(0.0, |(_, jump)| jump);
            let mut reading = [0, 1, 2].map(|axis| {
                let (touch, more) = match axis {
                    2 => (press, (left[i] - press).max(0.0) + gain[i] * common + jump),
                    _ => (0.15 * press, 0.3 * gain[i] * common),
                };
                let off = if trouble.known { more.round() } else { 0.0 };
                let reading = own[i][axis] + touch + more + skin.noise * noise.normal();
                (reading.round() - off).clamp(0.0, skin.most) as u16
            });
            if single {
                (reading[0], reading[1]) = (0, 0);
            }
            if i == bad && k >= bad_at {
                match trouble.bad {
                    Some(Bad::Zero) => reading = [0; 3],
                    Some(Bad::Full) => reading[2] = u16::MAX,
                    Some(Bad::Stuck) => reading = *stuck.get_or_insert(reading),
                    Some(Bad::Worn) => {
                        reading[2] =
                            reading[2].saturating_add((6.0 * scale * noise.normal().abs()) as u16);
                    }
                    None => {}
                }
            }
            counts.push(reading);
        }
        let at = Instant::from_micros((t * 1e6) as u64);
        all.push(Frame {
            at,
            counts,
            pressed,
        });
    }
    all
}

/// The first contact of a frame: its place, and the taxels in contact.
type Found = Option<(Point, Vec<u32>)>;

/// The first contact of every frame, and how many identities there were.
fn contacts(skin: &Skin, frames: &[Frame]) -> (Vec<Found>, usize) {
    let settings = BaselineSettings {
        reference_frames: 10,
        fault_sigmas: None,
        threshold: ThresholdRule::PerTaxel {
            sigmas: 6.0,
            floor: skin.floor,
        },
        axes: Axes::XYZ,
        drift: Some(Duration::from_millis(5000)),
    };
    let mut sense = Sense::new(&skin.layout, settings, HealthSettings::default()).unwrap();
    let mut compressor = Compressor::new(&skin.layout, Settings::default()).unwrap();
    let mut scan = Scan::new(&skin.layout);
    let mut ids = Vec::new();
    let found = frames.iter().map(|frame| {
        scan.load(frame.at, &frame.counts).unwrap();
        sense.watch(&scan, 0, &skin.layout, &mut |_, _| ());
        sense.frame(&scan).unwrap()?;
        let contact = compressor
            .compress(sense.relative())
            .unwrap()
            .first()
            .copied()?;
        if !ids.contains(&contact.id) {
            ids.push(contact.id);
        }
        Some((contact.place, sense.relative().contacts().to_vec()))
    });
    let found = found.collect();
    (found, ids.len())
}

#[derive(Clone, Copy, Debug, Default)]
struct Score {
    touched: usize,
    /// Now, and as the rule was before.
    missed: [usize; 2],
    free: usize,
    invented: [usize; 2],
    places: usize,
    squares: f64,
    /// Places, and their squares, of frames in which the same taxels are in contact as without disturbance.
    alike: usize,
    alike_squares: f64,
    largest: f64,
    ids: usize,
    touches: usize,
}

impl Score {
    fn share(part: usize, of: usize) -> f64 {
        100.0 * part as f64 / of.max(1) as f64
    }

    fn rms(&self) -> f64 {
        (self.squares / self.places.max(1) as f64).sqrt()
    }

    fn alike_rms(&self) -> f64 {
        (self.alike_squares / self.alike.max(1) as f64).sqrt()
    }

    fn line(&self) -> String {
        let missed = self.missed.map(|n| Self::share(n, self.touched));
        let invented = self.invented.map(|n| Self::share(n, self.free));
        format!(
            "missed {:6.2} % (before {:6.2} %), invented {:6.2} % (before {:6.2} %), places {:.3} mm rms, {:.2} mm most; {:.3} mm with the same taxels, in {:.1} %; {} identities of {} touches",
            missed[0],
            missed[1],
            invented[0],
            invented[1],
            self.rms(),
            self.largest,
            self.alike_rms(),
            Self::share(self.alike, self.places),
            self.ids,
            self.touches
        )
    }
}

/// Contacts of a skin without trouble, by seed, early touch and bad taxel. Many kinds of trouble share them.
type Cleans = HashMap<(u64, bool, Option<Bad>), Vec<Found>>;

/// The score of one skin under trouble; that of the rule as it was before only where it is asked for.
fn score(
    skin: &Skin,
    trouble: Trouble,
    seeds: std::ops::Range<u64>,
    cleans: &mut Cleans,
    asks_before: bool,
) -> Score {
    let mut sum = Score::default();
    for seed in seeds {
        let touches = touches(skin, trouble.early, &mut RandomStream::new(seed, "touches"));
        let troubled = frames(skin, &touches, trouble, seed);
        let (found, ids) = contacts(skin, &troubled);
        let old = match asks_before {
            true => before(skin, &troubled),
            false => vec![None; troubled.len()],
        };
        let clean = trouble.clean();
        let key = (seed, trouble.early, clean.bad);
        let find = || contacts(skin, &frames(skin, &touches, clean, seed)).0;
        let clean = cleans.entry(key).or_insert_with(find);
        // Where a touch was there from the first frames on, nothing can be known before it ends.
        let known = match touches.first() {
            Some(first) if first.from < 10 => first.to,
            _ => 10,
        };
        for (k, frame) in troubled.iter().enumerate().skip(known) {
            let clearly = f64::from(skin.floor) * 2.5;
            if frame.pressed > clearly {
                sum.touched += 1;
                sum.missed[0] += usize::from(found[k].is_none());
                sum.missed[1] += usize::from(old[k].is_none());
            } else if frame.pressed == 0.0 {
                sum.free += 1;
                sum.invented[0] += usize::from(found[k].is_some());
                sum.invented[1] += usize::from(old[k].is_some());
            }
            let both = (&found[k], &clean[k]);
            if let (true, (Some((a, taxels)), Some((b, others)))) = (frame.pressed > clearly, both)
            {
                let off = f64::from((a.x - b.x).hypot(a.y - b.y));
                sum.places += 1;
                sum.squares += off * off;
                sum.largest = sum.largest.max(off);
                if taxels == others {
                    sum.alike += 1;
                    sum.alike_squares += off * off;
                }
            }
        }
        sum.ids += ids;
        sum.touches += touches.len();
    }
    sum
}

fn troubles() -> [(&'static str, Trouble); 14] {
    let with = |change: fn(&mut Trouble)| {
        let mut trouble = Trouble::default();
        change(&mut trouble);
        trouble
    };
    [
        ("none", with(|_| ())),
        ("drift 3", with(|t| t.drift = 3.3)),
        ("drift 10", with(|t| t.drift = 10.0)),
        ("drift 20", with(|t| t.drift = 20.0)),
        ("warmth 150", with(|t| t.warmth = 150.0)),
        ("hysteresis", with(|t| t.hysteresis = 0.05)),
        ("gaps", with(|t| (t.gaps, t.drift) = (true, 1.0))),
        ("early", with(|t| t.early = true)),
        ("glitches", with(|t| t.glitches = 0.005)),
        ("zero", with(|t| t.bad = Some(Bad::Zero))),
        ("full", with(|t| t.bad = Some(Bad::Full))),
        ("stuck", with(|t| t.bad = Some(Bad::Stuck))),
        ("worn", with(|t| t.bad = Some(Bad::Worn))),
        (
            "all",
            Trouble {
                drift: 5.0,
                warmth: 100.0,
                hysteresis: 0.05,
                gaps: true,
                early: true,
                glitches: 0.001,
                bad: Some(Bad::Full),
                known: false,
                redrawn: false,
            },
        ),
    ]
}

/// Seeds that the estimator's constants were not chosen by.
const SEEDS: std::ops::Range<u64> = 5000..5002;

#[test]
fn touches_are_found_as_if_nothing_disturbed_them() {
    for skin in skins() {
        let (mut sum, mut cleans) = (Score::default(), Cleans::new());
        for (name, trouble) in troubles() {
            let score = score(&skin, trouble, SEEDS, &mut cleans, true);
            println!("{:6} {:11} {}", skin.name, name, score.line());
            let missed = Score::share(score.missed[0], score.touched);
            let invented = Score::share(score.invented[0], score.free);
            assert!(missed < 2.0 && invented < 1.0, "{} {name}", skin.name);
            sum.touched += score.touched;
            sum.missed[0] += score.missed[0];
            sum.free += score.free;
            sum.invented[0] += score.invented[0];
            sum.alike += score.alike;
            sum.alike_squares += score.alike_squares;
        }
        let missed = Score::share(sum.missed[0], sum.touched);
        let invented = Score::share(sum.invented[0], sum.free);
        let name = skin.name;
        let alike = sum.alike_rms();
        println!(
            "{name:6} missed {missed:.2} %, invented {invented:.2} %, places {alike:.3} mm with the same taxels"
        );
        assert!(missed < 1.0 && invented < 1.0 && alike < 0.15, "{name}");
    }
}

/// Places of every kind of disturbance as docs/compression.md has them: over all frames, over those with the same taxels in
/// contact, and over all frames where every disturbance is known to a count. The last is the least that an estimator
/// leaves, since readings are whole counts. Before them, places of an undisturbed skin whose noise is drawn anew.
#[test]
fn places_differ_as_the_page_says() {
    const SEEDS: std::ops::Range<u64> = 7000..7010;
    let rows = [
        ("drift 3", "drift of 3.3 counts/s"),
        ("drift 10", "10 counts/s"),
        ("drift 20", "20 counts/s"),
        ("warmth 150", "a warm-up by 150 counts"),
        ("hysteresis", "a remainder of 5 %, gone within seconds"),
        ("all", "all at once, with gaps and a taxel at its end"),
    ];
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/compression.md");
    let page = std::fs::read_to_string(page).unwrap_or_default(); // a package of this crate has no page
    let stands = |row: &str| {
        println!("{row}");
        assert!(
            page.is_empty() || page.contains(row),
            "docs/compression.md: {row}"
        );
    };
    let mut cleans = skins().map(|skin| (skin, Cleans::new()));
    let redrawn = Trouble {
        redrawn: true,
        ..Trouble::default()
    };
    let cells = cleans.iter_mut().map(|(skin, cleans)| {
        let noise = score(skin, redrawn, SEEDS, cleans, false);
        format!(" {:.3} / {:.3} |", noise.rms(), noise.alike_rms())
    });
    stands(&format!(
        "| nothing but another draw of the noise |{}",
        cells.collect::<String>()
    ));
    for (kind, title) in rows {
        let trouble = troubles().into_iter().find(|(name, _)| *name == kind);
        let (_, trouble) = trouble.unwrap();
        let known = Trouble {
            known: true,
            ..trouble
        };
        let cells = cleans.iter_mut().map(|(skin, cleans)| {
            let [found, least] = [trouble, known].map(|t| score(skin, t, SEEDS, cleans, false));
            let [all, alike] = [found.rms(), found.alike_rms()];
            format!(" {all:.3} / {alike:.3} / {:.3} |", least.rms())
        });
        stands(&format!("| {title} |{}", cells.collect::<String>()));
    }
}
