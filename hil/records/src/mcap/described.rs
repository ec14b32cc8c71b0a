//! A message's fields in one description: how the message is written, how it is read and its descriptor in the file follow
//! from it. A field's number is its place in the description; new fields come at the end.

use std::io::{self, Write};
use std::mem::discriminant;

use super::container::Container;
use super::proto::{Fields, Message, Value};
use super::schema::{Field, field, file};
use crate::trace::PlaceUm;

/// The package of all messages but Foxglove's.
const PACKAGE: &str = "palpate";

/// Most fields of a message.
const FIELDS: usize = 16;

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
    /// One [`FieldKind::Uint32`] for each taxel, packed.
    Counts,
}

/// A message of a recording, field by field.
pub trait Described<'a> {
    /// Name of the message within the package `palpate`.
    const NAME: &'static str;

    /// Shows `visit` every field, in the order of their numbers, and takes what it gives for them.
    fn fields(&mut self, visit: &mut impl Visit<'a>);
}

/// A walk over the fields of a message: to write, to read or to list them.
pub trait Visit<'a> {
    /// The value that a field is to have in place of this one: another of the same variant.
    fn field(&mut self, name: &'static str, kind: FieldKind, value: Value<'a>) -> Value<'a>;

    /// Says that the message is damaged unless this holds.
    fn require(&mut self, holds: bool);

    /// A whole number.
    fn whole<N>(&mut self, name: &'static str, value: &mut N)
    where
        N: Copy + Into<u64> + TryFrom<u64>,
    {
        let kind = match size_of::<N>() {
            8 => FieldKind::Uint64,
            _ => FieldKind::Uint32,
        };
        if let Value::Number(number) = self.field(name, kind, Value::Number((*value).into())) {
            match N::try_from(number) {
                Ok(number) => *value = number,
                Err(_) => self.require(false),
            }
        }
    }

    /// True or false.
    fn truth(&mut self, name: &'static str, value: &mut bool) {
        let number = Value::Number((*value).into());
        *value = self.field(name, FieldKind::Bool, number) != Value::Number(0);
    }

    /// A number.
    fn real(&mut self, name: &'static str, value: &mut f64) {
        let bits = Value::Fixed64(value.to_bits());
        if let Value::Fixed64(bits) = self.field(name, FieldKind::Double, bits) {
            *value = f64::from_bits(bits);
        }
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
    fn text(&mut self, name: &'static str, value: &mut &'a str) {
        let mut bytes = value.as_bytes();
        self.data(name, FieldKind::String, &mut bytes);
        match str::from_utf8(bytes) {
            Ok(text) => *value = text,
            Err(_) => self.require(false),
        }
    }

    /// Bytes, and what is packed into bytes.
    fn data(&mut self, name: &'static str, kind: FieldKind, value: &mut &'a [u8]) {
        if let Value::Data(bytes) = self.field(name, kind, Value::Data(value)) {
            *value = bytes;
        }
    }
}

/// Writes a message's fields.
struct Encode<'m> {
    message: &'m mut Message,
    number: u32,
}

impl<'a> Visit<'a> for Encode<'_> {
    fn field(&mut self, _: &'static str, _: FieldKind, value: Value<'a>) -> Value<'a> {
        self.number += 1;
        match value {
            Value::Number(n) => self.message.uint(self.number, n),
            Value::Fixed64(bits) => self.message.double(self.number, f64::from_bits(bits)),
            Value::Fixed32(n) => self.message.fixed32(self.number, n),
            Value::Data(bytes) => self.message.data(self.number, bytes),
        };
        value
    }

    fn require(&mut self, _: bool) {}
}

/// Writes a message in place of what was written before.
pub(super) fn encode<'a>(mut of: impl Described<'a>, message: &mut Message) {
    message.clear();
    of.fields(&mut Encode { message, number: 0 });
}

/// Gives fields what stands in a message; what was left out is 0 or empty, as proto3 has it.
struct Decode<'a> {
    found: [Option<Value<'a>>; FIELDS],
    number: usize,
    is_whole: bool,
}

impl<'a> Visit<'a> for Decode<'a> {
    fn field(&mut self, _: &'static str, _: FieldKind, value: Value<'a>) -> Value<'a> {
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
        if is_alike { found } else { none }
    }

    fn require(&mut self, holds: bool) {
        self.is_whole &= holds;
    }
}

/// Reads a message; `None` for a damaged one.
pub fn decode<'a, T: Described<'a> + Default>(message: &'a [u8]) -> Option<T> {
    let mut decode = Decode {
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

/// Lists fields.
struct Describe {
    message: Message,
    number: u32,
}

impl<'a> Visit<'a> for Describe {
    fn field(&mut self, name: &'static str, kind: FieldKind, value: Value<'a>) -> Value<'a> {
        self.number += 1;
        let repeated = kind == FieldKind::Counts;
        let kind = if repeated { FieldKind::Uint32 } else { kind } as u32;
        let of = Field {
            name,
            number: self.number,
            kind,
            repeated,
        };
        self.message.inner(2, &field(&of, None));
        value
    }

    fn require(&mut self, _: bool) {}
}

/// The full name of a message, as the file's schema has it.
pub(super) fn full_name<'a, T: Described<'a>>() -> String {
    format!("{PACKAGE}.{}", T::NAME)
}

/// Writes the schema of a message: a `google.protobuf.FileDescriptorSet` of it alone. Its number.
pub(super) fn schema<'a, T: Described<'a>>(
    container: &mut Container<impl Write>,
    mut of: T,
) -> io::Result<u16> {
    let (message, number) = (Message::default(), 0);
    let mut describe = Describe { message, number };
    describe.message.text(1, T::NAME);
    of.fields(&mut describe);
    let name = format!("{PACKAGE}/{}.proto", T::NAME);
    let mut set = Message::default();
    set.inner(1, &file(&name, PACKAGE, "", &[describe.message]));
    container.schema(&full_name::<T>(), set.bytes())
}
