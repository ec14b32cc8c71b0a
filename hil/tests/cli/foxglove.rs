//! A run in Foxglove's protocol: a client gets what the record gets, and changes nothing of it.

use std::collections::BTreeMap;
use std::net::TcpStream;

use palpate_records::contacts_csv::{write_header, write_rows};
use palpate_records::mcap::decode;
use palpate_records::trace::event::Contact;
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket, client};

use super::serve::{Served, served};
use super::*;

/// Time and payload of messages, by topic.
type Messages = BTreeMap<String, Vec<(u64, Vec<u8>)>>;

fn connected(run: &Served) -> WebSocket<TcpStream> {
    let mut request = format!("ws://{}/", run.host).into_client_request().unwrap();
    let protocol = "foxglove.sdk.v1".parse().unwrap();
    request
        .headers_mut()
        .insert("Sec-WebSocket-Protocol", protocol);
    client(request, run.stream()).unwrap().0
}

/// Everything that comes until the run is over: messages by topic, with their times in nanoseconds, and the last words.
fn listened(socket: &mut WebSocket<TcpStream>) -> (Messages, String) {
    let (mut topics, mut got) = (BTreeMap::new(), Messages::new());
    loop {
        match socket.read().unwrap() {
            Message::Text(text) => {
                let said: Value = serde_json::from_str(&text).unwrap();
                if said["op"] == "status" {
                    return (got, said["message"].as_str().unwrap().to_owned());
                }
                let all = said["channels"].as_array().into_iter().flatten();
                for channel in all {
                    let id = channel["id"].as_u64().unwrap() as u32;
                    topics.insert(id, channel["topic"].as_str().unwrap().to_owned());
                }
                let wishes = topics.keys().map(|id| json!({ "id": id, "channelId": id }));
                let wishes: Vec<_> = wishes.collect();
                let wish = json!({ "op": "subscribe", "subscriptions": wishes });
                socket.send(Message::text(wish.to_string())).unwrap();
            }
            Message::Binary(bytes) if bytes[0] == 1 => {
                let id = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
                let time = u64::from_le_bytes(bytes[5..13].try_into().unwrap());
                let own = got.entry(topics[&id].clone()).or_default();
                own.push((time, bytes[13..].to_vec()));
            }
            _ => {}
        }
    }
}

#[test]
fn foxglove_gets_the_contacts_of_the_record_while_the_run_goes_on() {
    let folder = Folder::new("foxglove");
    let scene = ["run", "sphere-along", "--set", "length_s=2", "--quiet"];
    let seen = ["--record", "seen.csv", "--foxglove", "0"];
    let seen = served(&folder, &[&scene[..], &seen].concat());
    let mut socket = connected(&seen);
    let (topics, last) = listened(&mut socket);
    assert_eq!(seen.ended().0, Some(0));
    assert!(last.starts_with("OK"), "{last}");
    let contacts = topics["/contacts"].iter().map(|(time, message)| Contact {
        t_us: time / 1000,
        ..decode(message).unwrap()
    });
    let contacts: Vec<Contact> = contacts.collect();
    let mut told = Vec::new();
    write_header(&[], &mut told).unwrap();
    write_rows(contacts.iter(), &[], &mut told).unwrap();
    let recorded = fs::read(folder.path("seen.csv")).unwrap();
    assert!(recorded.starts_with(&told), "other rows than the record's");
    // What comes after the last look, 40 ms apart.
    let (told, all) = (told.len(), recorded.len());
    assert!(told > all * 9 / 10, "{told} bytes of {all}");
    for topic in [
        "/scene",
        "/frames",
        "/wire/0/schedule",
        "/frames_of_reference",
    ] {
        assert!(!topics[topic].is_empty(), "{topic}");
    }
    assert!(topics["/skin/0"].len() > 20, "pictures");
    let alone = [&scene[..], &["--record", "alone.csv"]].concat();
    assert!(
        command(&alone, &folder.0)
            .output()
            .unwrap()
            .status
            .success()
    );
    let alone = fs::read(folder.path("alone.csv")).unwrap();
    assert!(recorded == alone, "the view changes the record");
}

#[test]
fn foxglove_needs_one_display_and_no_loop() {
    let one = ["--foxglove", "one display", "ten-fingers"];
    refused_with(&["run", "ten-fingers", "--foxglove", "0"], &one);
    let again = ["run", "idle", "--serve", "0", "--loop", "--foxglove"];
    refused_with(&again, &["--loop", "--foxglove"]);
    refused_with(
        &["run", "idle", "--foxglove", "70000"],
        &["--foxglove", "70000"],
    );
}
