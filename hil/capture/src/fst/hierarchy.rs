//! Declarations of a dump: scopes, variables, and attributes, which are passed over.

use super::super::declared::{Declared, Wrong, damaged};
use super::bytes::Bytes;

/// Kinds of entries, by the format's numbers; a lower one is that of a variable.
const LAST_VARIABLE: u8 = 29;
const ATTRIBUTE: u8 = 252;
const ATTRIBUTE_END: u8 = 253;
const SCOPE: u8 = 254;
const UPSCOPE: u8 = 255;
/// Kinds of variables that are no levels: events, integers (of one bit in a dump of GHDL), parameters, reals, ports with strengths,
/// texts.
const NO_LEVELS: [u8; 9] = [0, 1, 2, 3, 4, 18, 20, 21, 29];

/// The signals of one bit by their handles, which count from 1, and the number of handles.
pub(super) fn declared(hierarchy: &[u8]) -> Result<(Declared<u64>, u64), Wrong> {
    let (mut signals, mut handles) = (Declared::none(), 0);
    let mut bytes = Bytes(hierarchy);
    while !bytes.0.is_empty() {
        entry(&mut bytes, &mut signals, &mut handles)
            .ok_or_else(|| damaged("a hierarchy of scopes and variables"))??;
    }
    Ok((signals, handles))
}

/// Reads an entry; none where it is damaged.
fn entry(
    bytes: &mut Bytes<'_>,
    signals: &mut Declared<u64>,
    handles: &mut u64,
) -> Option<Result<(), Wrong>> {
    let kind = bytes.byte()?;
    match kind {
        SCOPE => {
            bytes.byte()?;
            let (name, _component) = (bytes.text()?, bytes.text()?);
            return Some(signals.enter(name));
        }
        UPSCOPE => signals.leave(),
        ATTRIBUTE => {
            bytes.take(2)?;
            bytes.text()?;
            bytes.number()?;
        }
        ATTRIBUTE_END => {}
        ..=LAST_VARIABLE => {
            let _direction = bytes.byte()?;
            let name = bytes.text()?;
            let (width, alias) = (bytes.number()?, bytes.number()?);
            if alias > *handles {
                return None;
            }
            *handles += u64::from(alias == 0);
            let handle = if alias == 0 { *handles } else { alias };
            if width == 1 && !NO_LEVELS.contains(&kind) {
                return Some(signals.add(handle, name.split_ascii_whitespace()));
            }
        }
        _ => return None,
    }
    Some(Ok(()))
}
