//! A simulated participant: the draws for them, and their answers to trials.

use std::collections::BTreeMap;

use palpate_core::random::RandomStream;
use palpate_core::statistics::mean;
use palpate_files::{Normal, Protocol, TaskKind};

use crate::psychometric::Psychometric;
use crate::session::{Answer, Ask, Reply, Sample, Step, Stimulus, Trial};
use crate::threshold::{FRACTIONS_DB, GUESS, LEAST_DB};

/// A path: seconds, mm right and up on the display.
pub type Path = Vec<[f64; 3]>;

/// An onset as the person of a run perceives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensed {
    /// Time of the onset, seconds.
    pub t_s: f64,
    /// Felt place, mm right and up on the display; `None` where the onset stays below the threshold.
    pub place_mm: Option<[f64; 2]>,
}

/// Time between two points of a pen, ms: 120 Hz.
const PEN_MS: f64 = 1000.0 / 120.0;
/// Time constant of a hand's wander beside its line, s.
const WANDER_S: f64 = 0.2;
/// Duration of a break, ms.
const BREAK_MS: f64 = 250.0;

/// Display and paths that a person meets.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Known {
    /// Places of the display's wires, mm.
    pub wires_mm: Vec<[f64; 2]>,
    /// Path of each condition.
    pub paths: BTreeMap<String, Path>,
    /// Onsets of each stimulus as they are felt. Of a stimulus that is not here a drawing follows the path, and a place is the
    /// wire's.
    pub felt: Vec<(Stimulus, Vec<Sensed>)>,
    /// Strength of each wire by level as the bench's person feels it: dB of full drive, ascending, and dB over threshold. Of a
    /// wire that is not here a protocol's means count.
    pub growth: BTreeMap<u16, Vec<[f64; 2]>>,
}

/// Value between points `[x, y]` at `x`, the first where several fit; beyond their ends it goes on one for one.
fn between(points: impl Iterator<Item = [f64; 2]> + Clone, x: f64) -> Option<f64> {
    let mut pairs = points.clone().zip(points.clone().skip(1));
    let Some(([ax, ay], [bx, by])) = pairs.find(|([ax, _], [bx, _])| (*ax..=*bx).contains(&x))
    else {
        let nearer = |a: [f64; 2], b: [f64; 2]| {
            if (a[0] - x).abs() <= (b[0] - x).abs() {
                a
            } else {
                b
            }
        };
        let [end, y] = points.reduce(nearer)?;
        return Some(y + x - end);
    };
    Some(ay + (by - ay) * (x - ax) / (bx - ax).max(1e-9))
}

impl Known {
    /// Strength of a wire at a level, dB over threshold.
    fn strength_db(&self, wire: u16, level_db: f64) -> Option<f64> {
        between(self.growth.get(&wire)?.iter().copied(), level_db)
    }

    /// Level at which a wire is so strong, dB of full drive.
    fn level_db(&self, wire: u16, strength_db: f64) -> Option<f64> {
        let turned = self
            .growth
            .get(&wire)?
            .iter()
            .map(|[level, felt]| [*felt, *level]);
        between(turned, strength_db)
    }

    /// Notes what is felt of a stimulus; without an onset nothing is known of it.
    pub fn feel(&mut self, stimulus: &Stimulus, sensed: &[Sensed]) {
        self.felt.retain(|(other, _)| other != stimulus);
        if !sensed.is_empty() {
            self.felt.push((stimulus.clone(), sensed.to_vec()));
        }
    }

    /// Onsets that are felt of a trial's first stimulus, if that is known.
    fn felt_in(&self, trial: &Trial) -> Option<&[Sensed]> {
        let first = trial.intervals.first()?;
        let felt = self.felt.iter().find(|(stimulus, _)| stimulus == first);
        felt.map(|(_, sensed)| sensed.as_slice())
    }
}

/// A simulated participant.
#[derive(Debug, Clone)]
pub struct Person {
    /// Number of the participant, from 1 on.
    number: u32,
    seed: u64,
    /// Psychometric functions by task whose levels follow from answers, one per wire.
    pub(crate) felt: BTreeMap<TaskKind, Vec<Psychometric>>,
    place_bias: [f64; 2],
    drawing_bias: [f64; 2],
    drawing_scale: f64,
    rating: f64,
    preference: f64,
}

