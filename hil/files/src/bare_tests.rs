//! Tests of counts at the end of lines: every count, and every line that is left to the slower reader.

use super::*;

fn tail(before: usize, count: usize) -> Tail {
    let taken: Vec<Taken> = (before..before + count)
        .map(|place| Taken::new(place, String::new()))
        .collect();
    Tail::new(Dialect::default(), &taken, before + count).unwrap()
}

#[test]
fn every_count_is_read_with_and_without_text_behind_it() {
    for number in 0..=u16::MAX {
        let text = number.to_string();
        assert_eq!(count(text.as_bytes()), Some((text.len(), number)));
        let text = format!("{number},65535,0");
        assert_eq!(count(text.as_bytes()).map(|(_, n)| n), Some(number));
        let text = format!("{number:05},\u{FF}\u{FF}\u{FF}");
        assert_eq!(count(text.as_bytes()), Some((5, number)));
    }
}

#[test]
fn no_byte_but_digits_is_part_of_a_count() {
    for byte in 0..=u8::MAX {
        for place in 0..3 {
            let mut text = *b"12345678";
            text[place] = byte;
            text[4] = b',';
            let digits = text.iter().take_while(|b| b.is_ascii_digit()).count();
            let read = count(&text);
            let own = std::str::from_utf8(&text[..digits]).unwrap();
            assert_eq!(read, own.parse().ok().map(|n| (digits, n)), "{text:?}");
        }
    }
    for text in ["", "65536", "123456", "99999,1"] {
        assert_eq!(count(text.as_bytes()), None, "{text}");
    }
}

#[test]
fn lines_are_read_whole_or_left() {
    let mut values: Vec<u16> = Vec::new();
    assert_eq!(tail(1, 2).read("0.5,1,65535", &mut values), Some("0.5"));
    assert_eq!(values, [1, 65_535]);
    values.clear();
    assert_eq!(tail(0, 3).read("007,8,9", &mut values), Some(""));
    assert_eq!(values, [7, 8, 9]);
    for line in [
        "0,1",
        "0,1,2,",
        "0,1,2,3",
        "0,1,2.0",
        "0,1, 2",
        "0,1,-2",
        "\"a,b\",1",
        "0,,2",
        "0,1,\"2\"",
    ] {
        values.clear();
        assert_eq!(tail(1, 2).read(line, &mut values), None, "{line}");
        assert!(values.is_empty(), "{line}");
    }
}
