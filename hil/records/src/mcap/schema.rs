//! The messages of a recording: one table, from which both the descriptors in the file and the documentation
//! follow. A field's number is its place in the table; new fields come at the end.

use super::proto::Message;

/// Kinds of field, by their number in `descriptor.proto`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// 64-bit floating point.
    Double = 1,
    /// 64-bit whole number.
    Uint64 = 4,
    /// True or false.
    Bool = 8,
    /// Text.
    String = 9,
    /// Bytes.
    Bytes = 12,
    /// 32-bit whole number.
    Uint32 = 13,
    /// One [`FieldKind::Uint32`] for each taxel.
    Counts,
}

/// A message: its full name and its fields.
#[derive(Clone, Copy, Debug)]
pub struct Schema {
    /// Name within the package `palpate`.
    pub name: &'static str,
    /// Names and kinds of the fields, numbered from 1.
    pub fields: &'static [(&'static str, FieldKind)],
}

/// The package of all messages but the log's.
pub const PACKAGE: &str = "palpate";

use FieldKind::{Bool, Bytes, Counts, Double, String, Uint32, Uint64};

/// A frame on a sensor bus.
pub const CAN: Schema = Schema {
    name: "CanFrame",
    fields: &[("bus", Uint32), ("id", Uint32), ("data", Bytes)],
};
/// A complete scan that went through the core.
pub const FRAME: Schema = Schema {
    name: "Frame",
    fields: &[
        ("frame", Uint32),
        ("in_contact", Uint32),
        ("peak_counts", Uint32),
    ],
};
/// A contact that the compression found in a frame.
pub const CONTACT: Schema = Schema {
    name: "Contact",
    fields: &[
        ("frame", Uint32),
        ("module", Uint32),
        ("contact", Uint32),
        ("x_mm", Double),
        ("y_mm", Double),
        ("intensity", Double),
        ("level", Uint32),
        ("members", Uint32),
    ],
};
/// Where an emulated skin was truly touched.
pub const TRUTH: Schema = Schema {
    name: "Truth",
    fields: &[("x_mm", Double), ("y_mm", Double), ("force_n", Double)],
};
/// What a wire's channel was told, beside what had been asked; ticks of 4096 to a period, which is in ns.
pub const SCHEDULE: Schema = Schema {
    name: "Schedule",
    fields: &[
        ("board", Uint32),
        ("channel", Uint32),
        ("requested", Uint32),
        ("applied", Uint32),
        ("on", Uint32),
        ("off", Uint32),
        ("until_us", Uint64),
        ("reason", String),
        ("pulses", Uint64),
        ("period", Uint64),
        ("requested_until_us", Uint64), // 0 where it is `until_us`
        ("current_ma", Uint32),         // 0 where the amplifier has a current of its own
    ],
};
/// A board's PRE_SCALE was set, or all of its outputs went off at once.
pub const BOARD: Schema = Schema {
    name: "Board",
    fields: &[
        ("board", Uint32),
        ("pre_scale", Uint32),
        ("all_off", String),
    ],
};
/// An output changed.
pub const PIN: Schema = Schema {
    name: "Pin",
    fields: &[("high", Bool)],
};
/// A temperature.
pub const TEMPERATURE: Schema = Schema {
    name: "Temperature",
    fields: &[("celsius", Double)],
};
/// What a person would feel of an onset; NaN for nothing.
pub const FELT: Schema = Schema {
    name: "Felt",
    fields: &[
        ("target_x_mm", Double),
        ("target_y_mm", Double),
        ("inside", Bool),
        ("felt", Bool),
        ("energy_x_mm", Double),
        ("energy_y_mm", Double),
        ("amplitude_x_mm", Double),
        ("amplitude_y_mm", Double),
        ("energy_permille", Uint32), // requested
        ("applied_permille", Uint32),
        ("felt_permille", Uint32),
        ("level_db", Double),
        ("tap", Bool),
    ],
};
/// One message of an I2C transfer.
pub const I2C: Schema = Schema {
    name: "I2c",
    fields: &[
        ("bus", Uint32),
        ("address", Uint32),
        ("read", Bool),
        ("data", Bytes),
        ("end_ns", Uint64),
        ("error", String),
    ],
};

/// What a module's taxels read in a frame, raw counts, and their distance from the reference.
pub const TAXELS: Schema = Schema {
    name: "Taxels",
    fields: &[
        ("x", Counts),
        ("y", Counts),
        ("z", Counts),
        ("relative", Counts),
    ],
};

/// A joint's angle; in a recording of a run with joints.
pub const JOINT: Schema = Schema {
    name: "Joint",
    fields: &[("degrees", Double)],
};

/// A Peltier module under the fingertip; in a recording of a run with one. NaN where nothing is aimed at, and a current
/// that cools is positive.
pub const FACE: Schema = Schema {
    name: "Face",
    fields: &[
        ("celsius", Double),
        ("aim_celsius", Double),
        ("sink_celsius", Double),
        ("ampere", Double),
    ],
};

/// All of the package but what a recording has for each module, of joints and of a Peltier module.
pub const ALL: [Schema; 10] = [
    CAN,
    FRAME,
    CONTACT,
    TRUTH,
    SCHEDULE,
    BOARD,
    PIN,
    TEMPERATURE,
    FELT,
    I2C,
];

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

impl Schema {
    /// The full name, as the file's schema has it.
    pub fn full_name(&self) -> std::string::String {
        format!("{PACKAGE}.{}", self.name)
    }

    /// A `google.protobuf.FileDescriptorSet` of this message alone.
    pub fn descriptor(&self) -> Vec<u8> {
        let mut message = Message::default();
        message.text(1, self.name);
        for (number, (name, kind)) in (1..).zip(self.fields) {
            let repeated = *kind == Counts;
            let kind = if repeated { Uint32 } else { *kind } as u32;
            let of = Field {
                name,
                number,
                kind,
                repeated,
            };
            message.inner(2, &field(&of, None));
        }
        let name = format!("{PACKAGE}/{}.proto", self.name);
        let mut set = Message::default();
        set.inner(1, &file(&name, PACKAGE, "", &[message]));
        set.bytes().to_vec()
    }
}
