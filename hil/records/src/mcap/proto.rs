//! Protocol buffers on the wire (proto3): the few kinds of field that the messages use, out and in.

/// A message that is being written. Fields at their default (0, empty) are left out, as proto3 does.
#[derive(Clone, Debug, Default)]
pub struct Message(Vec<u8>);

impl Message {
    /// Starts anew in the same memory.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The message as it stands on the wire.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    /// `uint32`, `uint64`, `bool` or an enumeration.
    pub fn uint(&mut self, field: u32, value: impl Into<u64>) -> &mut Self {
        let value = value.into();
        if value != 0 {
            self.varint(u64::from(field) << 3);
            self.varint(value);
        }
        self
    }

    /// `double`.
    pub fn double(&mut self, field: u32, value: f64) -> &mut Self {
        // Negative zero is no default.
        if value.to_bits() != 0 {
            self.varint(u64::from(field) << 3 | 1);
            self.0.extend(value.to_le_bytes());
        }
        self
    }

    /// `fixed32`.
    pub fn fixed32(&mut self, field: u32, value: u32) -> &mut Self {
        if value != 0 {
            self.varint(u64::from(field) << 3 | 5);
            self.0.extend(value.to_le_bytes());
        }
        self
    }

    /// `bytes`.
    pub fn data(&mut self, field: u32, value: &[u8]) -> &mut Self {
        if value.is_empty() {
            return self;
        }
        self.part(field, value)
    }

    /// `string`.
    pub fn text(&mut self, field: u32, value: &str) -> &mut Self {
        self.data(field, value.as_bytes())
    }

    /// Bytes, also none: a value of a repeated field, and a message inside.
    pub fn part(&mut self, field: u32, bytes: &[u8]) -> &mut Self {
        self.varint(u64::from(field) << 3 | 2);
        self.varint(bytes.len() as u64);
        self.0.extend(bytes);
        self
    }

    /// A message inside, also an empty one.
    pub fn inner(&mut self, field: u32, message: &Self) -> &mut Self {
        self.part(field, &message.0)
    }
}

/// A field of a message that is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// Numbers and booleans.
    Number(u64),
    /// Eight bytes, such as a `double`.
    Fixed64(u64),
    /// Text, bytes and messages.
    Data(&'a [u8]),
    /// Four bytes.
    Fixed32(u32),
}

/// The fields of a message in their order; `None` in place of the first that is damaged, and then no more.
#[derive(Clone, Debug)]
pub struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// Reader over the bytes of a message.
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let (&byte, rest) = self.0.split_first()?;
            self.0 = rest;
            let part = u64::from(byte & 0x7f);
            if shift == 63 && part > 1 {
                return None;
            }
            value |= part << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn field(&mut self) -> Option<(u32, Value<'a>)> {
        let key = self.varint()?;
        let field = u32::try_from(key >> 3).ok().filter(|f| *f > 0)?;
        let value = match key & 7 {
            0 => Value::Number(self.varint()?),
            1 => {
                let (bytes, rest) = self.0.split_first_chunk()?;
                self.0 = rest;
                Value::Fixed64(u64::from_le_bytes(*bytes))
            }
            2 => {
                let length = usize::try_from(self.varint()?).ok()?;
                let (bytes, rest) = self.0.split_at_checked(length)?;
                self.0 = rest;
                Value::Data(bytes)
            }
            5 => {
                let (bytes, rest) = self.0.split_first_chunk()?;
                self.0 = rest;
                Value::Fixed32(u32::from_le_bytes(*bytes))
            }
            _ => return None,
        };
        Some((field, value))
    }
}

/// The bytes of a packed field.
pub fn pack(numbers: impl Iterator<Item = u16>) -> Message {
    let mut packed = Message::default();
    numbers.for_each(|number| packed.varint(number.into()));
    packed
}

/// The numbers of a packed field; `None` where it is damaged.
pub fn packed(bytes: &[u8]) -> Option<Vec<u16>> {
    let mut fields = Fields::new(bytes);
    let mut numbers = Vec::new();
    while !fields.0.is_empty() {
        numbers.push(u16::try_from(fields.varint()?).ok()?);
    }
    Some(numbers)
}

impl<'a> Iterator for Fields<'a> {
    type Item = Option<(u32, Value<'a>)>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() {
            return None;
        }
        let field = self.field();
        if field.is_none() {
            self.0 = &[];
        }
        Some(field)
    }
}

#[cfg(test)]
#[path = "proto_tests.rs"]
mod tests;
