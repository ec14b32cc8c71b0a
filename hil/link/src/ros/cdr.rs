//! CDR, little endian, the encoding of ROS 2: every member on a multiple of its own size, counted from after the
//! header.

/// A message that is being written.
#[derive(Clone, Debug)]
pub(super) struct Cdr(Vec<u8>);

impl Cdr {
    /// A message with its header: little endian, no options.
    pub(super) fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    fn align(&mut self, to: usize) {
        while !(self.0.len() - 4).is_multiple_of(to) {
            self.0.push(0);
        }
    }

    pub(super) fn i32(&mut self, value: i32) -> &mut Self {
        self.align(4);
        self.0.extend(value.to_le_bytes());
        self
    }

    pub(super) fn u32(&mut self, value: u32) -> &mut Self {
        self.align(4);
        self.0.extend(value.to_le_bytes());
        self
    }

    pub(super) fn f32(&mut self, value: f32) -> &mut Self {
        self.align(4);
        self.0.extend(value.to_le_bytes());
        self
    }

    pub(super) fn f64(&mut self, value: f64) -> &mut Self {
        self.align(8);
        self.0.extend(value.to_le_bytes());
        self
    }

    pub(super) fn u8(&mut self, value: u8) -> &mut Self {
        self.0.push(value);
        self
    }

    /// Writes a text with its length, and a zero at the end that counts.
    pub(super) fn text(&mut self, value: &str) -> &mut Self {
        // No text here comes near 4 GiB.
        self.u32(value.len() as u32 + 1);
        self.0.extend(value.as_bytes());
        self.0.push(0);
        self
    }

    pub(super) fn bytes(&self) -> Vec<u8> {
        self.0.clone()
    }
}
