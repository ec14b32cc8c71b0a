//! Messages of the network: protocol buffers (proto3), as in a recording. Bytes only.
//!
//! Every message begins with the version. A field that is not known is passed over, a field that is missing is zero.

mod echo;
mod flexed;
mod frame;
mod schema;
mod wearer;

pub use echo::Echo;
pub use flexed::{Flexed, JointAngle};
pub use frame::{Body, Frame, Truth};
pub(crate) use frame::{Scanned, Touched};
pub use schema::{descriptor, proto_file};
pub use wearer::{About, Wearer};

use palpate_records::mcap::{Described, full_name};

/// Version of the messages; grows when one changes its meaning.
pub const VERSION: u32 = 1;

/// Most bytes of a message: a scan of ten thousand taxels. A longer one is refused before it is looked at.
pub const MOST_BYTES: usize = 1 << 16;

/// The encoding of a message as zenoh names it.
#[must_use]
pub fn encoding<'a, T: Described<'a>>() -> String {
    format!("application/protobuf;{}", full_name::<T>())
}

#[cfg(test)]
mod tests;
