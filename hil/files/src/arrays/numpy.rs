//! NumPy's `.npy` (versions 1 to 3) and `.npz`.

use super::{Kind, Stored, Unpacking, Unread, word};

/// One array.
pub(super) fn array(bytes: &[u8]) -> Result<Stored, Unread> {
    parts(bytes).ok_or_else(|| {
        let header: String = bytes
            .iter()
            .skip(10)
            .take(80)
            .map(|b| char::from(*b))
            .collect();
        (
            "an array of at most 41943040 numbers whose header is whole",
            header.escape_debug().to_string(),
        )
    })
}

fn parts(bytes: &[u8]) -> Option<Stored> {
    let (length, begin) = match bytes.get(6)? {
        1 => (word(bytes, 8, 2)?, 10),
        2 | 3 => (word(bytes, 8, 4)?, 12),
        _ => return None,
    };
    let (header, data) = bytes.get(begin..)?.split_at_checked(length)?;
    let header = std::str::from_utf8(header).ok()?;
    let after = |key: &str| Some(header.split_once(key)?.1.trim_start());
    let kind = after("'descr':")?.strip_prefix('\'')?.split('\'').next()?;
    let (order, kind) = kind.split_at_checked(1)?;
    let (letter, width) = kind.split_at_checked(1)?;
    let width = width.parse().ok()?;
    let kind = match letter {
        "f" => Kind::Float(width),
        "i" => Kind::Signed(width),
        "u" | "b" => Kind::Unsigned(width),
        _ => return None,
    };
    let inside = after("'shape':")?.strip_prefix('(')?.split(')').next()?;
    let sizes = inside.split(',').map(str::trim).filter(|n| !n.is_empty());
    let shape: Option<Vec<usize>> = sizes.map(|n| n.parse().ok()).collect();
    Some(Stored {
        name: String::new(),
        shape: shape?,
        is_fortran: after("'fortran_order':")?.starts_with("True"),
        values: kind.numbers(data, order == ">")?,
    })
}

/// The arrays of an archive.
pub(super) fn archive(bytes: &[u8]) -> Result<Vec<Stored>, Unread> {
    let broken = || {
        (
            "an archive of arrays (.npz) that is whole",
            "a part of one".to_owned(),
        )
    };
    let entries = entries(bytes).ok_or_else(broken)?;
    let mut arrays = Vec::new();
    for (name, data) in entries {
        let data = data.ok_or_else(broken)?;
        // Texts and records lie beside arrays of numbers.
        if let Ok(array) = array(&data) {
            let name = name.trim_end_matches(".npy").to_owned();
            arrays.push(Stored { name, ..array });
        }
    }
    Ok(arrays)
}

/// Name and unpacked bytes of a file in an archive.
type Entry = (String, Option<Vec<u8>>);

/// The files of a zip archive by its directory, which stands at its end.
fn entries(bytes: &[u8]) -> Option<Vec<Entry>> {
    let end = bytes.windows(4).rposition(|w| w == b"PK\x05\x06")?;
    let (count, mut at) = (word(bytes, end + 10, 2)?, word(bytes, end + 16, 4)?);
    let (mut entries, mut unpacking) = (Vec::new(), Unpacking::new());
    for _ in 0..count {
        if bytes.get(at..at.checked_add(4)?)? != b"PK\x01\x02" {
            return None;
        }
        let method = word(bytes, at + 10, 2)?;
        let packed = word(bytes, at + 20, 4)?;
        let [name, extra, comment] = [28, 30, 32].map(|n| word(bytes, at + n, 2));
        let (name_length, local) = (name?, word(bytes, at + 42, 4)?);
        let begin = at.checked_add(46)?;
        let name = bytes.get(begin..begin.checked_add(name_length)?)?;
        let name = String::from_utf8_lossy(name).into_owned();
        let data_at = local + 30 + word(bytes, local + 26, 2)? + word(bytes, local + 28, 2)?;
        let data = bytes.get(data_at..data_at.checked_add(packed)?)?;
        let data = match method {
            0 => unpacking.kept(data.to_vec()),
            8 => unpacking.deflated(data),
            _ => None,
        };
        entries.push((name, data));
        at = begin + name_length + extra? + comment?;
    }
    Some(entries)
}
