//! Samples as a WAV file (RIFF, PCM of 16 bits), which players and Python's `wave` read.

use std::io::{self, Write};

/// Words of the chunk that names the program.
const SOFTWARE: &[u8; 8] = b"palpate\0";
/// Bytes before the samples, without the first eight.
const HEAD: u32 = 4 + (8 + 16) + (8 + 4 + 8 + SOFTWARE.len() as u32) + 8;

/// Writes frames of `channels` samples each.
///
/// # Errors
/// Errors of `out`, and more samples or channels than the format holds.
pub fn write_wav(
    rate_hz: u32,
    channels: usize,
    samples: &[i16],
    out: &mut dyn Write,
) -> io::Result<()> {
    let bytes = u32::try_from(2 * samples.len()).ok();
    let whole = bytes.and_then(|bytes| bytes.checked_add(HEAD));
    let width = u16::try_from(2 * channels).ok();
    let (Some(bytes), Some(whole), Some(width)) = (bytes, whole, width) else {
        return Err(io::Error::other(
            "a WAV file holds at most 4 GiB: give the scene a shorter length_s",
        ));
    };
    let mut head = Vec::with_capacity(HEAD as usize + 8);
    head.extend(b"RIFF");
    head.extend(whole.to_le_bytes());
    head.extend(b"WAVEfmt ");
    head.extend(16_u32.to_le_bytes());
    head.extend(1_u16.to_le_bytes()); // PCM
    head.extend((width / 2).to_le_bytes());
    head.extend(rate_hz.to_le_bytes());
    head.extend((rate_hz.saturating_mul(u32::from(width))).to_le_bytes());
    head.extend(width.to_le_bytes());
    head.extend(16_u16.to_le_bytes());
    head.extend(b"LIST");
    head.extend((12 + SOFTWARE.len() as u32).to_le_bytes());
    head.extend(b"INFOISFT");
    head.extend((SOFTWARE.len() as u32).to_le_bytes());
    head.extend(SOFTWARE);
    head.extend(b"data");
    head.extend(bytes.to_le_bytes());
    out.write_all(&head)?;
    for block in samples.chunks(4096) {
        let bytes: Vec<u8> = block.iter().flat_map(|s| s.to_le_bytes()).collect();
        out.write_all(&bytes)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_have_the_lengths_that_they_state() {
        let mut out = Vec::new();
        write_wav(48_000, 2, &[1, -2, 300, i16::MIN], &mut out).unwrap();
        let word = |at: usize| u32::from_le_bytes(out[at..at + 4].try_into().unwrap());
        assert_eq!((&out[..4], &out[8..16]), (&b"RIFF"[..], &b"WAVEfmt "[..]));
        assert_eq!(word(4) as usize, out.len() - 8);
        // PCM, two channels; frames and bytes per second; four bytes per frame, 16 bits per sample.
        assert_eq!(out[20..24], [1, 0, 2, 0]);
        assert_eq!((word(24), word(28)), (48_000, 192_000));
        assert_eq!(out[32..36], [4, 0, 16, 0]);
        let list = 36;
        assert_eq!(&out[list..list + 4], b"LIST");
        let data = list + 8 + word(list + 4) as usize;
        assert_eq!(&out[data..data + 4], b"data");
        assert_eq!(word(data + 4), 8);
        assert_eq!(out[data + 8..], [1, 0, 0xFE, 0xFF, 44, 1, 0, 0x80]);
    }

    #[test]
    fn a_full_disk_is_an_error() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::StorageFull.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let error = write_wav(48_000, 1, &[0], &mut Full).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    }
}
