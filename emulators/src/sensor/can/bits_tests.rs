//! Tests of `bits.rs`.

use super::*;

fn frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::new(id, data).unwrap()
}

/// The definition, bit by bit (Bosch CAN 2.0, section 3.1.1).
fn slow_crc(frame: &CanFrame) -> u16 {
    let (bits, length) = sequence(frame);
    (15..length).rev().fold(0, |crc: u16, shift| {
        let next = (bits >> shift & 1) as u16 ^ crc >> 14 & 1;
        (crc << 1 ^ if next == 1 { CRC_POLY } else { 0 }) & 0x7FFF
    })
}

fn slow_stuff(frame: &CanFrame) -> u32 {
    let (bits, length) = sequence(frame);
    let (mut last, mut run, mut count) = (2, 0, 0);
    for shift in (0..length).rev() {
        let bit = bits >> shift & 1;
        run = if bit == last { run + 1 } else { 1 };
        last = bit;
        if run == 5 {
            count += 1;
            last = 1 - bit;
            run = 1;
        }
    }
    count
}

#[test]
fn tables_agree_with_the_definition() {
    let mut stream = palpate_core::random::RandomStream::new(1, "bits");
    for n in 0..5000 {
        // Sparse data has long runs, and with them many stuff bits.
        let bytes = (stream.next_u64() & stream.next_u64() & stream.next_u64()).to_be_bytes();
        let id = (stream.next_u64() & stream.next_u64()) as u16 & 0x7FF;
        let f = frame(id, &bytes[..n % 9]);
        assert_eq!(crc_of(covered(&f).0), slow_crc(&f));
        assert_eq!(stuff_bits(&f), slow_stuff(&f));
        assert_eq!(stuffed(&f).count() as u32 + TRAILER, length(&f));
    }
}

#[test]
fn crc_has_the_published_check_value() {
    // CRC-15/CAN of "123456789" is 0x059E (reveng catalogue); the table is the same register.
    let crc = b"123456789"
        .iter()
        .rev()
        .zip(&CRC_TABLE)
        .fold(0, |crc, (&byte, table)| crc ^ table[usize::from(byte)]);
    assert_eq!(crc, 0x059E);
}

#[test]
fn a_full_frame_is_111_bits_unstuffed_and_135_at_most() {
    let f = frame(0x004, &[0x93, 0x7E, 0x31, 0x7E, 0x15, 0x93, 0x12, 0x0F]);
    assert_eq!(length(&f) - stuff_bits(&f) + INTERMISSION, 111);
    let worst = frame(0x078, &[0x3C; 8]);
    assert!(length(&worst) + INTERMISSION > 125, "{}", length(&worst));
    assert!(length(&worst) + INTERMISSION <= 135);
}

#[test]
fn a_command_and_data_of_one_identifier_differ_in_the_length_field() {
    let (command, data) = (frame(0x20c, &[7, 0]), frame(0x20c, &[0; 8]));
    let at = first_difference(&command, &data).unwrap();
    assert!((15..19 + 3).contains(&at), "{at}");
    assert_eq!(first_difference(&data, &data), None);
}
