//! A message's fields in one description: how the message is written, how it is read and its descriptor follow from it.
//! A field's number is its place in the description; new fields come at the end.

use std::io;
use std::mem::discriminant;

use super::container::Store;
use super::proto::{Fields, Message, Value};
use super::schema::{Field, field, file};
use crate::trace::PlaceUm;

/// The package of all messages but Foxglove's.
const PACKAGE: &str = "palpate";

/// Most fields of a message.
const FIELDS: usize = 16;

/// Kinds of field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// 64-bit floating point.
    Double,
    /// 64-bit whole number.
    Uint64,
    /// True or false.
    Bool,
    /// Text.
    String,
    /// Bytes.
    Bytes,
    /// 32-bit whole number.
    Uint32,
    /// One [`FieldKind::Uint32`] for each taxel, packed.
    Counts,
    /// Another message, by its name within the package `palpate`.
    Message(&'static str),
}

impl FieldKind {
    /// The word of protocol buffers; a message has its name.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Double => "double",
            Self::Uint64 => "uint64",
            Self::Bool => "bool",
            Self::String => "string",
            Self::Bytes => "bytes",
            Self::Uint32 | Self::Counts => "uint32",
            Self::Message(name) => name,
        }
    }
}

/// A message, field by field.
pub trait Described<'a> {
    /// Name of the message within the package `palpate`.
    const NAME: &'static str;

    /// Shows `visit` every field, in the order of their numbers, and takes what it gives for them.
    fn fields(&mut self, visit: &mut impl Visit<'a>);
}

/// A walk over the fields of a message: to write, to read or to list them.
pub trait Visit<'a> {
    /// The value that a field is to have in place of this one, of the same variant; `None` where this one stays.
    fn field(&mut self, name: &'static str, kind: FieldKind, value: Value<'_>)
    -> Option<Value<'a>>;

    /// A field with several values, each of which `show` shows as a field of its own. A reader takes at most `most`. With a
    /// `most` of 1 it is a field that may be absent.
    fn several<T: Default>(
        &mut self,
        values: &mut Vec<T>,
        most: usize,
        show: impl Fn(&mut Self, &mut T),
    );

    /// Says that the message is damaged unless this holds.
    fn require(&mut self, _holds: bool) {}

    /// A whole number.
    fn whole<N>(&mut self, name: &'static str, value: &mut N)
    where
        N: Copy + Into<u64> + TryFrom<u64>,
    {
        let kind = match size_of::<N>() {
            8 => FieldKind::Uint64,
            _ => FieldKind::Uint32,
        };
        let now = Value::Number((*value).into());
        if let Some(Value::Number(number)) = self.field(name, kind, now) {
            match N::try_from(number) {
                Ok(number) => *value = number,
                Err(_) => self.require(false),
            }
        }
    }

    /// True or false.
    fn truth(&mut self, name: &'static str, value: &mut bool) {
        let now = Value::Number((*value).into());
        if let Some(number) = self.field(name, FieldKind::Bool, now) {
            *value = number != Value::Number(0);
        }
    }

    /// A number.
    fn real(&mut self, name: &'static str, value: &mut f64) {
        let now = Value::Fixed64(value.to_bits());
        if let Some(Value::Fixed64(bits)) = self.field(name, FieldKind::Double, now) {
            *value = f64::from_bits(bits);
        }
    }

    /// A number of single precision.
    fn single(&mut self, name: &'static str, value: &mut f32) {
        let mut real = f64::from(*value);
        self.real(name, &mut real);
        *value = real as f32;
    }

    /// A number, of which this is the thousandths.
    fn milli<N>(&mut self, name: &'static str, value: &mut N)
    where
        N: Copy + Into<f64> + TryFrom<i64>,
    {
        let mut real = (*value).into() / 1e3;
        self.real(name, &mut real);
        match N::try_from((real * 1e3).round() as i64) {
            Ok(thousandths) => *value = thousandths,
            Err(_) => self.require(false),
        }
    }

    /// A number in thousandths, or NaN for `None`.
    fn maybe_milli(&mut self, name: &'static str, value: &mut Option<i32>) {
        let mut real = value.map_or(f64::NAN, |milli| f64::from(milli) / 1e3);
        self.real(name, &mut real);
        *value = (!real.is_nan()).then(|| (real * 1e3).round() as i32);
    }

    /// A place, millimetres.
    fn place(&mut self, [x, y]: [&'static str; 2], place: &mut PlaceUm) {
        self.milli(x, &mut place.x);
        self.milli(y, &mut place.y);
    }

    /// A place in millimetres, or NaN for `None`.
    fn maybe_place(&mut self, [x, y]: [&'static str; 2], place: &mut Option<PlaceUm>) {
        let (mut right, mut up) = (place.map(|p| p.x), place.map(|p| p.y));
        self.maybe_milli(x, &mut right);
        self.maybe_milli(y, &mut up);
        *place = right.zip(up).map(|(x, y)| PlaceUm { x, y });
    }

    /// Text.
    fn text<T: AsRef<str> + From<&'a str>>(&mut self, name: &'static str, value: &mut T) {
        let now = Value::Data(value.as_ref().as_bytes());
        if let Some(Value::Data(bytes)) = self.field(name, FieldKind::String, now) {
            match str::from_utf8(bytes) {
                Ok(text) => *value = T::from(text),
                Err(_) => self.require(false),
            }
        }
    }

    /// Bytes, and what is packed into bytes.
    fn data<T: AsRef<[u8]> + From<&'a [u8]>>(
        &mut self,
        name: &'static str,
        kind: FieldKind,
        value: &mut T,
    ) {
        let now = Value::Data(value.as_ref());
        if let Some(Value::Data(bytes)) = self.field(name, kind, now) {
            *value = T::from(bytes);
        }
    }

    /// A message inside.
    fn message<T: Described<'a> + Default>(&mut self, name: &'static str, value: &mut T) {
        let (kind, now) = (FieldKind::Message(T::NAME), encoded(value));
        if let Some(Value::Data(bytes)) = self.field(name, kind, Value::Data(now.bytes())) {
            match decode(bytes) {
                Some(message) => *value = message,
                None => self.require(false),
            }
        }
    }
}

