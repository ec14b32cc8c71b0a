//! The texture encoder of the model that ships: exact windows one by one, a sample apart, on demand and for fifteen
//! modules, approximations beside them, and ONNX Runtime on the exported model.

mod ground;
mod peers;
mod pulses;

use std::sync::Arc;
use std::time::Duration;

use palpate_core::texture::{Encoder, Ends, Stateful, Stream, Weights};
use palpate_core::units;
use palpate_core::vector::Vectors;

use crate::failure::Failure;
use crate::texture::seeded::stroke;

use super::plot::{Mark, Plot, Series};
use super::timing::{Race, Samples};
use super::{Findings, Row};
use ground::Ground;

const FAMILY: &str = "texture";
const ERROR: &str = "largest |dz|";
/// Modules of the hand.
const MODULES: usize = 15;
/// Nominal sample rate and onset asynchrony.
const SAMPLE: units::Duration = units::Duration::from_micros(10_000);
const SOA: units::Duration = units::Duration::from_micros(58_500);
/// Samples of a second.
const SECOND: usize = 100;
const COUNT: usize = 100;
/// Calls of a sample: a method finds its weights in the caches, as a program that does nothing else would, and as
/// the peer in its own process does.
const CALLS: usize = 8;
const BUDGET: Duration = Duration::from_secs(4);
/// Turns of ours and the peer's: a shared machine's clock changes from one second to the next.
const TURNS: usize = 5;

/// An encoder with what is told of it.
struct Method {
    name: String,
    encoder: Arc<Encoder>,
    error: f64,
}

impl Method {
    fn new(ground: &Ground, name: String, encoder: Encoder) -> Self {
        Self {
            name,
            error: ground.off_by(&encoder),
            encoder: Arc::new(encoder),
        }
    }
}

/// The exact encoder on the widest vectors and, where those are wider, on 256 bits: the targets are stated for AVX2.
fn exact(ground: &Ground) -> Result<Vec<Method>, Failure> {
    let mut all = vec![("exact", Vectors::widest())];
    let narrower = Vectors::of_256_bits();
    if narrower.name() != Vectors::widest().name() {
        all.push(("exact, AVX2", narrower));
    }
    all.into_iter()
        .map(|(name, vectors)| {
            let encoder = ground.model.encoder_on(vectors, Weights::Exact)?;
            Ok(Method::new(ground, name.into(), encoder))
        })
        .collect()
}

/// Approximations.
fn approximate(ground: &Ground) -> Result<Vec<Method>, Failure> {
    let exact = ground.model.encoder(Weights::Exact)?;
    let half = ground.model.encoder(Weights::Half)?;
    let mut methods = vec![("half weights".to_owned(), half)];
    for steps in [75, 50, 25, 10] {
        methods.push((
            format!("last {steps} samples"),
            exact.clone().with_steps(steps),
        ));
    }
    let method = |(name, encoder)| Method::new(ground, name, encoder);
    Ok(methods.into_iter().map(method).collect())
}

/// Measures everything.
///
/// # Errors
/// A model that is refused; peers that are named and fail.
pub fn measure() -> Result<Findings, Failure> {
    let ground = Ground::new()?;
    let mut methods = exact(&ground)?;
    let exact_ones = methods.len();
    methods.extend(approximate(&ground)?);
    let mut rows = Vec::new();
    let mut add = |case: &str, method: &str, error: f64, samples: &Samples, per: f64| {
        rows.push(Row {
            family: FAMILY,
            case: case.into(),
            method: method.into(),
            error,
            error_unit: ERROR,
            median_us: samples.median() / per,
            peer: false,
        });
    };

    let windows = whole_windows(&ground, &methods);
    for (method, samples) in methods.iter().zip(&windows) {
        add("window", &method.name, method.error, samples, CALLS as f64);
    }
    let exact = &methods[0];
    let stateful = ground.off_stateful(&exact.encoder);
    let hops = hops(&ground, &methods);
    for (method, samples) in methods.iter().zip(&hops) {
        add("hop", &method.name, method.error, samples, CALLS as f64);
    }
    if let Some(samples) = hops.last() {
        add("hop", "stateful", stateful, samples, CALLS as f64);
    }
    let [demand, at_once, every] = seconds(&ground, exact);
    let second = "a second, z at every onset (58.5 ms)";
    add(second, "exact", exact.error, &demand, 1.0);
    add(second, "exact, at once", exact.error, &at_once, 1.0);
    add(second, "exact, every hop", exact.error, &every, 1.0);
    let together = fifteen(&ground, exact);
    add(
        "hop, 15 modules, for each",
        "exact",
        exact.error,
        &together,
        MODULES as f64,
    );

    rows.extend(pulses::measure()?);
    let peers = beside_peers(&ground, &methods[..exact_ones])?;
    let (low, high) = ground.range();
    let mut words = vec![format!(
        "On {} vectors. Errors are over {} windows of emulated strokes that training never saw; their z run from {low:.2} to {high:.2}.",
        Vectors::widest().name(),
        ground.windows.len()
    )];
    words.extend(targets(&rows));
    if let Some(Peer {
        rows: [single, batch],
        times,
    }) = peers
    {
        for (method, times) in methods.iter().zip(&times) {
            for ((case, aim), times) in [("window", 1.3), ("hop", 2.0)].into_iter().zip(times) {
                words.push(against((case, aim), &method.name, &single.method, times));
            }
        }
        for (case, peer) in [("window", &single), ("window", &batch), ("hop", &single)] {
            rows.push(Row {
                family: FAMILY,
                case: case.into(),
                error_unit: ERROR,
                peer: true,
                ..peer.clone()
            });
        }
    }
    let plots = ["window", "hop"].map(|case| plot(case, &rows)).to_vec();
    Ok(Findings {
        rows,
        plots,
        figures: Vec::new(),
        words,
    })
}

