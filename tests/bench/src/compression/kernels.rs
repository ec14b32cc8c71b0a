//! Clustering and levels alone: ours to the end and after two iterations, beside peers.

use std::time::Duration;

use palpate_core::contact::kmeans::{KMeans, Stop};
use palpate_core::contact::levels::LevelSolver;
use palpate_core::random::RandomStream;

use palpate_run::Failure;

use super::clouds::{Cloud, Errors, ROUND, wide};
use super::peers;
use super::textbook::{self, Draw};
use crate::findings::Findings;
use crate::plot::{Mark, Plot, Series};
use crate::timing::Race;

/// Points and clusters of every case.
const CASES: [(usize, usize); 5] = [(12, 4), (16, 8), (125, 4), (240, 8), (2000, 16)];
/// Kind of the error.
const ERROR: &str = "inertia over the best of 32 starts, less 1";
const SAMPLES: usize = 400;
const BUDGET: Duration = Duration::from_millis(1500);

/// Methods that find a frame's centroids.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Method {
    /// From the last frame's centroids, at most so many iterations.
    Warm(u32),
    /// K-means of the textbooks, from the last frame's centroids.
    Textbook,
}

impl Method {
    const ALL: [(&'static str, Self); 3] = [
        ("default", Self::Warm(32)),
        ("warm", Self::Warm(2)),
        ("textbook, warm", Self::Textbook),
    ];
}

/// A method with all it carries from frame to frame.
struct Contestant<'a> {
    method: Method,
    k: usize,
    round: &'a [Cloud],
    rows: Vec<Vec<(f32, f32, f32)>>,
    kmeans: KMeans,
    draw: Draw,
    centroids: Vec<(f64, f64)>,
    frame: usize,
}

impl<'a> Contestant<'a> {
    fn new(method: Method, k: usize, round: &'a [Cloud]) -> Self {
        let (n, mut stream) = (round[0].x.len(), RandomStream::new(1, "bench"));
        let mut kmeans = KMeans::new(n, k);
        kmeans.seed(round[0].points(), k, &mut stream);
        let rows = |c: &Cloud| (0..n).map(|i| (c.x[i], c.y[i], c.w[i])).collect::<Vec<_>>();
        let mut draw = Draw(1);
        let rows: Vec<_> = match method {
            Method::Textbook => round.iter().map(rows).collect(),
            Method::Warm(_) => Vec::new(),
        };
        let centroids = rows
            .first()
            .map(|rows| textbook::kmeans(rows, k, None, &mut draw));
        Self {
            method,
            k,
            round,
            kmeans,
            draw,
            centroids: centroids.unwrap_or_default(),
            rows,
            frame: 0,
        }
    }

    /// The next frame.
    fn step(&mut self) {
        let at = self.frame % ROUND;
        self.frame += 1;
        match self.method {
            Method::Warm(max_iterations) => {
                let stop = Stop {
                    tolerance: 1e-3,
                    max_iterations,
                };
                self.kmeans.solve(self.round[at].points(), stop);
            }
            Method::Textbook => {
                let start = Some(&self.centroids[..]);
                self.centroids = textbook::kmeans(&self.rows[at], self.k, start, &mut self.draw);
            }
        }
    }

    fn centroids(&self) -> Vec<(f64, f64)> {
        match self.method {
            Method::Textbook => self.centroids.clone(),
            Method::Warm(_) => wide(&self.kmeans),
        }
    }
}

/// Measures all cases; with peers where `PALPATE_PEERS` names a Python that has them.
///
/// # Errors
/// Peers that are asked for and do not answer.
pub fn measure(findings: &mut Findings) -> Result<(), Failure> {
    for (n, k) in CASES {
        let round = Cloud::round(n, k);
        let mut contestants: Vec<_> = Method::ALL
            .iter()
            .map(|(_, method)| Contestant::new(*method, k, &round))
            .collect();
        let mut race = Race::default();
        for contestant in &mut contestants {
            race.enter(|| contestant.step());
        }
        let samples = race.run(SAMPLES, BUDGET);

        // Once more round for the errors, from the state that the race has left.
        let mut errors = vec![Errors::default(); contestants.len()];
        let (mut best, mut starts) = (Vec::new(), Vec::new());
        for contestant in &mut contestants {
            while contestant.frame % ROUND != 0 {
                contestant.step();
            }
        }
        for cloud in &round {
            // Peers make two iterations from where the same of ours begin.
            starts.push(contestants[1].centroids());
            contestants.iter_mut().for_each(Contestant::step);
            let optimum = cloud.optimum(k, &contestants[0].centroids());
            best.push(optimum);
            for (errors, contestant) in errors.iter_mut().zip(&contestants) {
                errors.add(cloud, &contestant.centroids(), optimum);
            }
        }
        let ours = Method::ALL.iter().zip(errors.iter().zip(&samples));
        let ours = ours.map(|((name, method), (errors, samples))| {
            let peer = *method == Method::Textbook;
            ((*name).to_owned(), *errors, samples.median(), peer)
        });
        let peers = peers::measure(&round, &starts, &best)?;
        let peers = peers.into_iter().map(|(name, e, us)| (name, e, us, true));
        let results: Vec<_> = ours.chain(peers).collect();
        table(findings, &format!("N={n} K={k}"), &results);
    }
    levels(findings);
    Ok(())
}

/// Rows of a case and their work-precision diagram.
fn table(findings: &mut Findings, case: &str, rows: &[(String, Errors, f64, bool)]) {
    let mut series = Vec::new();
    for (name, errors, us, peer) in rows {
        let error = errors.mean();
        // A method that is as good as the optimum has no place on a logarithm: it stands at 1e-6.
        let points = vec![(*us, error.max(1e-6))];
        if *peer {
            findings.peer(case, name, (error, ERROR), *us);
            series.push(Series::new(name, Mark::Swept, points));
        } else {
            findings.row(case, name, (error, ERROR), *us);
            series.push(Series::new(name, Mark::Ours, points));
        }
    }
    let name = format!("error-{}", case.to_lowercase().replace(['=', ' '], "-"));
    findings
        .figures
        .push(Plot::work_precision(ERROR, series).figure(
            &name,
            &format!("Clustering, {case}"),
            "Further left is faster, further down is more accurate.",
        ));
}

/// Exact levels of few values, beside the `ckmeans` crate.
fn levels(findings: &mut Findings) {
    const SETS: usize = 64;
    for (n, k) in [(16, 4), (16, 8), (16, 10)] {
        let mut stream = RandomStream::new(1, "levels");
        let sets: Vec<Vec<f32>> = (0..SETS)
            .map(|_| (0..n).map(|_| (2000.0 * stream.uniform()) as f32).collect())
            .collect();
        let theirs: Vec<Vec<f64>> = sets
            .iter()
            .map(|set| set.iter().map(|v| f64::from(*v)).collect())
            .collect();
        let mut solver = LevelSolver::new(n, k);
        let (mut a, mut b) = (0, 0);
        let mut race = Race::default();
        race.enter(|| {
            a += 1;
            solver.solve(&sets[a % SETS])
        });
        race.enter(|| {
            b += 1;
            ckmeans::ckmeans(&theirs[b % SETS], k as u8)
        });
        let samples = race.run(SAMPLES, BUDGET);
        // Both are exact; tests hold one against the other.
        let (case, error) = (
            format!("levels n={n} K={k}"),
            (0.0, "counts² over the optimum"),
        );
        findings.row(&case, "default", error, samples[0].median());
        findings.peer(&case, "ckmeans", error, samples[1].median());
    }
}
