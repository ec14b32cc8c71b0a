//! MATLAB's version 5 (`save -v6` and `-v7`, `scipy.io.savemat`).

use super::{Kind, Stored, Unpacking, Unread, word};

/// Bytes before the first element.
const HEAD: usize = 128;
const MATRIX: usize = 14;
const COMPRESSED: usize = 15;

/// The arrays of numbers in a file.
pub(super) fn arrays(bytes: &[u8]) -> Result<Vec<Stored>, Unread> {
    if bytes.get(126..HEAD) != Some(b"IM") {
        let found = "another byte order (save it again with `save -v7`)";
        return Err(("a little-endian MATLAB file", found.into()));
    }
    let broken = || ("a MATLAB file that is whole", "a part of one".to_owned());
    let (mut arrays, mut unpacking) = (Vec::new(), Unpacking::new());
    let mut at = HEAD;
    while at < bytes.len() {
        let element = Element::at(bytes, at).ok_or_else(broken)?;
        at = element.next;
        let unpacked;
        let inner = match element.kind {
            COMPRESSED => {
                unpacked = unpacking.zlib(element.data).ok_or_else(broken)?;
                Element::at(&unpacked, 0).ok_or_else(broken)?
            }
            _ => element,
        };
        if inner.kind == MATRIX {
            // Structures, cells and texts lie beside arrays of numbers.
            arrays.extend(matrix(inner.data));
        }
    }
    Ok(arrays)
}

/// A part of a file.
struct Element<'b> {
    kind: usize,
    data: &'b [u8],
    next: usize,
}

impl<'b> Element<'b> {
    fn at(bytes: &'b [u8], at: usize) -> Option<Self> {
        let kind = word(bytes, at, 4)?;
        // Up to four bytes stand in the place of their length.
        if kind >> 16 != 0 {
            let begin = at + 4;
            return Some(Self {
                kind: kind & 0xffff,
                data: bytes.get(begin..begin + (kind >> 16))?,
                next: at + 8,
            });
        }
        let (begin, length) = (at + 8, word(bytes, at + 4, 4)?);
        let end = begin.checked_add(length)?;
        let padded = if kind == COMPRESSED {
            end
        } else {
            end.checked_next_multiple_of(8)?
        };
        Some(Self {
            kind,
            data: bytes.get(begin..end)?,
            next: padded,
        })
    }
}

/// A matrix of numbers: flags, sizes, name, real part.
fn matrix(bytes: &[u8]) -> Option<Stored> {
    let flags = Element::at(bytes, 0)?;
    let class = flags.data.first()?;
    if !(6..=15).contains(class) {
        return None;
    }
    let sizes = Element::at(bytes, flags.next)?;
    let name = Element::at(bytes, sizes.next)?;
    let real = Element::at(bytes, name.next)?;
    let kind = match real.kind {
        1 => Kind::Signed(1),
        2 => Kind::Unsigned(1),
        3 => Kind::Signed(2),
        4 => Kind::Unsigned(2),
        5 => Kind::Signed(4),
        6 => Kind::Unsigned(4),
        7 => Kind::Float(4),
        9 => Kind::Float(8),
        12 => Kind::Signed(8),
        13 => Kind::Unsigned(8),
        _ => return None,
    };
    let size = |chunk: &[u8]| word(chunk, 0, 4);
    Some(Stored {
        name: String::from_utf8_lossy(name.data).into_owned(),
        shape: sizes
            .data
            .chunks_exact(4)
            .map(size)
            .collect::<Option<_>>()?,
        is_fortran: true,
        values: kind.numbers(real.data, false)?,
    })
}
