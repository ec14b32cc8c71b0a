//! Script of a session, step by step: a function of protocol, participant and seed.

use palpate_core::random::RandomStream;
use palpate_files::{Groups, Protocol, TaskKind};

use super::order::{ordered, shuffle};

/// A step of the script. Stimuli of a trial may follow from answers; the trial itself does not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Line {
    Consent,
    Instructions,
    Question(usize),
    Break,
    Trial(Cue),
}

/// A trial of the script.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cue {
    pub(super) task: TaskKind,
    pub(super) practice: bool,
    /// Number of its wire, condition or pair among those of its task.
    pub(super) thing: usize,
    /// `true` where the intervals change places: the second is the one that could as well have been the first.
    pub(super) swapped: bool,
}

/// Conditions of a rating that a participant meets.
fn met(protocol: &Protocol, participant: u32) -> Vec<usize> {
    let Some(task) = &protocol.rating else {
        return Vec::new();
    };
    let other = usize::from(!participant.is_multiple_of(2));
    let skipped = |name: &String| {
        task.groups == Groups::Between && task.compare.iter().any(|pair| pair[other] == *name)
    };
    let conditions = task.conditions.iter().enumerate();
    let met = conditions.filter(|(_, name)| !skipped(name));
    met.map(|(index, _)| index).collect()
}

/// All steps, in their order.
pub(super) fn script(protocol: &Protocol, participant: u32, seed: u64) -> Vec<Line> {
    let mut lines = Vec::new();
    lines.extend(protocol.consent.is_some().then_some(Line::Consent));
    let questions = |after: bool| {
        let numbered = protocol.questions.iter().enumerate();
        let ours = numbered.filter(move |(_, question)| question.after == after);
        ours.map(|(number, _)| Line::Question(number))
    };
    lines.extend(questions(false));
    lines.extend(
        protocol
            .instructions
            .is_some()
            .then_some(Line::Instructions),
    );
    let mut since_break = 0;
    for (task, count, repeats) in protocol.tasks() {
        let things = match task {
            TaskKind::Rating => met(protocol, participant),
            _ => (0..count).collect(),
        };
        if things.is_empty() {
            continue;
        }
        let of = format!("participant {participant}, {}", task.name());
        let mut random = RandomStream::new(seed, &of);
        let count = (things.len(), repeats);
        let counted = ordered(protocol.order, count, participant, &mut random);
        let practice = (0..protocol.practice as usize).map(|n| (n % things.len(), true));
        let mut first: Vec<bool> = Vec::new();
        for (thing, practice) in practice.chain(counted.into_iter().map(|thing| (thing, false))) {
            if first.is_empty() {
                // As often one way as the other, whatever has come before.
                first = vec![false, true, false, true];
                shuffle(&mut first, &mut random);
            }
            let swapped = first.pop().unwrap_or_default();
            if protocol.break_after.is_some_and(|most| since_break >= most) {
                lines.push(Line::Break);
                since_break = 0;
            }
            since_break += 1;
            lines.push(Line::Trial(Cue {
                task,
                practice,
                thing: things[thing],
                swapped,
            }));
        }
    }
    lines.extend(questions(true));
    lines
}
