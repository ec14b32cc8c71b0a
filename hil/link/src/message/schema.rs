//! The messages as tables: descriptors for recordings, and text for people and other languages.

use std::fmt::Write as _;

use palpate_records::mcap::proto::Message;

/// Kinds of field, by their number in `descriptor.proto`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the words are those of protocol buffers
pub enum Kind {
    Double = 1,
    Uint64 = 4,
    String = 9,
    Message = 11,
    Bytes = 12,
    Uint32 = 13,
}

/// A field: name, kind, the message that it is, whether there are several.
type Row = (&'static str, Kind, &'static str, bool);

/// A message: its name within the package `palpate`, and its fields, numbered from 1.
#[derive(Clone, Copy, Debug)]
pub struct Schema {
    /// The name.
    pub name: &'static str,
    fields: &'static [Row],
}

use Kind::{Bytes, Double, String, Uint32, Uint64};

const fn one(name: &'static str, kind: Kind) -> Row {
    (name, kind, "", false)
}

const HEAD: [Row; 7] = [
    one("version", Uint32),
    one("session", Uint64),
    one("sequence", Uint64),
    one("sent_us", Uint64),
    one("taken_us", Uint64),
    one("layout", Uint64),
    ("truth", Kind::Message, "Truth", false),
];

/// The contacts of a frame.
pub const TOUCHED: Schema = Schema {
    name: "Touched",
    fields: &[
        HEAD[0],
        HEAD[1],
        HEAD[2],
        HEAD[3],
        HEAD[4],
        HEAD[5],
        HEAD[6],
        ("contacts", Kind::Message, "Contact", true),
    ],
};
/// One module's readings.
pub const SCANNED: Schema = Schema {
    name: "Scanned",
    fields: &[
        HEAD[0],
        HEAD[1],
        HEAD[2],
        HEAD[3],
        HEAD[4],
        HEAD[5],
        HEAD[6],
        one("module", Uint32),
        ("x", Uint32, "", true),
        ("y", Uint32, "", true),
        ("z", Uint32, "", true),
    ],
};
/// When a publisher heard a wearer.
pub const ECHO: Schema = Schema {
    name: "Echo",
    fields: &[
        one("version", Uint32),
        one("session", Uint64),
        one("wearer", Uint64),
        one("said_us", Uint64),
        one("heard_us", Uint64),
    ],
};
/// What a wearer's machine says.
pub const WEARER: Schema = Schema {
    name: "Wearer",
    fields: &[
        one("version", Uint32),
        one("session", Uint64),
        one("said_us", Uint64),
        one("feels", Uint64),
        ("refused", Uint64, "", true),
        one("stopped", String),
        one("trouble", String),
    ],
};
/// What a publisher says of itself.
pub const ABOUT: Schema = Schema {
    name: "About",
    fields: &[
        one("version", Uint32),
        one("session", Uint64),
        one("layout", Uint64),
        one("layout_name", String),
        one("scene", String),
        one("kind", String),
        ("rest", Bytes, "", true),
    ],
};
/// A contact, as in a recording of a run.
const CONTACT: Schema = Schema {
    name: "Contact",
    fields: &[
        one("frame", Uint32),
        one("module", Uint32),
        one("contact", Uint32),
        one("x_mm", Double),
        one("y_mm", Double),
        one("intensity", Double),
        one("level", Uint32),
        one("members", Uint32),
    ],
};
/// Where an emulated skin is touched, as in a recording of a run.
const TRUTH: Schema = Schema {
    name: "Truth",
    fields: &[
        one("x_mm", Double),
        one("y_mm", Double),
        one("force_n", Double),
    ],
};

/// All of them, those that others are made of first.
const ALL: [Schema; 7] = [CONTACT, TRUTH, TOUCHED, SCANNED, ECHO, WEARER, ABOUT];

impl Schema {
    /// The full name.
    #[must_use]
    pub fn full_name(&self) -> std::string::String {
        format!("palpate.{}", self.name)
    }

    fn message(&self) -> Message {
        const OPTIONAL: u32 = 1;
        const REPEATED: u32 = 3;
        let mut message = Message::default();
        message.text(1, self.name);
        for (number, (name, kind, of, several)) in (1_u32..).zip(self.fields) {
            let mut field = Message::default();
            field
                .text(1, name)
                .uint(3, number)
                .uint(4, if *several { REPEATED } else { OPTIONAL })
                .uint(5, *kind as u32);
            if !of.is_empty() {
                field.text(6, &format!(".palpate.{of}"));
            }
            message.inner(2, &field);
        }
        message
    }
}

/// A `google.protobuf.FileDescriptorSet` of all messages.
#[must_use]
pub fn descriptor() -> Vec<u8> {
    let mut file = Message::default();
    file.text(1, "palpate/link.proto").text(2, "palpate");
    for schema in ALL {
        file.inner(4, &schema.message());
    }
    file.text(12, "proto3");
    let mut set = Message::default();
    set.inner(1, &file);
    set.bytes().to_vec()
}

/// The messages as a file that `protoc` takes.
#[must_use]
pub fn proto_file() -> std::string::String {
    let mut text = std::string::String::from("syntax = \"proto3\";\npackage palpate;\n");
    for schema in ALL {
        // Writing to a string cannot fail.
        let _ = write!(text, "\nmessage {} {{\n", schema.name);
        for (number, (name, kind, of, several)) in (1..).zip(schema.fields) {
            let kind = match kind {
                Double => "double",
                Uint64 => "uint64",
                String => "string",
                Bytes => "bytes",
                Uint32 => "uint32",
                Kind::Message => of,
            };
            let several = if *several { "repeated " } else { "" };
            let _ = writeln!(text, "  {several}{kind} {name} = {number};");
        }
        text.push_str("}\n");
    }
    text
}
