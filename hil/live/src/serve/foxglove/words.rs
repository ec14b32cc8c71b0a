//! Messages of the [Foxglove WebSocket protocol](https://github.com/foxglove/ws-protocol), version 1:
//! objects in text say what there is, and binary messages carry data.

use data_encoding::BASE64;
use serde::{Deserialize, Serialize};
use serde_json::json;
use tungstenite::Message;

/// Names of the protocol in a handshake, the newest first. Version 1 has had both.
pub(super) const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// First byte of a message with data, and of one with the time.
const DATA: u8 = 1;
const TIME: u8 = 2;

/// A topic as clients hear of it.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Channel {
    /// Number of the topic, never used for another one.
    pub id: u32,
    pub topic: String,
    encoding: &'static str,
    schema_name: String,
    schema: String,
    schema_encoding: &'static str,
}

impl Channel {
    /// A topic of protobuf messages, with their `google.protobuf.FileDescriptorSet`.
    pub(super) fn new(id: u32, topic: &str, schema_name: &str, descriptor: &[u8]) -> Self {
        Self {
            id,
            topic: topic.to_owned(),
            encoding: "protobuf",
            schema_name: schema_name.to_owned(),
            schema: BASE64.encode(descriptor),
            schema_encoding: "protobuf",
        }
    }
}

/// Message of a client.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(super) enum Said {
    Subscribe {
        subscriptions: Vec<Subscription>,
    },
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        subscription_ids: Vec<u32>,
    },
    /// A request for something that this server does not offer.
    #[serde(other)]
    Other,
}

/// Wish of a client for the messages of a topic, under a number of the client's own.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Subscription {
    pub id: u32,
    pub channel_id: u32,
}

/// Importance of a remark, by the protocol's numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Level {
    Info = 0,
    Warning = 1,
    Error = 2,
}

fn text(value: &serde_json::Value) -> Message {
    Message::text(value.to_string())
}

/// First message to every client. `session` tells one program from the next at the same address.
pub(super) fn server_info(session: &str) -> Message {
    let name = concat!("palpate ", env!("CARGO_PKG_VERSION"));
    text(
        &json!({ "op": "serverInfo", "name": name, "capabilities": ["time"], "sessionId": session }),
    )
}

/// Tells which topics there are from now on.
pub(super) fn advertise(channels: &[Channel]) -> Message {
    text(&json!({ "op": "advertise", "channels": channels }))
}

/// Tells which topics there are no more.
pub(super) fn unadvertise(channels: &[Channel]) -> Message {
    let ids: Vec<_> = channels.iter().map(|channel| channel.id).collect();
    text(&json!({ "op": "unadvertise", "channelIds": ids }))
}

/// A remark that the client shows to its user.
pub(super) fn status(level: Level, message: &str) -> Message {
    text(&json!({ "op": "status", "level": level as u8, "message": message }))
}

/// A message of a topic, under the client's number of its subscription; the time in nanoseconds.
pub(super) fn data(subscription: u32, t_ns: u64, payload: &[u8]) -> Message {
    let mut bytes = Vec::with_capacity(13 + payload.len());
    bytes.push(DATA);
    bytes.extend(subscription.to_le_bytes());
    bytes.extend(t_ns.to_le_bytes());
    bytes.extend(payload);
    Message::binary(bytes)
}

/// The time of the run, nanoseconds: clients show it in place of their own clock.
pub(super) fn time(t_ns: u64) -> Message {
    let mut bytes = vec![TIME];
    bytes.extend(t_ns.to_le_bytes());
    Message::binary(bytes)
}
