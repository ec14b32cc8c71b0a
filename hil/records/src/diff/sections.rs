//! Parts of goldens: the list of bursts, digests, and what follows the header of each kind but the schedule.

use super::golden::thousandths;
use super::golden::{Reader, chart, more, number};
use super::story::{Damage, Figure, Item, Output, Stay, Story};

/// Every burst, as `exact` prints them.
pub(super) fn bursts(reader: &mut Reader<'_>, story: &mut Story) -> Result<(), Damage> {
    const MEMBER: &str = "wire:ticks, or wire:ticks<asked(reason)";
    let heading = reader.begins("bursts: ")?;
    let (count, rest) = heading.split_once(';').unwrap_or((heading, ""));
    let count: u64 = count
        .parse()
        .map_err(|_| reader.wanted("a number of bursts"))?;
    let tau_us = rest.split("is not ").nth(1);
    let tau_us = tau_us
        .and_then(|t| t.split(' ').next())
        .and_then(thousandths);
    let tau_us = tau_us.and_then(|t| u64::try_from(t).ok());
    let tau_us = tau_us.ok_or_else(|| reader.wanted("tau_d in the heading of the bursts"))?;
    let mut told = 0u64;
    let mut at = None;
    while let Some(line) = reader.row() {
        if let Some(n) = more(line) {
            story.untold = n;
            continue;
        }
        for word in line.split_whitespace() {
            if let Some((output, rest)) = word.split_once(':') {
                let (from_us, to_us) =
                    at.ok_or_else(|| reader.wanted("an onset before its wires"))?;
                let (output, stay) =
                    member(output, rest, from_us, to_us).ok_or_else(|| reader.wanted(MEMBER))?;
                story.bursts.entry(output).or_default().push(stay);
                told += 1;
            } else {
                let (from, length) = match word.split_once('+') {
                    Some((from, length)) => (from.parse::<u64>().ok(), length.parse().ok()),
                    None => (word.parse().ok(), Some(tau_us)),
                };
                let span = from
                    .zip(length)
                    .and_then(|(f, l)| Some((f, f.checked_add(l)?)));
                at = Some(span.ok_or_else(|| reader.wanted("an onset in microseconds"))?);
            }
        }
    }
    if told.checked_add(story.untold) != Some(count) {
        let expected = format!("{count} bursts above, as their heading says");
        return Err(reader.wants(&expected));
    }
    for stays in story.bursts.values_mut() {
        stays.sort_by_key(|s| (s.from_us, s.to_us));
    }
    Ok(())
}

fn member(output: &str, rest: &str, from_us: u64, to_us: u64) -> Option<(Output, Stay)> {
    let output = match output.strip_prefix('@') {
        Some(pin) => {
            let (board, channel) = pin.split_once('.')?;
            Output::Pin(board.parse().ok()?, channel.parse().ok()?)
        }
        None => Output::Wire(output.parse().ok()?),
    };
    let (width, requested, reason) = match rest.split_once('<') {
        None => (rest.parse().ok()?, rest.parse().ok()?, None),
        Some((width, why)) => {
            let (asked, reason) = why.strip_suffix(')')?.split_once('(')?;
            (
                width.parse().ok()?,
                asked.parse().ok()?,
                Some(reason.to_owned()),
            )
        }
    };
    Some((
        output,
        Stay {
            from_us,
            to_us,
            width,
            requested,
            reason,
        },
    ))
}

/// The last lines.
pub(super) fn digests(
    reader: &mut Reader<'_>,
    story: &mut Story,
    names: &[&str],
) -> Result<(), Damage> {
    for name in names {
        let digest = reader.begins(&format!("digest of {name}"))?.trim();
        if digest.len() != 16 || !digest.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(reader.wanted("16 hexadecimal digits"));
        }
        story.digests.push(Item {
            key: (*name).to_owned(),
            text: digest.to_owned(),
        });
    }
    Ok(())
}

/// Behind the header of a contact path.
pub(super) fn contacts(reader: &mut Reader<'_>, story: &mut Story) -> Result<(), Damage> {
    reader.begins("pad:")?;
    while reader.row().is_some() {}
    reader.blank()?;
    chart(reader, story, "contacts:")?;
    reader.begins("contacts: ")?;
    while let Some(line) = reader.row() {
        let line = line.trim();
        if more(line).is_some() {
            continue;
        }
        if line.starts_with("levels ") {
            if let Some(last) = story.rows.last_mut() {
                last.text = format!("{}; {line}", last.text);
            }
            continue;
        }
        let (name, rest) = line
            .split_once(' ')
            .filter(|(name, _)| name.contains('/'))
            .ok_or_else(|| reader.wanted("module/identity of a contact"))?;
        story.rows.push(Item {
            key: format!("contact {name}"),
            text: format!("contact {name} {}", rest.trim()),
        });
    }
    digests(reader, story, &["contacts"])
}

/// Behind the header of margins.
pub(super) fn margins(reader: &mut Reader<'_>, story: &mut Story) -> Result<(), Damage> {
    reader.begins("margin ")?;
    while let Some(line) = reader.row() {
        let read = || {
            let name = line.get(2..28)?.trim().to_owned();
            let mut words = line.get(28..)?.split_whitespace();
            let used = number(words.next()?)?.to_owned();
            words.next().filter(|w| *w == "%")?;
            let value = number(words.next()?)?.to_owned();
            let limit = number(words.next()?)?.to_owned();
            let unit = words.next()?.trim_matches('-').to_owned();
            Some(Figure {
                name,
                value,
                unit,
                limit,
                used,
            })
        };
        let figure = read().ok_or_else(|| reader.wanted("name, part used, worst, limit, unit"))?;
        story.figures.push(figure);
    }
    Ok(())
}

/// Behind the header of a surface.
pub(super) fn surface(reader: &mut Reader<'_>, story: &mut Story) -> Result<(), Damage> {
    reader.begins("force [N] ")?;
    while let Some(line) = reader.row() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let &[force, speed, duty, energy, felt, limited] = words.as_slice() else {
            return Err(reader.wanted("six figures"));
        };
        if words.iter().any(|w| number(w).is_none()) {
            return Err(reader.wanted("six figures"));
        }
        story.rows.push(Item {
            key: format!("at {force} N and {speed} mm/s"),
            text: format!(
                "at {force} N and {speed} mm/s: peak duty {duty} %, energy {energy} mJ, felt error {felt} mm, limiter events {limited}"
            ),
        });
    }
    Ok(())
}
