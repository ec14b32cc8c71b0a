//! Clients of a run's topics: one that follows the protocol, and those that do not.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::Duration;

use palpate_records::mcap::Store;
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::handshake::client::Response;
use tungstenite::{Message, WebSocket, client};

use super::client::MOST_WAITING;
use super::run::Channels;
use super::*;

type Socket = WebSocket<TcpStream>;

fn host(foxglove: &Foxglove) -> &str {
    foxglove.url.strip_prefix("ws://").unwrap()
}

fn stream(foxglove: &Foxglove) -> TcpStream {
    let stream = TcpStream::connect(host(foxglove)).unwrap();
    let patience = Some(Duration::from_secs(20));
    stream.set_read_timeout(patience).unwrap();
    stream
}

/// Connects with these fields in place of none; the status of a refusal.
fn connect(
    foxglove: &Foxglove,
    fields: &[(&'static str, &str)],
) -> Result<(Socket, Response), u16> {
    let mut request = foxglove.url.as_str().into_client_request().unwrap();
    for (name, value) in fields {
        request.headers_mut().insert(*name, value.parse().unwrap());
    }
    client(request, stream(foxglove)).map_err(|error| match error {
        tungstenite::HandshakeError::Failure(tungstenite::Error::Http(refused)) => {
            refused.status().as_u16()
        }
        other => panic!("{other}"),
    })
}

const PROTOCOL: (&str, &str) = ("Sec-WebSocket-Protocol", "foxglove.sdk.v1");

fn client_of(foxglove: &Foxglove) -> Socket {
    connect(foxglove, &[PROTOCOL]).unwrap().0
}

/// The next message in text.
fn told(socket: &mut Socket) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            return serde_json::from_str(&text).unwrap();
        }
    }
}

/// The next message with data: subscription, time and payload.
fn given(socket: &mut Socket) -> (u32, u64, Vec<u8>) {
    loop {
        let Message::Binary(bytes) = socket.read().unwrap() else {
            continue;
        };
        if bytes[0] == 1 {
            let number = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
            let time = u64::from_le_bytes(bytes[5..13].try_into().unwrap());
            return (number, time, bytes[13..].to_vec());
        }
    }
}

fn say(socket: &mut Socket, value: &Value) {
    socket.send(Message::text(value.to_string())).unwrap();
}

/// The topics of a run that has begun: `/one` with a message before its begin, and `/two`.
fn begun(foxglove: &Foxglove) -> Channels {
    let mut channels = Channels::new(Arc::clone(&foxglove.hub));
    let schema = channels.schema("palpate.One", b"\x0a\x01x").unwrap();
    assert_eq!(channels.channel(schema, "/one").unwrap(), 0);
    assert_eq!(channels.channel(schema, "/can").unwrap(), 1);
    assert_eq!(channels.channel(schema, "/two").unwrap(), 2);
    channels.message(0, 5, b"first").unwrap();
    channels.advertise();
    channels
}

fn ids(advertised: &Value) -> Vec<u64> {
    let channels = advertised["channels"].as_array().unwrap();
    channels.iter().map(|c| c["id"].as_u64().unwrap()).collect()
}

#[test]
fn a_client_hears_of_topics_subscribes_and_gets_their_messages() {
    let foxglove = Foxglove::open(0).unwrap();
    let (mut socket, response) = connect(&foxglove, &[PROTOCOL]).unwrap();
    assert_eq!(
        response.headers()["Sec-WebSocket-Protocol"],
        "foxglove.sdk.v1"
    );
    let info = told(&mut socket);
    assert_eq!(info["op"], "serverInfo");
    assert_eq!(info["capabilities"], json!(["time"]));
    assert_eq!(
        told(&mut socket),
        json!({ "op": "advertise", "channels": [] })
    );
    let mut run = begun(&foxglove);
    let advertised = told(&mut socket);
    let one = json!({
        "id": 0, "topic": "/one", "encoding": "protobuf", "schemaName": "palpate.One", "schema": "CgF4",
        "schemaEncoding": "protobuf",
    });
    assert_eq!(advertised["channels"][0], one);
    assert_eq!(ids(&advertised), [0, 2], "/can is for files");
    say(
        &mut socket,
        &json!({ "op": "subscribe", "subscriptions": [{ "id": 70, "channelId": 0 }] }),
    );
    assert_eq!(given(&mut socket), (70, 5, b"first".to_vec()));
    run.message(2, 6, b"of another topic").unwrap();
    run.message(0, 7, b"second").unwrap();
    assert_eq!(given(&mut socket), (70, 7, b"second".to_vec()));
    say(
        &mut socket,
        &json!({ "op": "unsubscribe", "subscriptionIds": [70] }),
    );
    say(
        &mut socket,
        &json!({ "op": "subscribe", "subscriptions": [{ "id": 70, "channelId": 2 }] }),
    );
    say(&mut socket, &json!({ "op": "fetchAsset", "uri": "a" }));
    assert_eq!(
        told(&mut socket)["level"],
        1,
        "all words before it are heard"
    );
    run.message(0, 8, b"third").unwrap();
    run.message(2, 9, b"fourth").unwrap();
    assert_eq!(given(&mut socket), (70, 9, b"fourth".to_vec()));
    foxglove.over("it is over");
    assert_eq!(
        told(&mut socket),
        json!({ "op": "status", "level": 0, "message": "it is over" })
    );
}

