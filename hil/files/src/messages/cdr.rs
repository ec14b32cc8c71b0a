//! Messages of ROS 2: the text that defines them, and their bytes (CDR, as DDS writes it).

use std::collections::BTreeMap;

use super::Leaves;

/// Most numbers of a message; `DEEPEST` bounds the nesting of messages.
const MOST_LEAVES: usize = 1 << 20;
const DEEPEST: usize = 16;

/// Number of values of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Count {
    One,
    Fixed(usize),
    /// A number that the field's own length states.
    Stated,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Field {
    name: String,
    kind: String,
    count: Count,
}

/// Fields that make up a message.
#[derive(Debug)]
pub(super) struct Definition {
    name: String,
    /// The fields of each message, by `package/Name`.
    messages: BTreeMap<String, Vec<Field>>,
}

impl Definition {
    /// Reads a definition with those it needs behind it, each after a line of equals signs and its name.
    pub(super) fn parse(name: &str, text: &str) -> Self {
        let name = short(name);
        let mut messages: BTreeMap<String, Vec<Field>> = BTreeMap::new();
        let mut here = name.clone();
        messages.entry(here.clone()).or_default();
        for line in text.lines() {
            if let Some(named) = line.trim().strip_prefix("MSG:") {
                here = short(named.trim());
                messages.entry(here.clone()).or_default();
            } else if let Some(field) = field(line) {
                messages.entry(here.clone()).or_default().push(field);
            }
        }
        Self { name, messages }
    }

    /// The numbers of a message; none where it is cut, or has another definition.
    pub(super) fn read(&self, data: &[u8], leaves: &mut Leaves) -> Option<()> {
        let (head, body) = data.split_at_checked(4)?;
        let mut bytes = Aligned {
            body,
            at: 0,
            is_big: head[1] & 1 == 0,
        };
        self.message(&self.name, "", &mut bytes, leaves, 0)
    }

    fn message(
        &self,
        name: &str,
        prefix: &str,
        bytes: &mut Aligned<'_>,
        leaves: &mut Leaves,
        depth: usize,
    ) -> Option<()> {
        let fields = self.messages.get(name).filter(|_| depth < DEEPEST)?;
        for field in fields {
            let path = match prefix {
                "" => field.name.clone(),
                prefix => format!("{prefix}.{}", field.name),
            };
            let count = match field.count {
                Count::One => {
                    self.value(name, &field.kind, path, bytes, leaves, depth)?;
                    continue;
                }
                Count::Fixed(count) => count,
                Count::Stated => usize::try_from(bytes.number(4)?).ok()?,
            };
            // Each value has a byte at least, so a longer list cannot be whole.
            if count > bytes.body.len() {
                return None;
            }
            for place in 0..count {
                let path = format!("{path}.{place}");
                self.value(name, &field.kind, path, bytes, leaves, depth)?;
            }
        }
        Some(())
    }

    fn value(
        &self,
        within: &str,
        kind: &str,
        path: String,
        bytes: &mut Aligned<'_>,
        leaves: &mut Leaves,
        depth: usize,
    ) -> Option<()> {
        let number = match kind {
            "bool" | "byte" | "uint8" | "char" => bytes.number(1)?.to_string(),
            "uint16" => bytes.number(2)?.to_string(),
            "uint32" => bytes.number(4)?.to_string(),
            "uint64" => bytes.number(8)?.to_string(),
            "int8" => (bytes.number(1)? as i8).to_string(),
            "int16" => (bytes.number(2)? as i16).to_string(),
            "int32" => (bytes.number(4)? as i32).to_string(),
            "int64" => bytes.number(8)?.cast_signed().to_string(),
            "float32" => f32::from_bits(bytes.number(4)? as u32).to_string(),
            "float64" => f64::from_bits(bytes.number(8)?).to_string(),
            "string" => {
                let length = usize::try_from(bytes.number(4)?).ok()?;
                bytes.take(length)?;
                return Some(());
            }
            "wstring" => {
                let length = usize::try_from(bytes.number(4)?).ok()?;
                bytes.take(length.checked_mul(2)?)?;
                return Some(());
            }
            other => {
                // A name without a package is of the message's own.
                let package = within.split('/').next().unwrap_or_default();
                let whole = match other {
                    "Header" => "std_msgs/Header".to_owned(),
                    other if other.contains('/') => short(other),
                    other => format!("{package}/{other}"),
                };
                return self.message(&whole, &path, bytes, leaves, depth + 1);
            }
        };
        leaves.push((path, number));
        (leaves.len() <= MOST_LEAVES).then_some(())
    }
}

/// The name `package/Name` of `package/msg/Name`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A field from a line such as `uint16[<=48] data 0 # counts`; none for a constant, a remark, or an empty line.
fn field(line: &str) -> Option<Field> {
    let line = line.split('#').next()?;
    let mut words = line.split_whitespace();
    let (kind, name) = (words.next()?, words.next()?);
    let is_constant = name.contains('=') || words.next().is_some_and(|w| w.starts_with('='));
    if is_constant || kind.starts_with('=') {
        return None;
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, size)) => match size.strip_suffix(']')?.parse() {
            Ok(count) => (kind, Count::Fixed(count)),
            Err(_) => (kind, Count::Stated),
        },
    };
    // The bound of a text tells nothing of its bytes.
    let kind = kind.split("<=").next()?;
    Some(Field {
        name: name.to_owned(),
        kind: kind.to_owned(),
        count,
    })
}

/// Bytes in which each number stands at a multiple of its width.
struct Aligned<'b> {
    body: &'b [u8],
    at: usize,
    is_big: bool,
}

impl Aligned<'_> {
    fn take(&mut self, length: usize) -> Option<&[u8]> {
        let end = self.at.checked_add(length)?;
        let taken = self.body.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn number(&mut self, width: usize) -> Option<u64> {
        self.at = self.at.checked_next_multiple_of(width)?;
        let is_big = self.is_big;
        let bytes = self.take(width)?;
        let add = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        Some(match is_big {
            true => bytes.iter().fold(0, add),
            false => bytes.iter().rev().fold(0, add),
        })
    }
}
