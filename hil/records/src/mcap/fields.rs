//! Records of an MCAP file, field by field.

use std::collections::BTreeMap;

/// Little-endian fields of a record.
pub(super) struct Cursor<'a>(pub(super) &'a [u8]);

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(taken)
    }
    pub(super) fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.take(2)?.try_into().ok()?))
    }
    pub(super) fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }
    pub(super) fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }
    pub(super) fn sized(&mut self) -> Option<&'a [u8]> {
        let n = usize::try_from(self.u32()?).ok()?;
        self.take(n)
    }
    pub(super) fn text(&mut self) -> Option<String> {
        String::from_utf8(self.sized()?.to_vec()).ok()
    }
    /// The next record: kind and body.
    pub(super) fn record(&mut self) -> Option<(u8, &'a [u8])> {
        let before = self.0;
        let whole = || {
            let kind = self.take(1)?[0];
            let length = usize::try_from(self.u64()?).ok()?;
            Some((kind, self.take(length)?))
        };
        let record = { whole }();
        if record.is_none() {
            self.0 = before;
        }
        record
    }
}

/// Name and entries of metadata.
pub(super) fn metadata(record: &[u8]) -> Option<(String, BTreeMap<String, String>)> {
    let mut cursor = Cursor(record);
    let name = cursor.text()?;
    let mut entries = Cursor(cursor.sized()?);
    let mut map = BTreeMap::new();
    while !entries.0.is_empty() {
        map.insert(entries.text()?, entries.text()?);
    }
    Some((name, map))
}

/// Name and contents of an attached file.
pub(super) fn attachment(record: &[u8]) -> Option<(String, Vec<u8>)> {
    let mut cursor = Cursor(record);
    let (_logged, _created) = (cursor.u64()?, cursor.u64()?);
    let (name, _media_type) = (cursor.text()?, cursor.text()?);
    let size = usize::try_from(cursor.u64()?).ok()?;
    let data = cursor.take(size)?.to_vec();
    let crc = cursor.u32()?;
    let covered = record.get(..record.len() - 4)?;
    (crc == 0 || crc == crc32fast::hash(covered)).then_some((name, data))
}

/// Packing of a chunk's records.
pub(super) struct ChunkHead {
    pub(super) crc: u32,
    pub(super) compression: String,
    pub(super) size: u64,
}

/// The head of a chunk, and what follows it.
pub(super) fn chunk_head(record: &[u8]) -> Option<(ChunkHead, &[u8])> {
    let mut cursor = Cursor(record);
    let (_first, _last, _size) = (cursor.u64()?, cursor.u64()?, cursor.u64()?);
    let crc = cursor.u32()?;
    let head = ChunkHead {
        crc,
        compression: cursor.text()?,
        size: cursor.u64()?,
    };
    Some((head, cursor.0))
}
