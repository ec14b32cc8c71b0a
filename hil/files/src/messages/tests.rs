//! Tests of messages in MCAP files.

use super::*;
use crate::made::Made;

fn text(value: &str) -> Vec<u8> {
    [&(value.len() as u32).to_le_bytes()[..], value.as_bytes()].concat()
}

fn record(kind: u8, body: &[u8]) -> Vec<u8> {
    let mut all = vec![kind];
    all.extend((body.len() as u64).to_le_bytes());
    all.extend(body);
    all
}

fn schema(name: &str, definition: &str) -> Vec<u8> {
    record(
        op::SCHEMA,
        &[
            &[1, 0][..],
            &text(name),
            &text("ros2msg"),
            &text(definition),
        ]
        .concat(),
    )
}

fn channel(id: u8, topic: &str, encoding: &str) -> Vec<u8> {
    record(
        op::CHANNEL,
        &[&[id, 0, 1, 0][..], &text(topic), &text(encoding), &[0; 4]].concat(),
    )
}

fn logged(channel: u8, ns: u64, data: &[u8]) -> Vec<u8> {
    let head = [&[channel, 0, 0, 0, 0, 0][..], &ns.to_le_bytes(), &[0; 8]].concat();
    record(op::MESSAGE, &[&head[..], data].concat())
}

fn table(name: &str, records: &[Vec<u8>]) -> Result<(String, String), String> {
    topic(name, None, records)
}

/// The table of a topic, and the note on it.
fn topic(
    name: &str,
    wanted: Option<&str>,
    records: &[Vec<u8>],
) -> Result<(String, String), String> {
    let path = std::env::temp_dir().join(format!("palpate-{name}-{}.mcap", std::process::id()));
    let bytes = [MAGIC, &records.concat(), &record(op::DATA_END, &[0; 4])].concat();
    std::fs::write(&path, bytes).unwrap();
    let read = || {
        let messages = Messages::open(&path, wanted).map_err(|e| e.to_string())?;
        let note = messages.note();
        let mut table = String::new();
        let read = Made::new(messages).read_to_string(&mut table);
        read.map_err(|e| e.to_string())?;
        Ok((table, note))
    };
    let table = read();
    std::fs::remove_file(&path).unwrap();
    table
}

const ARRAY: &str = "# counts\nMultiArrayLayout layout\nuint16[] data\n\
    ====\nMSG: std_msgs/MultiArrayLayout\nMultiArrayDimension[] dim\nuint32 data_offset\n\
    ====\nMSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n";

/// An empty layout and counts, little-endian.
fn counts(values: &[u16]) -> Vec<u8> {
    let mut data = vec![0, 1, 0, 0];
    data.extend([0; 8]);
    data.extend((values.len() as u32).to_le_bytes());
    data.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    data
}

#[test]
fn a_bag_of_ros_is_a_table() {
    let records = [
        schema("std_msgs/msg/UInt16MultiArray", ARRAY),
        channel(1, "/skin", "cdr"),
        logged(1, 1_000_000_000, &counts(&[1, 2, 65_535])),
        logged(1, 1_010_000_000, &counts(&[3, 4, 5])),
    ];
    let (table_, note) = table("bag", &records).unwrap();
    assert_eq!(
        table_,
        "time_ns,layout.data_offset,data.0,data.1,data.2\n1000000000,0,1,2,65535\n1010000000,0,3,4,5\n"
    );
    assert!(
        note.ends_with("rows are the messages of topic `/skin`"),
        "{note}"
    );
    let shorter = [&records[..], &[logged(1, 1_020_000_000, &counts(&[1]))]].concat();
    let error = table("short", &shorter).unwrap_err();
    assert!(error.contains("with the 4 numbers of the first"), "{error}");
    let torn = [&records[..], &[logged(1, 1_020_000_000, &[0, 1, 0, 0, 9])]].concat();
    let error = table("torn", &torn).unwrap_err();
    assert!(
        error.contains("whole messages of topic `/skin`, found one of 5 bytes"),
        "{error}"
    );
}