/// Writes a message's fields.
struct Encode<'m> {
    message: &'m mut Message,
    number: u32,
}

impl<'a> Visit<'a> for Encode<'_> {
    fn field(&mut self, _: &'static str, kind: FieldKind, value: Value<'_>) -> Option<Value<'a>> {
        self.number += 1;
        match (value, kind) {
            (Value::Number(n), _) => self.message.uint(self.number, n),
            (Value::Fixed64(bits), _) => self.message.double(self.number, f64::from_bits(bits)),
            (Value::Fixed32(n), _) => self.message.fixed32(self.number, n),
            (Value::Data(bytes), FieldKind::Message(_)) => self.message.part(self.number, bytes),
            (Value::Data(bytes), _) => self.message.data(self.number, bytes),
        };
        None
    }

    fn several<T: Default>(
        &mut self,
        values: &mut Vec<T>,
        _: usize,
        show: impl Fn(&mut Self, &mut T),
    ) {
        let before = self.number;
        for value in values {
            self.number = before;
            show(self, value);
        }
        self.number = before + 1;
    }
}

/// Writes a message in place of what was written before.
pub fn encode<'a>(of: &mut impl Described<'a>, message: &mut Message) {
    message.clear();
    of.fields(&mut Encode { message, number: 0 });
}

/// Writes a message.
pub fn encoded<'a>(of: &mut impl Described<'a>) -> Message {
    let mut message = Message::default();
    encode(of, &mut message);
    message
}

/// Gives fields what stands in a message; what was left out is 0 or empty, as proto3 has it.
struct Decode<'a> {
    message: &'a [u8],
    /// The last value of each field.
    found: [Option<Value<'a>>; FIELDS],
    number: usize,
    is_whole: bool,
}