pub(crate) fn drawn(normal: Normal, random: &mut RandomStream) -> f64 {
    normal.mean + normal.sd * random.normal()
}

impl Person {
    /// The participant of a number: one in each study, so that those of two protocols are different people.
    #[must_use]
    pub fn new(protocol: &Protocol, number: u32, seed: u64, known: &Known) -> Self {
        let stream = |task: TaskKind| {
            let (study, task) = (&protocol.name, task.name());
            let name = format!("simulated participant {number} of {study}, {task}");
            RandomStream::new(seed, &name)
        };
        let mut person = Self {
            number,
            seed,
            felt: BTreeMap::new(),
            place_bias: [0.0; 2],
            drawing_bias: [0.0; 2],
            drawing_scale: 1.0,
            rating: 0.0,
            preference: 0.0,
        };
        if let Some(task) = &protocol.absolute_threshold {
            let (people, random) = (&task.simulated, &mut stream(TaskKind::AbsoluteThreshold));
            // What the bench's person just feels, and how far this participant is from them.
            let off = drawn(people.threshold_db, random) - people.threshold_db.mean;
            let (slope, lapse) = (drawn(people.slope, random), people.lapse * random.uniform());
            let of_wire = |wire: &u16| Psychometric {
                // A level beyond a wire's range has no threshold there to be found.
                threshold: (known
                    .level_db(*wire, 0.0)
                    .unwrap_or(people.threshold_db.mean)
                    + off
                    + people.wire_sd_db * random.normal())
                .clamp(LEAST_DB + 2.0, -2.0),
                slope: slope.max(0.5),
                guess: GUESS,
                lapse,
            };
            let felt = task.wires.iter().map(of_wire).collect();
            person.felt.insert(TaskKind::AbsoluteThreshold, felt);
        }
        if let Some(task) = &protocol.difference {
            let (people, random) = (&task.simulated, &mut stream(TaskKind::Difference));
            let lapse = people.lapse * random.uniform();
            let of_wire = |_: &u16| Psychometric {
                threshold: drawn(people.fraction_db, random)
                    .clamp(FRACTIONS_DB.0 + 2.0, FRACTIONS_DB.1 - 2.0),
                slope: drawn(people.slope, random).max(0.5),
                guess: GUESS,
                lapse,
            };
            let felt = task.wires.iter().map(of_wire).collect();
            person.felt.insert(TaskKind::Difference, felt);
        }
        if let Some(task) = &protocol.matching {
            let (people, random) = (&task.simulated, &mut stream(TaskKind::Matching));
            let lapse = people.lapse * random.uniform();
            // The level at which the bench's person feels a wire as strongly as the reference.
            let reference = known.strength_db(task.reference, task.level_db);
            let alike = |wire: u16| {
                let level_db = reference.and_then(|strength| known.level_db(wire, strength));
                level_db.unwrap_or(task.level_db) - task.level_db
            };
            let of_wire = |wire: &u16| Psychometric {
                threshold: (alike(*wire) + drawn(people.level_db, random))
                    .clamp(LEAST_DB + 2.0, -1.0),
                slope: drawn(people.slope, random).max(0.5),
                guess: lapse,
                lapse,
            };
            let felt = task.wires.iter().map(of_wire).collect();
            person.felt.insert(TaskKind::Matching, felt);
        }
        if let Some(task) = &protocol.localisation {
            let random = &mut stream(TaskKind::Localisation);
            person.place_bias = [0, 1].map(|_| drawn(task.simulated.bias_mm, random));
        }
        if let Some(task) = &protocol.drawing {
            let random = &mut stream(TaskKind::Drawing);
            person.drawing_bias = [0, 1].map(|_| drawn(task.simulated.bias_mm, random));
            person.drawing_scale = drawn(task.simulated.scale, random).max(0.1);
        }
        if let Some(task) = &protocol.rating {
            person.rating = drawn(task.simulated.rating, &mut stream(TaskKind::Rating));
        }
        if let Some(task) = &protocol.choice {
            person.preference = drawn(task.simulated.preference, &mut stream(TaskKind::Choice));
        }
        person
    }