#[test]
fn the_topic_with_most_numbers_is_taken_and_json_is_read() {
    let records = [
        channel(1, "/temperature", "json"),
        channel(2, "/skin", "json"),
        channel(3, "/log", "protobuf"),
        logged(1, 5, b"{\"celsius\":20.5}"),
        logged(3, 6, b"\x08\x01"),
        logged(2, 7, b"{\"taxels\":[1,2]}"),
    ];
    // What stands in a chunk is the same.
    let inner = records.concat();
    let mut chunk = vec![0; 28];
    chunk.extend(text(""));
    chunk.extend((inner.len() as u64).to_le_bytes());
    chunk.extend(inner);
    for records in [&records[..], &[record(op::CHUNK, &chunk)]] {
        let (table, _) = table("json", records).unwrap();
        assert_eq!(table, "time_ns,taxels.0,taxels.1\n7,1,2\n");
    }
    let mut packed = vec![0; 28];
    packed.extend([text("zstd"), vec![0; 8]].concat());
    let error = table("packed", &[record(op::CHUNK, &packed)]).unwrap_err();
    assert!(error.contains("mcap recover"), "{error}");
    let error = table("other", &records[2..5]).unwrap_err();
    assert!(error.contains("found /log (protobuf)"), "{error}");
}

#[test]
fn numbers_stand_at_multiples_of_their_width() {
    let definition = Definition::parse(
        "a/B",
        "bool on\nfloat64 t\nint8[2] pair\nuint8 K=1\nstring<=8 s\nC c\n===\nMSG: a/C\nint16 v\n",
    );
    let mut data = vec![0, 0, 0, 0];
    data.push(1);
    data.extend([0; 7]);
    data.extend(0.5_f64.to_be_bytes());
    data.extend([255, 2, 0, 0]);
    data.extend(2_u32.to_be_bytes());
    data.extend(b"a\0");
    data.extend((-3_i16).to_be_bytes());
    let mut leaves = Vec::new();
    definition.read(&data, &mut leaves).unwrap();
    let leaves: Vec<(&str, &str)> = leaves
        .iter()
        .map(|(n, v)| (n.as_str(), v.as_str()))
        .collect();
    assert_eq!(
        leaves,
        [
            ("on", "1"),
            ("t", "0.5"),
            ("pair.0", "-1"),
            ("pair.1", "2"),
            ("c.v", "-3")
        ]
    );
    for end in 0..data.len() {
        let _ = definition.read(&data[..end], &mut Vec::new());
    }
}

#[test]
fn topics_are_taken_by_their_names() {
    let message = |channel: u8, ns: u64, text: &str| logged(channel, ns, text.as_bytes());
    let records = [
        channel(0, "/imu", "json"),
        channel(1, "/skin", "json"),
        channel(2, "/words", "json"),
        message(0, 5, "{\"a\":[1,2,3,4]}"),
        message(2, 5, "{\"a\":\"no number\"}"),
        message(1, 7, "{\"d\":[5,6]}"),
        message(1, 9, "{\"d\":[7,8]}"),
    ];
    let (table, note) = topic("topic", Some("/skin"), &records).unwrap();
    assert_eq!(table, "time_ns,d.0,d.1\n7,5,6\n9,7,8\n");
    assert!(
        note.ends_with("rows are the messages of topic `/skin`"),
        "{note}"
    );
    let (table, note) = topic("topic-most", None, &records).unwrap();
    assert_eq!(table, "time_ns,a.0,a.1,a.2,a.3\n5,1,2,3,4\n");
    let others = "which has the most numbers (--topic takes another: /skin (json, 2 numbers))";
    assert!(note.ends_with(others), "{note}");
    for wanted in ["/words", "/nothing"] {
        let error = topic("topic-none", Some(wanted), &records).unwrap_err();
        let expected = format!("the topic `{wanted}` (--topic)");
        let found = "found /imu (json, 4 numbers), /skin (json, 2 numbers), /words (json)";
        assert!(
            error.contains(&expected) && error.ends_with(found),
            "{error}"
        );
    }
}
