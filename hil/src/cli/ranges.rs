//! Values of a list: one by one between commas, and ranges of them. Every option that takes a list reads it alike.

/// Most values of one range.
const MOST: i128 = 1_000_000;
/// Most digits of a number of a range, before its point and behind it.
const DIGITS: (usize, usize) = (20, 12);

/// A number as it is written: a whole one, and how many of its digits stand behind the point.
#[derive(Clone, Copy)]
struct Decimal {
    whole: i128,
    places: u32,
}

impl Decimal {
    fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let (sign, digits) = match text.strip_prefix('-') {
            Some(digits) => (-1, digits),
            None => (1, text),
        };
        let (before, behind) = digits.split_once('.').unwrap_or((digits, ""));
        let plain = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
        let some = !before.is_empty() && (!behind.is_empty() || !digits.contains('.'));
        let short = before.len() <= DIGITS.0 && behind.len() <= DIGITS.1;
        if !(some && short && plain(before) && plain(behind)) {
            return None;
        }
        let whole: i128 = format!("{before}{behind}").parse().ok()?;
        Some(Self {
            whole: sign * whole,
            places: behind.len() as u32,
        })
    }

    /// The number in steps of this many places.
    const fn at(self, places: u32) -> i128 {
        self.whole * 10_i128.pow(places - self.places)
    }
}

/// A whole number of steps as a decimal, without zeros at its end.
fn written(steps: i128, places: u32) -> String {
    let unit = 10_i128.pow(places);
    let sign = if steps < 0 { "-" } else { "" };
    let (before, behind) = (steps.abs() / unit, steps.abs() % unit);
    let behind = format!("{behind:0places$}", places = places as usize);
    let text = match places {
        0 => format!("{sign}{before}"),
        _ => format!("{sign}{before}.{behind}"),
    };
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// The values of `FROM..TO` or `FROM..TO:STEP`, both ends among them, in decimals without rounding; none of a text that is no
/// range of numbers.
///
/// # Errors
/// What was expected of a range that holds no value, or too many.
fn range(text: &str) -> Result<Option<Vec<String>>, String> {
    let parts = text.split_once("..").and_then(|(from, rest)| {
        let (to, step) = rest.split_once(':').unwrap_or((rest, "1"));
        Some((
            Decimal::parse(from)?,
            Decimal::parse(to)?,
            Decimal::parse(step)?,
        ))
    });
    let Some((from, to, step)) = parts else {
        return Ok(None);
    };
    let places = from.places.max(to.places).max(step.places);
    let (first, last, step) = (from.at(places), to.at(places), step.at(places));
    if step <= 0 {
        return Err(format!("expected a step above 0, found `{text}`"));
    }
    if first > last {
        let (low, high) = (written(last, places), written(first, places));
        return Err(format!(
            "expected the smaller end first, {low}..{high}, found `{text}`"
        ));
    }
    let count = (last - first) / step + 1;
    if count > MOST {
        return Err(format!(
            "expected a range of at most {MOST} values, found {count}"
        ));
    }
    let values = (0..count).map(|n| written(first + n * step, places));
    Ok(Some(values.collect()))
}

/// The values of a list: `1..5,9` are six.
///
/// # Errors
/// What [`range`] says.
pub fn list(text: &str) -> Result<Vec<String>, String> {
    let mut all = Vec::new();
    for part in text.split(',') {
        add(&mut all, part)?;
    }
    Ok(all)
}

/// Adds a value, or the values of a range.
///
/// # Errors
/// What [`range`] says, and a list that becomes too long.
pub fn add(list: &mut Vec<String>, text: &str) -> Result<(), String> {
    match range(text)? {
        Some(values) => list.extend(values),
        None => list.push(text.trim().to_owned()),
    }
    match list.len() as i128 > MOST {
        true => Err(format!("expected at most {MOST} values, found more")),
        false => Ok(()),
    }
}

/// `KEY=VALUE` of a command that runs once.
///
/// # Errors
/// What was expected of a text without a key, and of one with many values.
pub fn key_value(text: &str) -> Result<String, String> {
    let parts = text.split_once('=').map(|(k, v)| (k.trim(), v));
    let Some((key, value)) = parts.filter(|(key, _)| !key.is_empty()) else {
        return Err("expected KEY=VALUE, such as illusion.soa_ms=120".into());
    };
    match range(value) {
        Ok(None) => Ok(text.to_owned()),
        _ => Err(format!(
            "expected one value; `hil sweep SCENE --set {key}={value} --out runs.csv` runs each of a range"
        )),
    }
}

#[cfg(test)]
#[path = "ranges_tests.rs"]
mod tests;