    /// Reply of the person to a step; `None` once the session is over. The same step gets the same reply, however often
    /// the session was begun again.
    #[must_use]
    pub fn reply(&self, protocol: &Protocol, step: &Step, known: &Known) -> Option<Reply> {
        Some(match step {
            Step::Consent => Reply::Consent(true),
            Step::Instructions | Step::Break => Reply::Read,
            Step::Question(_) => Reply::Chosen(0),
            Step::Trial(trial) => Reply::Answer(self.answer(protocol, trial, known)),
            Step::Done | Step::Declined => return None,
        })
    }

    fn answer(&self, protocol: &Protocol, trial: &Trial, known: &Known) -> Answer {
        let (number, study) = (self.number, &protocol.name);
        let name = format!("answer of {number} of {study} to {}", trial.number);
        let random = &mut RandomStream::new(self.seed, &name);
        match &trial.ask {
            Ask::Interval(_) | Ask::Which(_) => self.interval(protocol, trial, random),
            Ask::Place => self.place(protocol, trial, known, random),
            Ask::Path => self.drawing(protocol, trial, known, random),
            Ask::Ratings(scales) => {
                let rating = protocol.rating.as_ref().map(|task| {
                    let second = |name: &str| task.compare.iter().any(|pair| pair[1] == name);
                    let higher = condition(trial).is_some_and(second);
                    let more = f64::from(u8::from(higher)) * task.simulated.difference;
                    (self.rating + more, task.simulated.noise)
                });
                let (own, noise) = rating.unwrap_or_default();
                let one = |_| libm::round(own + noise * random.normal()).clamp(1.0, 6.0) as u8;
                Answer::Ratings(scales.iter().map(one).collect())
            }
        }
    }

    fn interval(&self, protocol: &Protocol, trial: &Trial, random: &mut RandomStream) -> Answer {
        // Of two wires the one that is no reference.
        let matching = protocol.matching.as_ref();
        let matching = matching.filter(|_| trial.task == TaskKind::Matching);
        let reference = matching.map(|task| task.reference);
        let wire = trial.intervals.iter().find_map(|stimulus| match stimulus {
            Stimulus::Wire { wire, .. } if Some(*wire) != reference => Some(*wire),
            _ => None,
        });
        let yes = match self.felt.get(&trial.task) {
            Some(felt) => {
                let mut wires = protocol.wires(trial.task).iter();
                let place = wires.position(|w| Some(*w) == wire);
                let felt = place.and_then(|place| felt.get(place));
                felt.map(|felt| felt.correct(trial.level_db.unwrap_or_default()))
            }
            None => Some(1.0 / (1.0 + libm::exp(-self.preference))),
        };
        let right = trial.right.unwrap_or(1);
        let says_yes = random.uniform() < yes.unwrap_or(0.5);
        Answer::Interval(if says_yes { right } else { 3 - right })
    }

    fn place(
        &self,
        protocol: &Protocol,
        trial: &Trial,
        known: &Known,
        random: &mut RandomStream,
    ) -> Answer {
        let wire = || {
            trial.intervals.iter().find_map(|stimulus| match stimulus {
                Stimulus::Wire { wire, .. } => known.wires_mm.get(usize::from(*wire)).copied(),
                _ => None,
            })
        };
        let felt = known.felt_in(trial);
        let at = felt.map_or_else(wire, middle);
        let [x, y] = at.unwrap_or_default();
        let Some(task) = &protocol.localisation else {
            return Answer::Place([x, y]);
        };
        // Who feels nothing points anywhere, as in a slip.
        let slips = random.uniform() < task.simulated.slips || at.is_none();
        if slips && !known.wires_mm.is_empty() {
            let any = (random.uniform() * known.wires_mm.len() as f64) as usize;
            return Answer::Place(known.wires_mm[any.min(known.wires_mm.len() - 1)]);
        }
        let noise = task.simulated.noise_mm;
        let mut near = |at: f64, bias: f64| at + bias + noise * random.normal();
        Answer::Place([near(x, self.place_bias[0]), near(y, self.place_bias[1])])
    }

