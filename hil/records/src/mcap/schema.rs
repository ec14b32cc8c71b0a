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
    /// By its number in `descriptor.proto`.
    pub kind: u32,
    pub repeated: bool,
}

/// A field's descriptor; messages and enumerations have a name.
pub(super) fn field(of: &Field<'_>, type_name: Option<&str>) -> Message {
    const OPTIONAL: u32 = 1;
    const REPEATED: u32 = 3;
    let mut field = Message::default();
    field
        .text(1, of.name)
        .uint(3, of.number)
        .uint(4, if of.repeated { REPEATED } else { OPTIONAL })
        .uint(5, of.kind);
    field.text(6, type_name.unwrap_or_default());
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
