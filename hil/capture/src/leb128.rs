//! Numbers in LEB128: seven bits in each byte, the lowest first.

/// A number without a sign; none where it has more than 64 bits.
///
/// # Errors
/// The first error of `next`, which gives the bytes.
pub(super) fn unsigned<E>(mut next: impl FnMut() -> Result<u8, E>) -> Result<Option<u64>, E> {
    let mut number = 0;
    for shift in (0..64).step_by(7) {
        let byte = next()?;
        let bits = u64::from(byte & 0x7f);
        number |= bits << shift;
        if byte & 0x80 == 0 {
            return Ok((shift < 63 || bits < 2).then_some(number));
        }
    }
    Ok(None)
}

/// A number with a sign; none where it has more than 64 bits.
///
/// # Errors
/// The first error of `next`, which gives the bytes.
pub(super) fn signed<E>(mut next: impl FnMut() -> Result<u8, E>) -> Result<Option<i64>, E> {
    let mut number = 0;
    for shift in (0..64).step_by(7) {
        let byte = next()?;
        number |= i64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            let is_negative = byte & 0x40 != 0 && shift < 57;
            return Ok(Some(match is_negative {
                true => number | (-1 << (shift + 7)),
                false => number,
            }));
        }
    }
    Ok(None)
}