#[test]
fn another_run_has_topics_with_numbers_of_their_own() {
    let foxglove = Foxglove::open(0).unwrap();
    let _first = begun(&foxglove);
    let old = "foxglove.websocket.v1";
    let (mut socket, response) = connect(&foxglove, &[(PROTOCOL.0, old)]).unwrap();
    assert_eq!(response.headers()["Sec-WebSocket-Protocol"], old);
    assert_eq!(told(&mut socket)["op"], "serverInfo");
    assert_eq!(ids(&told(&mut socket)), [0, 2]);
    let _second = begun(&foxglove);
    assert_eq!(
        told(&mut socket),
        json!({ "op": "unadvertise", "channelIds": [0, 2] })
    );
    assert_eq!(ids(&told(&mut socket)), [3, 5]);
    for channel in [0, 99] {
        let wish = json!([{ "id": 1, "channelId": channel }]);
        say(
            &mut socket,
            &json!({ "op": "subscribe", "subscriptions": wish }),
        );
        let refused = told(&mut socket);
        assert_eq!(refused["level"], 2);
        let expected = format!("subscription 1: expected an advertised channel, found {channel}");
        assert_eq!(refused["message"], expected);
    }
}

#[test]
fn pages_of_other_sites_get_no_socket() {
    let foxglove = Foxglove::open(0).unwrap();
    let from = |origin| connect(&foxglove, &[PROTOCOL, ("Origin", origin)]).map(drop);
    for refused in [
        "https://example.org",
        "http://example.org",
        "null",
        "http://app.foxglove.dev",
    ] {
        assert_eq!(from(refused), Err(403), "{refused}");
    }
    for own in [SITE, "http://localhost:8080", "file://"] {
        assert_eq!(from(own), Ok(()), "{own}");
    }
    let bent = connect(&foxglove, &[PROTOCOL, ("Host", "example.org")]).map(drop);
    assert_eq!(bent, Err(403));
    assert_eq!(connect(&foxglove, &[]).map(drop), Err(400));
    assert_eq!(
        connect(&foxglove, &[(PROTOCOL.0, "mqtt")]).map(drop),
        Err(400)
    );
}

#[test]
fn a_client_that_says_anything_else_is_let_go_and_others_stay() {
    let foxglove = Foxglove::open(0).unwrap();
    let mut run = begun(&foxglove);
    let mut good = client_of(&foxglove);
    say(
        &mut good,
        &json!({ "op": "subscribe", "subscriptions": [{ "id": 1, "channelId": 0 }] }),
    );
    assert_eq!(given(&mut good).1, 5);
    let garbage = [
        Message::text("{"),
        Message::text(r#"{"op":"subscribe","subscriptions":7}"#),
        Message::text(r#"{"op":"subscribe","subscriptions":[{"id":-1,"channelId":0}]}"#),
        Message::text("[".repeat(60_000)),
        Message::text(" ".repeat(MOST_WISH + 1)),
        Message::binary(vec![1, 0, 0, 0, 0, 7]),
    ];
    for message in garbage {
        let mut bad = client_of(&foxglove);
        let _ = bad.send(message);
        while bad.read().is_ok() {}
    }
    let mut raw = stream(&foxglove);
    raw.write_all(b"\x16\x03\x01 no request\r\n\r\n").unwrap();
    let mut answer = String::new();
    raw.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 400"), "{answer}");
    drop(client_of(&foxglove));
    run.message(0, 6, b"after").unwrap();
    assert_eq!(given(&mut good), (1, 6, b"after".to_vec()));
}

#[test]
fn a_client_that_never_reads_costs_bounded_memory_and_hears_of_it() {
    let foxglove = Foxglove::open(0).unwrap();
    let mut run = begun(&foxglove);
    let mut slow = client_of(&foxglove);
    let wish = json!([{ "id": 1, "channelId": 0 }]);
    say(
        &mut slow,
        &json!({ "op": "subscribe", "subscriptions": wish }),
    );
    assert_eq!(given(&mut slow).1, 5);
    // Twice what waits at most, beside what the system holds.
    let payload = vec![0; 1 << 16];
    let most = (MOST_WAITING / payload.len()) as u64;
    let mut sent: u64 = 0;
    while foxglove.hub.left_out() < most {
        run.message(0, 6, &payload).unwrap();
        sent += 1;
        assert!(sent < 100 * most, "everything found room");
    }
    let left_out = foxglove.hub.left_out();
    let mut got: u64 = 0;
    let remark = loop {
        match slow.read().unwrap() {
            Message::Binary(_) => got += 1,
            Message::Text(text) if text.contains("status") => break text,
            _ => {}
        }
    };
    assert_eq!(got + left_out, sent);
    let expected = format!("{left_out} messages were left out: they were read too slowly");
    assert!(remark.contains(&expected), "{remark}");
}
