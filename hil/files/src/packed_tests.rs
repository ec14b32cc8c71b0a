//! Tests of `packed.rs`. The packed bytes are those of Python's zstandard and lz4.

use super::*;

/// `zstandard.ZstdCompressor(level=19).compress(PLAIN)`.
const BY_ZSTD: &[u8] = &[
    0x28, 0xB5, 0x2F, 0xFD, 0x20, 0x1C, 0x75, 0x00, 0x00, 0x40, 0x50, 0x61, 0x6C, 0x70, 0x61, 0x74,
    0x65, 0x50, 0x01, 0x00, 0xA2, 0x0B, 0x17,
];
/// `lz4.frame.compress(PLAIN, compression_level=12)`.
const BY_LZ4: &[u8] = &[
    0x04, 0x22, 0x4D, 0x18, 0x68, 0x40, 0x1C, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x8F, 0x10,
    0x00, 0x00, 0x00, 0x7C, 0x50, 0x61, 0x6C, 0x70, 0x61, 0x74, 0x65, 0x07, 0x00, 0x50, 0x6C, 0x70,
    0x61, 0x74, 0x65, 0x00, 0x00, 0x00, 0x00,
];
const PLAIN: &[u8] = b"PalpatePalpatePalpatePalpate";

fn record(kind: u8, body: &[u8]) -> Vec<u8> {
    [&[kind][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

fn chunk(packing: &str, plain: &[u8], packed: &[u8]) -> Vec<u8> {
    let body = [
        &[7; 16][..],
        &(plain.len() as u64).to_le_bytes(),
        &crc32fast::hash(plain).to_le_bytes(),
        &u32::try_from(packing.len()).unwrap().to_le_bytes(),
        packing.as_bytes(),
        &(packed.len() as u64).to_le_bytes(),
        packed,
    ];
    record(CHUNK, &body.concat())
}

fn file(chunks: &[Vec<u8>]) -> Vec<u8> {
    let (before, after) = (record(1, b"head"), record(0x0f, &[0; 4]));
    [MAGIC, &before, &chunks.concat(), &after, MAGIC].concat()
}

/// Reads in pieces of this many bytes.
fn read(bytes: &[u8], piece: usize) -> Vec<u8> {
    let (mut unpacked, mut all) = (Unpacked::new(bytes), Vec::new());
    let mut out = vec![0; piece];
    loop {
        match unpacked.read(&mut out).unwrap() {
            0 => return all,
            read => all.extend_from_slice(&out[..read]),
        }
    }
}

#[test]
fn a_packed_file_reads_as_one_without_packing() {
    let plain = chunk("", PLAIN, PLAIN);
    let packed = file(&[
        plain.clone(),
        chunk("zstd", PLAIN, BY_ZSTD),
        chunk("lz4", PLAIN, BY_LZ4),
    ]);
    let expected = file(&[plain.clone(), plain.clone(), plain]);
    for piece in [1, 7, 4096] {
        assert_eq!(read(&packed, piece), expected, "in pieces of {piece}");
        assert_eq!(read(&expected, piece), expected, "in pieces of {piece}");
    }
}

/// Readers refuse a packed chunk, and know of one that was cut short.
#[test]
fn a_chunk_that_cannot_be_unpacked_stays_as_it_is() {
    let longer = [PLAIN, b"!"].concat();
    let plain = file(&[chunk("", PLAIN, PLAIN)]);
    for (packing, packed) in [("zstd", BY_ZSTD), ("lz4", BY_LZ4)] {
        for end in 0..packed.len() {
            let mut bent = packed.to_vec();
            bent[end] ^= 0x10;
            // The checksum of the records certifies a chunk that lost only its frame's end.
            for broken in [&packed[..end], &bent] {
                let broken = file(&[chunk(packing, PLAIN, broken)]);
                let found = read(&broken, 64);
                assert!(found == broken || found == plain, "{packing}: byte {end}");
            }
        }
        let other = file(&[chunk(packing, &longer, packed)]);
        assert_eq!(read(&other, 64), other, "{packing} of another length");
        let whole = file(&[chunk(packing, PLAIN, packed)]);
        for end in 0..whole.len() {
            let start = read(&whole[..end], 64);
            assert!(
                start == whole[..end] || end >= whole.len() - 21,
                "{packing}, cut at {end}"
            );
        }
    }
    let other = file(&[chunk("brotli", PLAIN, PLAIN)]);
    assert_eq!(read(&other, 64), other);
}
