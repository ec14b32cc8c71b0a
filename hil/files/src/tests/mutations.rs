//! Recordings of every format with bytes changed, cut, doubled and swapped: each is read or refused, and never panics or hangs.

use std::io::Write;

use crate::{Columns, Rows, Take, Timing};

/// How many of each format: `ci/hostile` asks for more.
fn count() -> usize {
    let asked = std::env::var("PALPATE_MUTATIONS").ok();
    asked.and_then(|n| n.parse().ok()).unwrap_or(300)
}

/// Draws that are the same in every run (xorshift).
struct Draws(u64);

impl Draws {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound.max(1) as u64) as usize
    }

    fn mutated(&mut self, good: &[u8]) -> Vec<u8> {
        let mut bytes = good.to_vec();
        for _ in 0..=self.below(3) {
            let at = self.below(bytes.len());
            match self.below(6) {
                0 => bytes.truncate(at.max(1)),
                1 => bytes[at] ^= 1 << self.below(8),
                2 => bytes[at] = [0, 0xff, b',', b'"', b'\n', b'#', b'-', b'9'][self.below(8)],
                3 => bytes.insert(at, b"0,;\t \"\n#(e.-"[self.below(12)]),
                4 => {
                    let end = (at + self.below(40)).min(bytes.len());
                    let piece = bytes[at..end].to_vec();
                    bytes.splice(at..at, piece);
                }
                _ => {
                    let other = self.below(bytes.len());
                    bytes.swap(at, other);
                }
            }
            if bytes.is_empty() {
                bytes.push(b'0');
            }
        }
        bytes
    }
}

fn text(separator: &str, head: &str, time: impl Fn(usize) -> String) -> Vec<u8> {
    let row = |n: usize| format!("{}{}{separator}{}\n", time(n), 100 + n % 3, 200 + n % 2);
    (head.to_owned() + &(0..20).map(row).collect::<String>()).into_bytes()
}

/// Two taxels of four cells.
fn tekscan() -> Vec<u8> {
    let head = "DATA_TYPE MOVIE\nROWS 2\nSECONDS_PER_FRAME 0.02\nASCII_DATA @@\n";
    let frame = |n: usize| format!("\nFrame {n}\nB,{}\n{},B\n", 100 + n, 200 - n);
    let frames: String = (1..9).map(frame).collect();
    format!("{head}{frames}\n@@\n").into_bytes()
}

fn npy() -> Vec<u8> {
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }\n";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(
        [100.0, 200.0, 101.0, 201.0, 102.0, 202.0_f64]
            .iter()
            .flat_map(|v| v.to_le_bytes()),
    );
    bytes
}

fn mat() -> Vec<u8> {
    let element = |kind: u8, data: &[u8]| {
        let mut all = vec![kind, 0, 0, 0, data.len() as u8, 0, 0, 0];
        all.extend(data);
        all.resize(all.len().next_multiple_of(8), 0);
        all
    };
    let parts = [
        element(6, &[6, 0, 0, 0, 0, 0, 0, 0]),
        element(5, &[3, 0, 0, 0, 2, 0, 0, 0]),
        element(1, b"raw"),
        element(2, &[100, 101, 102, 200, 201, 202]),
    ];
    let mut bytes = b"MATLAB 5.0".to_vec();
    bytes.resize(124, b' ');
    bytes.extend(b"\x00\x01IM");
    bytes.extend(element(14, &parts.concat()));
    bytes
}

fn mcap() -> Vec<u8> {
    let text = |value: &str| [&(value.len() as u32).to_le_bytes()[..], value.as_bytes()].concat();
    let record =
        |kind: u8, body: Vec<u8>| [&[kind][..], &(body.len() as u64).to_le_bytes(), &body].concat();
    let schema = [
        vec![1, 0],
        text("a/B"),
        text("ros2msg"),
        text("uint16[] d\nC c\n===\nMSG: a/C\nint8 v\n"),
    ];
    let channel = [vec![1, 0, 1, 0], text("/skin"), text("cdr"), vec![0; 4]];
    let mut bytes = b"\x89MCAP0\r\n".to_vec();
    bytes.extend(record(3, schema.concat()));
    bytes.extend(record(4, channel.concat()));
    for n in 0..4_u8 {
        let mut message = vec![1, 0, 0, 0, 0, 0, n, 0, 0, 0, 0, 0, 0, 0];
        message.extend([0; 8]);
        message.extend([0, 1, 0, 0, 2, 0, 0, 0, 100, 0, 200, n, 7]);
        bytes.extend(record(5, message));
    }
    bytes
}

#[test]
fn changed_recordings_are_read_or_refused() {
    let columns = Columns {
        taxels: 2,
        axes: 1,
        layout: "two".into(),
    };
    let us = |n: usize| format!("{},", n * 10_000);
    let json =
        |n: usize| format!("{{\"time\":0.{n}5,\"1\":{{\"data\":\"0064,00c{n}\",\"n\":[1]}}}}\n");
    let formats: [(&str, Vec<u8>); 10] = [
        ("own", text(",", "time_us,txl1_z,txl2_z\n", us)),
        (
            "semicolons",
            text(";", "Time (ms);c1;c10\n", |n| format!("{},5;", n * 10)),
        ),
        ("blanks", text(" ", "# t a1 a2\n", |n| format!("0.{n:02} "))),
        (
            "bare",
            text("\t", "", |n| format!("{n}\t2026-03-01 12:00:{n:02}.25\t")),
        ),
        (
            "quotes",
            text(",", "\"secs\",\"nsecs\",\"x_1\",\"x_2\"\n", |n| {
                format!("\"17\",{n}000,")
            }),
        ),
        ("json", (0..9).map(json).collect::<String>().into_bytes()),
        ("tekscan", tekscan()),
        ("npy", npy()),
        ("mat", mat()),
        ("mcap", mcap()),
    ];
    let path = std::env::temp_dir().join(format!("palpate-mutations-{}", std::process::id()));
    let timings = [None, Some(50.0)].map(|rate_hz| Timing {
        rate_hz,
        rest_rows: 3,
        ..Timing::default()
    });
    let mut draws = Draws(0x9E37_79B9_7F4A_7C15);
    for (format, good) in formats {
        let (mut read, mut refused) = (0, 0);
        for n in 0..count() {
            let bytes = if n == 0 {
                good.clone()
            } else {
                draws.mutated(&good)
            };
            let mut file = std::fs::File::create(&path).unwrap();
            file.write_all(&bytes).unwrap();
            let timing = &timings[n % 2];
            let rows = Rows::open(&path, Take::Taxels(&columns), Some(timing));
            match rows.and_then(|mut rows| rows.rest::<u16>()) {
                Ok(values) => {
                    assert!(
                        !values.is_empty() && values.len().is_multiple_of(2),
                        "{format}"
                    );
                    read += 1;
                }
                Err(error) => {
                    assert!(!error.to_string().is_empty());
                    refused += 1;
                }
            }
        }
        assert!(
            read > 0 && refused > 0,
            "{format}: {read} read, {refused} refused"
        );
    }
    std::fs::remove_file(&path).unwrap();
}
