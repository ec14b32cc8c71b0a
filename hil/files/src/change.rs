//! A value in place of a file's own, and where in a TOML text a key stands.

use serde::Deserialize;
use toml::Value;
use toml::de::{DeTable, DeValue};

/// What stands at a key whatever the file says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Change {
    /// Who says so, as errors name it: an option of the command line.
    pub by: String,
    /// The key's full path.
    pub key: String,
    /// The value as TOML has it, or a plain string; none leaves the key out.
    pub value: Option<String>,
}

impl Change {
    /// Whether it decides what stands at `key`: the same one, or one inside it.
    pub(super) fn covers(&self, key: &str) -> bool {
        let inside = key.strip_prefix(self.key.as_str());
        inside.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    }

    /// Puts the value into a file's; tables on the way are made.
    ///
    /// # Errors
    /// What was expected at the key.
    pub(super) fn apply(&self, file: &mut Value) -> Result<(), &'static str> {
        const PLACE: &str = "a key that the file can have";
        let value = self.value.as_deref().map(parse).transpose()?;
        let mut steps = steps(&self.key).peekable();
        let mut here = file;
        while let Some(step) = steps.next() {
            let last = steps.peek().is_none();
            here = match (step, here) {
                (Step::Key(name), Value::Table(table)) if last => {
                    match value {
                        Some(value) => table.insert(name.into(), value),
                        None => table.remove(name),
                    };
                    return Ok(());
                }
                (Step::Key(name), Value::Table(table)) => table
                    .entry(name)
                    .or_insert_with(|| Value::Table(toml::Table::new())),
                (Step::Index(index), Value::Array(items)) => {
                    let item = items.get_mut(index).ok_or(PLACE)?;
                    if let (true, Some(value)) = (last, &value) {
                        *item = value.clone();
                        return Ok(());
                    }
                    item
                }
                _ => return Err(PLACE),
            };
        }
        Err(PLACE)
    }
}

/// A text as a value; what is no value of TOML is a string.
fn parse(text: &str) -> Result<Value, &'static str> {
    let line = format!("value = {text}");
    let Ok(table) = DeTable::parse(&line) else {
        return Ok(Value::String(text.into()));
    };
    refuse_numbers(&mut String::new(), table.get_ref()).map_err(|(_, expected)| expected)?;
    let read = Value::deserialize(toml::Deserializer::from(table)).ok();
    let mut tables = read.and_then(|value| value.try_into::<toml::Table>().ok());
    let alone = tables.as_mut().filter(|table| table.len() == 1);
    let value = alone.and_then(|table| table.remove("value"));
    Ok(value.unwrap_or_else(|| Value::String(text.into())))
}

/// Finds a number that no machine holds: its key, and what was expected there.
pub(super) fn refuse_numbers(
    path: &mut String,
    table: &DeTable<'_>,
) -> Result<(), (String, &'static str)> {
    for (key, value) in table {
        let length = path.len();
        if length > 0 {
            path.push('.');
        }
        path.push_str(key.get_ref());
        refuse_value(path, value.get_ref())?;
        path.truncate(length);
    }
    Ok(())
}

fn refuse_value(path: &mut String, value: &DeValue<'_>) -> Result<(), (String, &'static str)> {
    match value {
        DeValue::Table(table) => refuse_numbers(path, table),
        DeValue::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                let length = path.len();
                path.push_str(&format!("[{index}]"));
                refuse_value(path, item.get_ref())?;
                path.truncate(length);
            }
            Ok(())
        }
        DeValue::Float(float)
            if !float
                .as_str()
                .parse::<f64>()
                .is_ok_and(|number| number.is_finite()) =>
        {
            Err((path.clone(), "a finite number"))
        }
        DeValue::Integer(integer)
            if i64::from_str_radix(integer.as_str(), integer.radix()).is_err() =>
        {
            Err((path.clone(), "a whole number of at most 64 bits"))
        }
        _ => Ok(()),
    }
}

/// One step into a file.
pub(super) enum Step<'k> {
    Key(&'k str),
    Index(usize),
}

/// `touches[0].force_n` as steps; an index may follow a key directly or stand after a dot.
pub(super) fn steps(key: &str) -> impl Iterator<Item = Step<'_>> {
    key.split(['.', '[', ']'])
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().map_or(Step::Key(part), Step::Index))
}
