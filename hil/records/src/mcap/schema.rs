//! Descriptors of messages, as `descriptor.proto` has them, and the levels of the log.

use super::proto::Message;

/// Levels of [`super::LOG`].
#[derive(Clone, Copy, Debug)]
pub enum Level {
    /// Worth a line.
    Info = 2,
    /// The guard changed something, or something was left out.
    Warning = 3,
}

/// A field of a message.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field<'a> {
    pub name: &'a str,
    pub number: u32,
    /// The word of a scalar, or the full name of a message or an enumeration.
    pub kind: &'a str,
    pub is_enum: bool,
    pub repeated: bool,
}

/// Number of a scalar in `descriptor.proto`; `None` for the name of a message or an enumeration.
fn scalar(word: &str) -> Option<u32> {
    Some(match word {
        "double" => 1,
        "int64" => 3,
        "uint64" => 4,
        "int32" => 5,
        "fixed32" => 7,
        "bool" => 8,
        "string" => 9,
        "bytes" => 12,
        "uint32" => 13,
        _ => return None,
    })
}

/// A field's descriptor.
pub(super) fn field(of: &Field<'_>) -> Message {
    const OPTIONAL: u32 = 1;
    const REPEATED: u32 = 3;
    const MESSAGE: u32 = 11;
    const ENUM: u32 = 14;
    let (kind, type_name) = match scalar(of.kind) {
        Some(kind) => (kind, String::new()),
        None if of.is_enum => (ENUM, format!(".{}", of.kind)),
        None => (MESSAGE, format!(".{}", of.kind)),
    };
    let mut field = Message::default();
    field
        .text(1, of.name)
        .uint(3, of.number)
        .uint(4, if of.repeated { REPEATED } else { OPTIONAL })
        .uint(5, kind)
        .text(6, &type_name);
    field
}

/// A file's descriptor.
pub(super) fn file(name: &str, package: &str, dependency: &str, messages: &[Message]) -> Message {
    let mut file = Message::default();
    file.text(1, name).text(2, package).text(3, dependency);
    for message in messages {
        file.inner(4, message);
    }
    file.text(12, "proto3");
    file
}
