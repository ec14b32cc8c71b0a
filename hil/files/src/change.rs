//! Changes: values in place of a file's own, and the places of keys in a TOML text.

use serde::{Deserialize, Serialize};
use toml::Value;
use toml::de::DeTable;

use super::plain;

/// A value in place of a file's own.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Change {
    /// The author of the change, as errors name it: an option of the command line.
    pub by: String,
    /// The key's full path.
    pub key: String,
    /// The value as TOML has it, or a plain string; none leaves the key out.
    pub value: Option<String>,
}

impl Change {
    /// Returns true if the change decides the value at `key`: at that key, or at one around it.
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

/// Parses a text as a value; a text that is no TOML value is a string.
fn parse(text: &str) -> Result<Value, &'static str> {
    let line = format!("value = {text}");
    let Ok(table) = DeTable::parse(&line) else {
        return Ok(Value::String(text.into()));
    };
    let mut table = plain::table(table.get_ref()).map_err(|(_, expected)| expected)?;
    let value = table.remove("value").filter(|_| table.is_empty());
    Ok(value.unwrap_or_else(|| Value::String(text.into())))
}

/// One step into a file.
pub(super) enum Step<'k> {
    Key(&'k str),
    Index(usize),
}

/// Steps of a key such as `touches[0].force_n`; an index may follow a key directly or stand after a dot.
pub(super) fn steps(key: &str) -> impl Iterator<Item = Step<'_>> {
    key.split(['.', '[', ']'])
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().map_or(Step::Key(part), Step::Index))
}
