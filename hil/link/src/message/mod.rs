//! What crosses the network: protocol buffers (proto3), as in a recording. Bytes only.
//!
//! Every message begins with the version. A field that is not known is passed over, a field that is missing is zero.

mod echo;
mod frame;
mod schema;
mod wearer;

pub use echo::Echo;
pub use frame::{Body, Frame, Truth};
pub use schema::{ABOUT, ECHO, SCANNED, Schema, TOUCHED, WEARER, descriptor, proto_file};
pub use wearer::{About, Wearer};

use palpate_records::mcap::proto::{Fields, Value};

/// Version of the messages; grows when one changes its meaning.
pub const VERSION: u32 = 1;

/// Bytes of a message at most: a scan of ten thousand taxels. More is refused before it is looked at.
pub const MOST_BYTES: usize = 1 << 16;

/// The encoding as zenoh names it, for a message of this name.
#[must_use]
pub fn encoding(name: &str) -> String {
    format!("application/protobuf;palpate.{name}")
}

/// The numbers of the fields of a message that has nothing but numbers and text; `None` where it is damaged.
fn each<'a>(bytes: &'a [u8], mut take: impl FnMut(u32, Value<'a>) -> Option<()>) -> Option<()> {
    for field in Fields::new(bytes) {
        let (number, value) = field?;
        take(number, value)?;
    }
    Some(())
}

/// A number, or `None` for a value of another kind.
const fn number(value: Value<'_>) -> Option<u64> {
    match value {
        Value::Number(number) => Some(number),
        _ => None,
    }
}

/// A floating-point number.
const fn double(value: Value<'_>) -> Option<f64> {
    match value {
        Value::Fixed64(bits) => Some(f64::from_bits(bits)),
        _ => None,
    }
}

/// Text.
fn text(value: Value<'_>) -> Option<String> {
    match value {
        Value::Data(bytes) => String::from_utf8(bytes.to_vec()).ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