impl<'a> Visit<'a> for Decode<'a> {
    fn field(&mut self, _: &'static str, _: FieldKind, value: Value<'_>) -> Option<Value<'a>> {
        let found = self.found.get(self.number).copied().flatten();
        self.number += 1;
        let none = match value {
            Value::Number(_) => Value::Number(0),
            Value::Fixed64(_) => Value::Fixed64(0),
            Value::Fixed32(_) => Value::Fixed32(0),
            Value::Data(_) => Value::Data(&[]),
        };
        let found = found.unwrap_or(none);
        let is_alike = discriminant(&found) == discriminant(&none);
        self.require(is_alike);
        is_alike.then_some(found)
    }

    fn several<T: Default>(
        &mut self,
        values: &mut Vec<T>,
        most: usize,
        show: impl Fn(&mut Self, &mut T),
    ) {
        let before = self.number;
        let own = |(number, _): &(u32, Value<'_>)| *number as usize == before + 1;
        values.clear();
        for (_, value) in Fields::new(self.message).flatten().filter(own).take(most) {
            self.number = before;
            if let Some(found) = self.found.get_mut(before) {
                *found = Some(value);
            }
            let mut one = T::default();
            show(self, &mut one);
            values.push(one);
        }
        self.number = before + 1;
    }

    fn require(&mut self, holds: bool) {
        self.is_whole &= holds;
    }
}

/// Reads a message; `None` for a damaged one.
pub fn decode<'a, T: Described<'a> + Default>(message: &'a [u8]) -> Option<T> {
    let mut decode = Decode {
        message,
        found: [None; FIELDS],
        number: 0,
        is_whole: true,
    };
    for field in Fields::new(message) {
        let (number, value) = field?;
        // Later ones are of a later version.
        if let Some(found) = decode.found.get_mut(number as usize - 1) {
            *found = Some(value);
        }
    }
    let mut read = T::default();
    read.fields(&mut decode);
    decode.is_whole.then_some(read)
}

/// A field of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageField {
    /// The field's name.
    pub name: &'static str,
    /// The field's kind.
    pub kind: FieldKind,
    /// `true` for a field that may have several values.
    pub repeated: bool,
}

/// A message as a list of its fields, numbered from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MessageSchema {
    /// The message's name within the package `palpate`.
    pub name: &'static str,
    /// The message's fields, in the order of their numbers.
    pub fields: Vec<MessageField>,
}

impl<'a> Visit<'a> for MessageSchema {
    fn field(&mut self, name: &'static str, kind: FieldKind, _: Value<'_>) -> Option<Value<'a>> {
        let repeated = kind == FieldKind::Counts;
        self.fields.push(MessageField {
            name,
            kind,
            repeated,
        });
        None
    }

    fn several<T: Default>(
        &mut self,
        _: &mut Vec<T>,
        most: usize,
        show: impl Fn(&mut Self, &mut T),
    ) {
        show(self, &mut T::default());
        if let Some(field) = self.fields.last_mut() {
            field.repeated = most > 1;
        }
    }
}

impl MessageSchema {
    /// The fields that a message shows.
    pub fn describe<'a, T: Described<'a>>(mut message: T) -> Self {
        let (name, fields) = (T::NAME, Vec::new());
        let mut schema = Self { name, fields };
        message.fields(&mut schema);
        schema
    }

    fn descriptor(&self) -> Message {
        let mut message = Message::default();
        message.text(1, self.name);
        for (number, own) in (1..).zip(&self.fields) {
            let kind = match own.kind {
                FieldKind::Message(name) => format!("{PACKAGE}.{name}"),
                scalar => scalar.word().to_owned(),
            };
            let of = Field {
                name: own.name,
                number,
                kind: &kind,
                is_enum: false,
                repeated: own.repeated,
            };
            message.inner(2, &field(&of));
        }
        message
    }
}

/// A `google.protobuf.FileDescriptorSet` of messages in one file of this name.
#[must_use]
pub fn descriptor_set(name: &str, messages: &[MessageSchema]) -> Vec<u8> {
    let messages: Vec<_> = messages.iter().map(MessageSchema::descriptor).collect();
    let mut set = Message::default();
    set.inner(1, &file(name, PACKAGE, "", &messages));
    set.bytes().to_vec()
}

/// The full name of a message, as a file's schema has it.
#[must_use]
pub fn full_name<'a, T: Described<'a>>() -> String {
    format!("{PACKAGE}.{}", T::NAME)
}

/// Writes the schema of a message, a `google.protobuf.FileDescriptorSet` of it alone; returns its number.
pub(super) fn schema<'a, T: Described<'a>>(store: &mut impl Store, of: T) -> io::Result<u16> {
    let file = format!("{PACKAGE}/{}.proto", T::NAME);
    let set = descriptor_set(&file, &[MessageSchema::describe(of)]);
    store.schema(&full_name::<T>(), &set)
}
