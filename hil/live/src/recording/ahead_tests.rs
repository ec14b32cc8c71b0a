//! Rows and errors of a table are those of one thread that reads all of it, wherever reads and batches end.

use std::io::{self, Read};

use palpate_files::{Columns, LONGEST_LINE, Take, Text, Timing};
use proptest::prelude::*;

use super::*;

/// A text that comes in pieces of these lengths, again and again.
struct Pieces {
    text: Vec<u8>,
    at: usize,
    lengths: Vec<usize>,
    reads: usize,
}

impl Read for Pieces {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let most = self.lengths[self.reads % self.lengths.len()].min(out.len());
        self.reads += 1;
        let read = (&self.text[self.at..]).read(&mut out[..most])?;
        self.at += read;
        Ok(read)
    }
}

/// Times and counts of all rows, and the end: their number and notes, or the error.
type Seen = (Vec<(u64, Vec<u16>)>, Result<(usize, Vec<String>), String>);

fn open(text: &[u8], lengths: &[usize], has_times: bool) -> Result<Rows<Input>, FileError> {
    let columns = Columns {
        taxels: 2,
        axes: 1,
        layout: "two".into(),
    };
    let timing = Timing {
        rate_hz: (!has_times).then_some(50.0),
        rest_rows: 3,
        ..Timing::default()
    };
    let input: Input = Box::new(Pieces {
        text: text.to_vec(),
        at: 0,
        lengths: lengths.to_vec(),
        reads: 0,
    });
    let text = Text::new("a.csv", input, LONGEST_LINE).waiting();
    Rows::over(text, Take::Taxels(&columns), Some(&timing))
}

fn by_one(rows: Result<Rows<Input>, FileError>) -> Seen {
    let (mut seen, mut row) = (Vec::new(), Vec::new());
    let mut rows = match rows {
        Ok(rows) => rows,
        Err(error) => return (seen, Err(error.to_string())),
    };
    loop {
        match rows.advance(&mut row) {
            Ok(Some(at)) => seen.push((at.time_us, row.clone())),
            Ok(None) => return (seen, Ok((rows.count(), rows.notes()))),
            Err(error) => return (seen, Err(error.to_string())),
        }
    }
}

fn by_two(rows: Result<Rows<Input>, FileError>) -> Seen {
    let mut seen = Vec::new();
    let rows = match rows {
        Ok(rows) => rows,
        Err(error) => return (seen, Err(error.to_string())),
    };
    let end = ahead(rows, &mut |us, counts| {
        seen.push((us, counts.to_vec()));
        Ok(())
    });
    let end = match end {
        Ok(mut rows) => Ok((rows.count(), rows.notes())),
        Err(failure) => Err(failure.to_string()),
    };
    (seen, end)
}

/// Rows around the lengths of batches, blank lines among them, and an end that may cut the last.
fn table() -> impl Strategy<Value = (Vec<u8>, bool)> {
    let separator = prop_oneof![Just(","), Just(";"), Just("\t"), Just(" ")];
    let end = prop_oneof![Just("\n"), Just("\r\n")];
    let about = prop_oneof![0..9_usize, 250..262_usize, 505..520_usize, 1020..1300_usize];
    let values = (any::<u64>(), 0..40_u64, 0..30_usize, any::<bool>());
    (separator, end, about, values).prop_map(
        |(separator, end, rows, (seed, blanks, cut, has_times))| {
            let mut draw = seed | 1;
            let mut below = move |bound: u64| {
                draw ^= draw << 13;
                draw ^= draw >> 7;
                draw ^= draw << 17;
                draw % bound
            };
            let names = if has_times {
                &["time_us", "txl1_z", "txl2_z"][..]
            } else {
                &["txl1_z", "txl2_z"]
            };
            let mut text = names.join(separator) + end;
            for row in 0..rows {
                if blanks > 0 && below(41) < blanks {
                    text += end;
                }
                let counts = [below(65_536), below(65_536)].map(|count| count.to_string());
                let time = has_times.then(|| (row * 10_000).to_string());
                text += &time
                    .into_iter()
                    .chain(counts)
                    .collect::<Vec<_>>()
                    .join(separator);
                text += end;
            }
            text.truncate(text.len().saturating_sub(cut.saturating_sub(10)));
            (text.into_bytes(), has_times)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn rows_are_the_same_by_two_threads_and_in_any_pieces(
        (text, has_times) in table(),
        lengths in prop::collection::vec(prop_oneof![1..8_usize, 1..5000_usize], 1..6),
    ) {
        let whole = by_one(open(&text, &[usize::MAX], has_times));
        prop_assert_eq!(&by_one(open(&text, &lengths, has_times)), &whole);
        prop_assert_eq!(&by_two(open(&text, &lengths, has_times)), &whole);
        prop_assert_eq!(&by_two(open(&text, &[usize::MAX], has_times)), &whole);
    }
}