fn whole_windows(ground: &Ground, methods: &[Method]) -> Vec<Samples> {
    let mut race = Race::default();
    for method in methods {
        let (mut room, mut turn) = (method.encoder.room(1), 0);
        race.enter(move || {
            for _ in 0..CALLS {
                turn += 1;
                let window = &ground.windows[turn % ground.windows.len()];
                std::hint::black_box(method.encoder.encode(&mut room, window).map(<[f32]>::len))
                    .ok();
            }
        });
    }
    race.run(COUNT, BUDGET)
}

/// A stream that has all its windows in flight, and what pushes the next sample.
fn running<'a>(
    values: &'a [f32],
    encoder: &Arc<Encoder>,
    modules: usize,
    ends: Ends,
) -> impl FnMut() -> usize + 'a {
    let (row, window) = (encoder.features() * modules, encoder.window());
    let mut stream = Stream::new(encoder.clone(), modules);
    let rows = values.len() / row;
    let mut n = 0;
    let mut push = move || {
        let sample = &values[(n % rows) * row..][..row];
        let begin = ends.begins(n as u64, window);
        n += 1;
        stream
            .push(sample, begin)
            .map_or(0, |z| z.map_or(0, <[f32]>::len))
    };
    for _ in 0..window {
        push();
    }
    push
}

/// Every method, and a state that is never begun anew.
fn hops(ground: &Ground, methods: &[Method]) -> Vec<Samples> {
    let mut race = Race::default();
    for method in methods {
        let mut hop = running(&ground.values, &method.encoder, 1, Ends::Every);
        race.enter(move || (0..CALLS).map(|_| hop()).sum::<usize>());
    }
    let mut state = Stateful::new(methods[0].encoder.clone());
    let row = ground.model.features();
    let mut step = move || state.push(&ground.values[..row]).map_or(0, <[f32]>::len);
    race.enter(move || (0..CALLS).map(|_| step()).sum::<usize>());
    race.run(COUNT, BUDGET)
}

/// A second of signal: on demand, at once where asked, and with every hop.
fn seconds(ground: &Ground, exact: &Method) -> [Samples; 3] {
    let mut race = Race::default();
    let onsets = Ends::Onsets {
        sample: SAMPLE,
        every: SOA,
    };
    let values = &ground.values;
    let mut demand = running(values, &exact.encoder, 1, onsets);
    race.enter(move || (0..SECOND).map(|_| demand()).sum::<usize>());
    let mut stream = Stream::new(exact.encoder.clone(), 1);
    let (mut room, row) = (exact.encoder.room(1), exact.encoder.features());
    let (rows, mut n) = (values.len() / row, 0);
    let mut at_once = move || {
        let taken = stream
            .push(&values[(n % rows) * row..][..row], false)
            .is_ok();
        n += 1;
        let asked = onsets.asked(n as u64 - 1);
        usize::from(taken)
            + if asked {
                stream.newest(&mut room).map_or(0, <[f32]>::len)
            } else {
                0
            }
    };
    race.enter(move || (0..SECOND).map(|_| at_once()).sum::<usize>());
    let mut every = running(values, &exact.encoder, 1, Ends::Every);
    race.enter(move || (0..SECOND).map(|_| every()).sum::<usize>());
    let mut samples = race.run(COUNT / 4, BUDGET).into_iter();
    [(); 3].map(|()| samples.next().unwrap_or_default())
}

