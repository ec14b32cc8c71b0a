//! The trial of a line of the script: its stimuli, their level, and its question.

use palpate_files::TaskKind;

use super::script::{Cue, Line};
use super::trial::{Ask, Stimulus, Trial};
use super::{Session, raised};

/// Intervals, question and interval that counts as yes, before intervals change places.
struct Made {
    intervals: Vec<Stimulus>,
    ask: Ask,
    right: Option<u8>,
}

const fn wire(wire: u16, level_db: f64) -> Stimulus {
    Stimulus::Wire { wire, level_db }
}

impl Session {
    /// Makes the trial of a line; `strongest` takes the largest level that its method may choose.
    pub(super) fn trial(&self, cue: Cue, at: usize, strongest: bool) -> Trial {
        let before = self.script[..at].iter();
        let number = before.filter(|line| matches!(line, Line::Trial(_))).count() as u32 + 1;
        let method = self.methods.get(&cue.task);
        let method = method.and_then(|of_wires| of_wires.get(cue.thing));
        let level_db = method.map(|method| match strongest || cue.practice {
            true => method.most(),
            false => method.next().unwrap_or(method.most()),
        });
        let Made {
            mut intervals,
            ask,
            mut right,
        } = match level_db {
            Some(level_db) => self.adaptive(cue, level_db),
            None => self.constant(cue),
        };
        if cue.swapped {
            intervals.reverse();
            right = right.map(|n| 3 - n);
        }
        Trial {
            number,
            attempt: self.attempt,
            task: cue.task,
            practice: cue.practice,
            intervals,
            ask,
            right,
            level_db,
        }
    }

    /// Makes a trial of two intervals at a level that a method chose. Yes is the first.
    fn adaptive(&self, cue: Cue, level_db: f64) -> Made {
        let protocol = &self.protocol;
        let (intervals, question) = match (cue.task, &protocol.difference, &protocol.matching) {
            (TaskKind::Difference, Some(task), _) => {
                let on = task.wires[cue.thing];
                let more = raised(task.level_db, level_db);
                (
                    vec![wire(on, more), wire(on, task.level_db)],
                    "Which one was stronger?",
                )
            }
            (TaskKind::Matching, _, Some(task)) => {
                let reference = wire(task.reference, task.level_db);
                let intervals = vec![wire(task.wires[cue.thing], level_db), reference];
                (intervals, "Which one was stronger?")
            }
            _ => {
                let task = protocol.absolute_threshold.iter();
                let on = task.map(|task| wire(task.wires[cue.thing], level_db));
                let intervals = on.chain([Stimulus::Silence]).collect();
                (intervals, "In which one did you feel something?")
            }
        };
        Made {
            intervals,
            ask: Ask::Interval(question),
            right: Some(1),
        }
    }

    /// A trial that no earlier answer changes.
    fn constant(&self, cue: Cue) -> Made {
        let protocol = &self.protocol;
        let condition = |name: &String| Stimulus::Condition(name.clone());
        let (mut intervals, mut ask, mut right) = (Vec::new(), Ask::Place, None);
        match cue.task {
            TaskKind::Drawing => {
                let task = protocol.drawing.iter();
                intervals.extend(task.map(|t| condition(&t.conditions[cue.thing])));
                ask = Ask::Path;
            }
            TaskKind::Rating => {
                let task = protocol.rating.as_ref();
                intervals.extend(task.map(|t| condition(&t.conditions[cue.thing])));
                ask = Ask::Ratings(task.map_or_else(Vec::new, |t| t.scales.clone()));
            }
            TaskKind::Choice => {
                let task = protocol.choice.as_ref();
                intervals.extend(
                    task.iter()
                        .flat_map(|t| t.pairs[cue.thing].iter().map(condition)),
                );
                ask = Ask::Which(task.map_or_else(String::new, |t| t.question.clone()));
                // Yes is the pair's second.
                right = Some(2);
            }
            _ => {
                let task = protocol.localisation.iter();
                intervals.extend(task.map(|t| wire(t.wires[cue.thing], t.level_db)));
            }
        }
        Made {
            intervals,
            ask,
            right,
        }
    }
}
