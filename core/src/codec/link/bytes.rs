//! Little-endian integers in and out of a slice, without a panic at its end.

/// Reads from the front.
pub(super) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*first)
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.take::<1>().map(|[b]| b)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    pub(super) fn u24(&mut self) -> Option<u32> {
        self.take()
            .map(|[a, b, c]| u32::from_le_bytes([a, b, c, 0]))
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    /// Bytes not yet read.
    pub(super) const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Tells whether every byte was read.
    pub(super) const fn is_done(&self) -> bool {
        self.rest.is_empty()
    }
}

/// Writes from the front; what does not fit is left out.
pub(super) struct Writer<'a> {
    out: &'a mut [u8],
    length: usize,
}

impl<'a> Writer<'a> {
    pub(super) const fn new(out: &'a mut [u8]) -> Self {
        Self { out, length: 0 }
    }

    fn put(&mut self, bytes: &[u8]) {
        let end = self.length + bytes.len();
        if let Some(place) = self.out.get_mut(self.length..end) {
            place.copy_from_slice(bytes);
            self.length = end;
        }
    }

    pub(super) fn u8(&mut self, x: u8) {
        self.put(&[x]);
    }

    pub(super) fn u16(&mut self, x: u16) {
        self.put(&x.to_le_bytes());
    }

    /// The nearest of 0 ..= 2^24 - 1.
    pub(super) fn u24(&mut self, x: u64) {
        let [a, b, c, ..] = x.min(0xFF_FFFF).to_le_bytes();
        self.put(&[a, b, c]);
    }

    pub(super) fn u32(&mut self, x: u32) {
        self.put(&x.to_le_bytes());
    }

    pub(super) fn u64(&mut self, x: u64) {
        self.put(&x.to_le_bytes());
    }

    /// Bytes written.
    pub(super) const fn length(&self) -> usize {
        self.length
    }
}