    fn drawing(
        &self,
        protocol: &Protocol,
        trial: &Trial,
        known: &Known,
        random: &mut RandomStream,
    ) -> Answer {
        let still = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let name = condition(trial);
        let felt = known.felt_in(trial);
        let path = name.and_then(|name| known.paths.get(name));
        let path = || path.filter(|path| path.len() > 1).unwrap_or(&still).clone();
        let pieces = felt.map_or_else(|| vec![path()], pieces);
        let (noise, breaks_hz) = protocol.drawing.as_ref().map_or((0.0, 0.0), |task| {
            (task.simulated.noise_mm, task.simulated.breaks_hz)
        });
        // Where a run says what is felt, its breaks are the only ones.
        let breaks_hz = if felt.is_some() { 0.0 } else { breaks_hz };
        // As a process with a memory: the part that is left after a step, and a new part.
        let left = libm::exp(-PEN_MS * 1e-3 / WANDER_S);
        let new = libm::sqrt(1.0 - left * left);
        let mut off = [0, 1].map(|_| noise * random.normal());
        let (mut strokes, mut stroke) = (Vec::new(), Vec::new());
        let mut paused_ms = 0.0;
        for path in &pieces {
            let begun = path[0][0];
            let lasts_ms = 1e3 * (path[path.len() - 1][0] - begun);
            let mut t_ms = 0.0;
            while t_ms <= lasts_ms {
                let [x, y] = place_at(path, begun + t_ms * 1e-3);
                let place =
                    |axis: usize, at: f64| self.drawing_bias[axis] + self.drawing_scale * at;
                stroke.push(Sample {
                    t_ms: t_ms + paused_ms,
                    x_mm: place(0, x) + off[0],
                    y_mm: place(1, y) + off[1],
                });
                off = off.map(|o| left * o + new * noise * random.normal());
                if random.uniform() < breaks_hz * PEN_MS * 1e-3 {
                    strokes.push(std::mem::take(&mut stroke));
                    paused_ms += BREAK_MS;
                }
                t_ms += PEN_MS;
            }
            strokes.extend((!stroke.is_empty()).then(|| std::mem::take(&mut stroke)));
            paused_ms += t_ms + BREAK_MS;
        }
        Answer::Path(strokes)
    }
}

/// The way of what is felt, in pieces: each goes from onset to onset, and ends before one that is not felt. Where nothing is
/// felt, the pen makes one point in the middle of the display.
fn pieces(felt: &[Sensed]) -> Vec<Path> {
    let split = felt.split(|onset| onset.place_mm.is_none());
    let piece = |onsets: &[Sensed]| -> Path {
        let each = onsets.iter();
        each.filter_map(|onset| onset.place_mm.map(|[x, y]| [onset.t_s, x, y]))
            .collect()
    };
    let found: Vec<Path> = split.map(piece).filter(|piece| !piece.is_empty()).collect();
    match found.is_empty() {
        true => vec![vec![[0.0; 3]]],
        false => found,
    }
}

/// Middle of the felt onsets, mm; `None` where nothing is felt.
fn middle(felt: &[Sensed]) -> Option<[f64; 2]> {
    let places = || felt.iter().filter_map(|onset| onset.place_mm);
    let axis = |axis: usize| mean(places().map(|place| place[axis]));
    Some([axis(0)?, axis(1)?])
}

/// Place of a path at a time, mm: straight between its points, its ends before and after.
fn place_at(path: &[[f64; 3]], t: f64) -> [f64; 2] {
    let last = path.len() - 1;
    let next = path.partition_point(|p| p[0] < t).clamp(1, last.max(1));
    let (a, b) = (path[next - 1], path[next.min(last)]);
    let way = ((t - a[0]) / (b[0] - a[0]).max(1e-9)).clamp(0.0, 1.0);
    [1, 2].map(|axis| a[axis] + way * (b[axis] - a[axis]))
}

/// Condition that a trial plays first.
fn condition(trial: &Trial) -> Option<&str> {
    trial.intervals.iter().find_map(|stimulus| match stimulus {
        Stimulus::Condition(name) => Some(name.as_str()),
        _ => None,
    })
}