/// What the peer takes.
struct Peer {
    /// One window at a time, and all in a batch.
    rows: [Row; 2],
    /// How many times faster each of ours is, turn by turn: a window, and a hop.
    times: Vec<[Samples; 2]>,
}

/// The methods in `exact` and the peer by turns; none where no peers are named.
fn beside_peers(ground: &Ground, exact: &[Method]) -> Result<Option<Peer>, Failure> {
    let (mut rows, mut medians) = (None, [(); 2].map(|()| Samples::default()));
    let mut times: Vec<_> = exact
        .iter()
        .map(|_| [(); 2].map(|()| Samples::default()))
        .collect();
    for _ in 0..TURNS {
        let Some(peers) = peers::measure(ground)? else {
            return Ok(None);
        };
        let ours = [whole_windows(ground, exact), hops(ground, exact)];
        for (m, times) in times.iter_mut().enumerate() {
            for (times, ours) in times.iter_mut().zip(&ours) {
                times.push(peers[0].median_us * CALLS as f64 / ours[m].median());
            }
        }
        for (median, row) in medians.iter_mut().zip(&peers) {
            median.push(row.median_us);
        }
        rows = Some(peers);
    }
    Ok(rows.map(|mut rows| {
        for (row, median) in rows.iter_mut().zip(&medians) {
            row.median_us = median.median();
        }
        Peer { rows, times }
    }))
}

/// One hop of fifteen modules.
fn fifteen(ground: &Ground, exact: &Method) -> Samples {
    let values = stroke(2, 128, ground.model.features() * MODULES);
    let mut race = Race::default();
    race.enter(running(&values, &exact.encoder, MODULES, Ends::Every));
    race.run(COUNT / 4, BUDGET)
        .into_iter()
        .next()
        .unwrap_or_default()
}

fn time(rows: &[Row], case: &str, method: &str) -> Option<f64> {
    let mut all = rows.iter();
    all.find(|r| r.case.starts_with(case) && r.method == method)
        .map(|r| r.median_us)
}

/// The targets that need no peer.
fn targets(rows: &[Row]) -> Vec<String> {
    let of = |case, method| time(rows, case, method).unwrap_or(f64::NAN);
    let (demand, every) = (of("a second", "exact"), of("a second", "exact, every hop"));
    let met = |yes| if yes { "met" } else { "missed" };
    let hop = of("hop", "exact");
    let each = of("hop, 15 modules", "exact");
    let period = of(pulses::CASE, "Bernoulli");
    vec![
        format!(
            "A hop in at most 480 us: {hop:.0} us, {}.",
            met(hop <= 480.0)
        ),
        format!(
            "At every onset at least 4 times less than with every hop: {:.1} times, {}.",
            every / demand,
            met(every >= 4.0 * demand)
        ),
        format!(
            "Fifteen modules at 100 Hz on one core (below 667 us a hop each): {each:.0} us, {}.",
            met(each < 667.0)
        ),
        format!(
            "Pulses in at most 2 us a PWM period: {period:.2} us, {}.",
            met(period <= 2.0)
        ),
    ]
}

/// A target against a peer: how many times faster, turn by turn.
fn against((case, aim): (&str, f64), method: &str, peer: &str, times: &Samples) -> String {
    let (median, low, high) = (times.median(), times.quantile(0.0), times.quantile(1.0));
    let met = if median >= aim { "met" } else { "missed" };
    format!(
        "A {case} ({method}) at least {aim} times faster than {peer}: {median:.2} times ({low:.2} to {high:.2}), {met}."
    )
}

fn plot(case: &str, rows: &[Row]) -> Plot {
    let of_case = rows.iter().filter(|r| r.case == case);
    let series = |row: &Row| Series {
        name: row.method.clone(),
        points: vec![(row.median_us, row.error)],
        mark: if row.peer { Mark::Swept } else { Mark::Ours },
    };
    let title = match case {
        "window" => "Texture encoder: one window",
        _ => "Texture encoder: z of every window, a sample apart",
    };
    let mut plot = Plot::work_precision(
        case,
        title,
        "largest error of z",
        of_case.map(series).collect(),
    );
    if case == "hop" {
        plot.words
            .push_str(" ONNX Runtime computes a whole window at each hop.");
    }
    plot
}
