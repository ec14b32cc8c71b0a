//! The texture encoder of the model that ships: exact windows one by one, a sample apart, at onsets and for fifteen
//! modules, and ONNX Runtime on the exported model.

mod ground;
mod peers;
mod pulses;

use std::sync::Arc;
use std::time::Duration;

use palpate_core::texture::{Encoder, Ends, Stream};
use palpate_core::units;
use palpate_core::vector::Vectors;
use palpate_run::Failure;
use palpate_tests::seeded::stroke;

use crate::findings::Findings;
use crate::timing::{Race, Samples};
use ground::Ground;
use peers::Peer;

const ERROR: &str = "largest |dz|";
/// Modules of the hand.
const MODULES: usize = 15;
/// Nominal sample rate and onset asynchrony.
const SAMPLE: units::Duration = units::Duration::from_micros(10_000);
const SOA: units::Duration = units::Duration::from_micros(58_500);
/// Samples of a second.
const SECOND: usize = 100;
const COUNT: usize = 100;
/// Calls of a sample: a method finds its weights in the caches, as in a program that does nothing else, and as the
/// peer in its own process does.
const CALLS: usize = 8;
const BUDGET: Duration = Duration::from_secs(4);
/// Turns of ours and the peer's: a shared machine's clock changes from one second to the next.
const TURNS: usize = 5;

/// An encoder with what is known of it.
struct Method {
    name: &'static str,
    encoder: Arc<Encoder>,
    error: (f64, &'static str),
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
            let encoder = ground.model.encoder_on(vectors)?;
            Ok(Method {
                name,
                error: (ground.off_by(&encoder), ERROR),
                encoder: Arc::new(encoder),
            })
        })
        .collect()
}

/// Measures everything.
///
/// # Errors
/// A model that is refused; peers that are named and fail.
pub fn measure() -> Result<Findings, Failure> {
    let mut found = Findings::new("texture");
    let ground = Ground::new()?;
    let methods = exact(&ground)?;
    let (low, high) = ground.range();
    found.words.push(format!(
        "On {} vectors. Errors are over {} windows of emulated strokes that training never saw; their z run from {low:.2} to {high:.2}.",
        Vectors::widest().name(),
        ground.windows.len()
    ));
    for (case, samples) in [
        ("window", windows(&ground, &methods)),
        ("hop", hops(&ground, &methods)),
    ] {
        for (method, samples) in methods.iter().zip(&samples) {
            let us = samples.median() / CALLS as f64;
            found.row(case, method.name, method.error, us);
            if case == "hop" && method.name == "exact" {
                found.target("a hop", us, 480.0);
            }
        }
    }
    let exact = &methods[0];
    let [demand, every] = seconds(&ground, exact).map(|s| s.median());
    let second = "a second, z at every onset (58.5 ms)";
    found.row(second, "default", exact.error, demand);
    found.row(second, "exact, every hop", exact.error, every);
    let times = every / demand;
    found.words.push(format!(
        "z at every onset at least 4 times cheaper than at every hop: {times:.1} times, {}.",
        met(times >= 4.0)
    ));
    let each = fifteen(&ground, exact).median() / MODULES as f64;
    found.row("hop, 15 modules, for each", "exact", exact.error, each);
    found.target("a hop of each of fifteen modules", each, 667.0);
    let period = pulses::measure(&mut found)?;
    found.target("pulses of a PWM period", period, 2.0);
    beside_peers(&mut found, &ground, &methods)?;
    Ok(found)
}

const fn met(yes: bool) -> &'static str {
    if yes { "met" } else { "MISSED" }
}

/// [`CALLS`] windows per call of a method.
fn windows(ground: &Ground, methods: &[Method]) -> Vec<Samples> {
    let mut race = Race::default();
    for method in methods {
        let (mut room, mut turn) = (method.encoder.room(), 0);
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

/// [`CALLS`] hops per call of a method.
fn hops(ground: &Ground, methods: &[Method]) -> Vec<Samples> {
    let mut race = Race::default();
    for method in methods {
        let mut hop = running(&ground.values, &method.encoder, 1, Ends::Every);
        race.enter(move || (0..CALLS).map(|_| hop()).sum::<usize>());
    }
    race.run(COUNT, BUDGET)
}

/// A second of signal: windows in flight for onsets alone, and one at every hop.
fn seconds(ground: &Ground, exact: &Method) -> [Samples; 2] {
    let mut race = Race::default();
    let onsets = Ends::Onsets {
        sample: SAMPLE,
        every: SOA,
    };
    for ends in [onsets, Ends::Every] {
        let mut push = running(&ground.values, &exact.encoder, 1, ends);
        race.enter(move || (0..SECOND).map(|_| push()).sum::<usize>());
    }
    let mut samples = race.run(COUNT / 4, BUDGET).into_iter();
    [(); 2].map(|()| samples.next().unwrap_or_default())
}

/// One hop of fifteen modules.
fn fifteen(ground: &Ground, exact: &Method) -> Samples {
    let values = stroke(2, 128, ground.model.features() * MODULES);
    let mut race = Race::default();
    race.enter(running(&values, &exact.encoder, MODULES, Ends::Every));
    let samples = race.run(COUNT / 4, BUDGET).into_iter().next();
    samples.unwrap_or_default()
}

/// Ours and the peer by turns, with the ratio of each turn; nothing where no peers are named.
fn beside_peers(found: &mut Findings, ground: &Ground, exact: &[Method]) -> Result<(), Failure> {
    let aims = [("window", 1.3), ("hop", 2.0)];
    let mut times = vec![[(); 2].map(|()| Samples::default()); exact.len()];
    let [mut single, mut batch] = [(); 2].map(|()| Samples::default());
    let mut last: Option<Peer> = None;
    for _ in 0..TURNS {
        let Some(peer) = peers::measure(ground)? else {
            return Ok(());
        };
        let ours = [windows(ground, exact), hops(ground, exact)];
        for (m, times) in times.iter_mut().enumerate() {
            for (times, ours) in times.iter_mut().zip(&ours) {
                times.push(peer.window_us * CALLS as f64 / ours[m].median());
            }
        }
        single.push(peer.window_us);
        batch.push(peer.batch_us);
        last = Some(peer);
    }
    let Some(Peer { name, error, .. }) = last else {
        return Ok(());
    };
    for (method, times) in exact.iter().zip(&times) {
        for ((case, aim), times) in aims.into_iter().zip(times) {
            let (median, low, high) = (times.median(), times.quantile(0.0), times.quantile(1.0));
            found.words.push(format!(
                "A {case} ({}) at least {aim} times faster than {name}: {median:.2} times ({low:.2} to {high:.2}), {}.",
                method.name,
                met(median >= aim)
            ));
        }
    }
    let error = (error, ERROR);
    // ONNX Runtime computes a whole window at each hop.
    for (case, _) in aims {
        found.peer(case, &name, error, single.median());
    }
    let batched = format!("{name}, batch");
    found.peer("window", &batched, error, batch.median());
    Ok(())
}
