//! Foxglove's own messages, as it publishes them: one table, from which the descriptors in the file follow.
//! `ci/readers` holds every field against the published ones.

use super::proto::Message;
use super::schema::{Field, field, file};

/// Messages that log panels show.
pub const LOG: &str = "foxglove.Log";
/// Points with a value each.
pub const CLOUD: &str = "foxglove.PointCloud";
/// Shapes of a scene.
pub const SCENE: &str = "foxglove.SceneUpdate";
/// Name of the message for the place of a frame of reference in another.
pub const TRANSFORM: &str = "foxglove.FrameTransform";

/// A line per message or enumeration: its name, its fields in the order of their numbers. A star is repeated.
const TYPES: &str = include_str!("foxglove.txt");

/// The values of an enumeration.
fn values(name: &str, words: &str) -> Message {
    let mut all = Message::default();
    all.text(1, name);
    for (name, number) in words.split(' ').filter_map(|w| w.split_once('=')) {
        let mut value = Message::default();
        value
            .text(1, name)
            .uint(2, number.parse::<u32>().unwrap_or(0));
        all.inner(2, &value);
    }
    all
}

/// The messages of a package.
fn package(package: &str) -> Vec<Message> {
    let prefix = format!("{package}.");
    let mut found = Vec::new();
    for line in TYPES.lines() {
        let Some((name, fields)) = line.strip_prefix(&prefix).and_then(|l| l.split_once(' '))
        else {
            continue;
        };
        let mut message = Message::default();
        message.text(1, name);
        for (number, word) in (1..).zip(fields.split(' ')) {
            let (name, of) = word.split_once(':').unwrap_or((word, "string"));
            let kind = of.trim_start_matches('*');
            let of = Field {
                name,
                number,
                kind,
                is_enum: TYPES.contains(&format!("enum {kind} ")),
                repeated: of.starts_with('*'),
            };
            message.inner(2, &field(&of));
        }
        let nested = format!("enum {prefix}{name}.");
        for line in TYPES.lines().filter_map(|l| l.strip_prefix(&nested)) {
            let (name, words) = line.split_once(' ').unwrap_or((line, ""));
            message.inner(4, &values(name, words));
        }
        found.push(message);
    }
    found
}

/// A `google.protobuf.FileDescriptorSet` of all of them.
pub fn descriptor() -> Vec<u8> {
    let google = "google/protobuf/time.proto";
    let mut set = Message::default();
    set.inner(
        1,
        &file(google, "google.protobuf", "", &package("google.protobuf")),
    )
    .inner(
        1,
        &file(
            "foxglove/foxglove.proto",
            "foxglove",
            google,
            &package("foxglove"),
        ),
    );
    set.bytes().to_vec()
}
