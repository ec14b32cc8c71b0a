//! The messages as descriptors for recordings, and as text for people and other languages.

use std::fmt::Write as _;

use palpate_core::contact::Contact;
use palpate_records::mcap::{MessageSchema, descriptor_set};

use super::{About, Echo, Flexed, JointAngle, Scanned, Touched, Truth, Wearer};

/// All messages, those that others are made of first.
fn all() -> [MessageSchema; 9] {
    [
        MessageSchema::describe(Contact::default()),
        MessageSchema::describe(Truth::default()),
        MessageSchema::describe(Touched::default()),
        MessageSchema::describe(Scanned::default()),
        MessageSchema::describe(Echo::default()),
        MessageSchema::describe(Wearer::default()),
        MessageSchema::describe(About::default()),
        MessageSchema::describe(JointAngle::default()),
        MessageSchema::describe(Flexed::default()),
    ]
}

/// A `google.protobuf.FileDescriptorSet` of all messages.
#[must_use]
pub fn descriptor() -> Vec<u8> {
    descriptor_set("palpate/link.proto", &all())
}

/// The messages as a file that `protoc` takes.
#[must_use]
pub fn proto_file() -> String {
    let mut text = String::from("syntax = \"proto3\";\npackage palpate;\n");
    for message in all() {
        // Writing to a string cannot fail.
        let _ = write!(text, "\nmessage {} {{\n", message.name);
        for (number, field) in (1..).zip(message.fields) {
            let several = if field.repeated { "repeated " } else { "" };
            let (kind, name) = (field.kind.word(), field.name);
            let _ = writeln!(text, "  {several}{kind} {name} = {number};");
        }
        text.push_str("}\n");
    }
    text
}
