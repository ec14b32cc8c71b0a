//! Names and types of a dump.

use std::io::Read;
use std::rc::Rc;

use super::super::declared::Wrong;
use super::input::Input;

/// Most bytes that names take, and most bytes of a name.
const MOST_NAMES: usize = 64 << 20;
const LONGEST_NAME: usize = 4096;
/// Most types, fields and dimensions.
const MOST_PARTS: usize = 1 << 20;
/// Most types within one another.
const DEEPEST: u32 = 64;

/// Kinds of types, by the format's numbers. Integers and physical types may have 32 or 64 bits.
const ENUMERATIONS: [u8; 2] = [22, 23];
const INTEGERS: [u8; 2] = [25, 26];
const REAL: u8 = 27;
const PHYSICALS: [u8; 2] = [28, 29];
const ARRAY: u8 = 31;
const RECORD: u8 = 32;
const SCALAR_SUBTYPE: u8 = 34;
const OPEN_SUBTYPES: [u8; 2] = [37, 39];
const SUBTYPES: [u8; 2] = [35, 38];

/// A value of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    /// The literal of an enumeration, by the index of its [`Literals`].
    Literal(u32),
    Integer,
    Real,
}

/// The literals of an enumeration: their number, and their signs if they are levels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Literals {
    pub(super) count: u64,
    pub(super) signs: &'static [u8],
}

/// A type.
#[derive(Debug)]
pub(super) struct Type {
    pub(super) shape: Shape,
    /// Scalars of a value; none where bounds are open.
    pub(super) scalars: Option<u64>,
    /// Types within one another.
    depth: u32,
}

/// Parts of a type. An array of several dimensions has arrays for elements.
#[derive(Debug)]
pub(super) enum Shape {
    Scalar(Scalar),
    Array(Rc<Type>, Range),
    OpenArray(Rc<Type>, u64),
    /// Fields: the number of the name, and the type.
    Record(Vec<(u64, Rc<Type>)>),
}

/// Indices of an array: left, right, and whether they count down.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range(pub(super) i64, pub(super) i64, bool);

impl Range {
    /// The number of indices.
    fn length(self) -> u64 {
        let distance = i128::from(self.1) - i128::from(self.0);
        let distance = if self.2 { -distance } else { distance };
        u64::try_from(distance + 1).unwrap_or_default()
    }

    /// Indices from left to right.
    pub(super) fn indices(self) -> impl Iterator<Item = i64> {
        let mut next = self.0;
        (0..self.length()).map(move |_| {
            let index = next;
            next = next.wrapping_add(if self.2 { -1 } else { 1 });
            index
        })
    }
}

/// Names by their numbers. Number 0 is no name.
pub(super) fn names(input: &mut Input<impl Read>) -> Result<Vec<String>, Wrong> {
    input.part = "whole names behind the header";
    input.expect(b"STR\0\0\0\0\0")?;
    let (count, size) = (input.word()?, input.word()?);
    let (mut names, mut name, mut kept, mut sum) = (vec![String::new()], Vec::new(), 0, 0);
    let mut shared = 0;
    for _ in 0..count {
        if shared > name.len() {
            return Err(input.wrong());
        }
        name.truncate(shared);
        let mut byte = input.byte()?;
        while !matches!(byte, 0..=31 | 128..=159) {
            name.push(byte);
            byte = input.byte()?;
            if name.len() > LONGEST_NAME || kept > MOST_NAMES {
                let expected = "names of at most 4096 bytes, and 64 MiB of them";
                return Err((expected, "more".into()));
            }
        }
        names.push(name.iter().map(|latin| char::from(*latin)).collect());
        kept += 2 * name.len() + size_of::<String>();
        sum += name.len();
        // Behind a name is the number of bytes that it shares with the next one, five bits in each byte.
        shared = usize::from(byte & 31);
        for shift in [5, 10, 15, 20] {
            if byte >= 128 {
                byte = input.byte()?;
                shared |= usize::from(byte & 31) << shift;
            }
        }
    }
    input.expect(b"EOS\0")?;
    match sum == size as usize {
        true => Ok(names),
        false => Err(input.wrong()),
    }
}

/// The types of a dump.
#[derive(Debug, Default)]
pub(super) struct Types {
    types: Vec<Rc<Type>>,
    literals: Vec<Literals>,
    parts: usize,
}

impl Types {
    /// Reads the types, and which of them are levels. Units came with version 1 of the format.
    pub(super) fn read(input: &mut Input<impl Read>, version: u8) -> Result<Self, Wrong> {
        input.part = "whole types behind the names";
        input.expect(b"TYP\0\0\0\0\0")?;
        let mut types = Self::default();
        let count = input.word()?;
        if count as usize > MOST_PARTS {
            return Err(too_many());
        }
        for _ in 0..count {
            let next = types.next(input, version)?;
            types.types.push(next);
        }
        input.expect(b"\0WKT\0\0\0\0\0")?;
        loop {
            let signs: &[u8] = match input.byte()? {
                0 => return Ok(types),
                1 | 2 => b"01",    // `boolean` and `bit`
                _ => b"ux01zwlh-", // `std_ulogic`
            };
            let literals = match types.named(input)?.shape {
                Shape::Scalar(Scalar::Literal(index)) => types.literals.get_mut(index as usize),
                _ => None,
            };
            let known = literals.filter(|literals| literals.count == signs.len() as u64);
            known.ok_or_else(|| input.wrong())?.signs = signs;
        }
    }

    /// Reads the number of an earlier type.
    pub(super) fn named(&self, input: &mut Input<impl Read>) -> Result<Rc<Type>, Wrong> {
        let index = usize::try_from(input.number()?.wrapping_sub(1)).ok();
        let known = index.and_then(|index| self.types.get(index));
        known.cloned().ok_or_else(|| input.wrong())
    }

    /// The literals of an enumeration.
    pub(super) fn literals(&self, index: u32) -> Literals {
        self.literals[index as usize]
    }

    /// Reads a type.
    fn next(&mut self, input: &mut Input<impl Read>, version: u8) -> Result<Rc<Type>, Wrong> {
        let kind = input.byte()?;
        let _name = input.number()?;
        match kind {
            _ if ENUMERATIONS.contains(&kind) => {
                let count = input.number()?;
                for _ in 0..count {
                    input.number()?;
                }
                self.literals.push(Literals { count, signs: &[] });
                let index = self.literals.len() as u32 - 1;
                self.keep(Shape::Scalar(Scalar::Literal(index)))
            }
            _ if INTEGERS.contains(&kind) => self.keep(Shape::Scalar(Scalar::Integer)),
            _ if PHYSICALS.contains(&kind) => {
                let units = if version > 0 { input.number()? } else { 0 };
                for _ in 0..units {
                    input.number()?;
                    input.signed()?;
                }
                self.keep(Shape::Scalar(Scalar::Integer))
            }
            REAL => self.keep(Shape::Scalar(Scalar::Real)),
            SCALAR_SUBTYPE => {
                let base = self.named(input)?;
                range(input)?;
                Ok(base)
            }
            _ if OPEN_SUBTYPES.contains(&kind) => self.named(input),
            _ if SUBTYPES.contains(&kind) => {
                let base = self.named(input)?;
                self.closed(input, &base)
            }
            ARRAY => {
                let (element, dimensions) = (self.named(input)?, input.number()?);
                if dimensions > DEEPEST.into() {
                    return Err(too_many());
                }
                for _ in 0..dimensions {
                    self.named(input)?;
                }
                self.keep(Shape::OpenArray(element, dimensions))
            }
            RECORD => {
                let (mut fields, count) = (Vec::new(), input.number()?);
                if count > MOST_PARTS as u64 {
                    return Err(too_many());
                }
                for _ in 0..count {
                    fields.push((input.number()?, self.named(input)?));
                }
                self.keep(Shape::Record(fields))
            }
            _ => Err(input.wrong()),
        }
    }

    /// A type with the bounds that follow if its own are open.
    fn closed(&mut self, input: &mut Input<impl Read>, of: &Rc<Type>) -> Result<Rc<Type>, Wrong> {
        match &of.shape {
            _ if of.scalars.is_some() => Ok(Rc::clone(of)),
            Shape::Record(open) => {
                let mut fields = Vec::new();
                for (name, field) in open {
                    fields.push((*name, self.closed(input, field)?));
                }
                self.keep(Shape::Record(fields))
            }
            Shape::OpenArray(element, dimensions) => {
                let mut ranges = Vec::new();
                for _ in 0..*dimensions {
                    ranges.push(range(input)?.ok_or_else(|| input.wrong())?);
                }
                let element = self.closed(input, element)?;
                let mut inwards = ranges.into_iter().rev();
                inwards.try_fold(element, |of, range| self.keep(Shape::Array(of, range)))
            }
            Shape::Scalar(_) | Shape::Array(..) => Err(input.wrong()),
        }
    }

    /// Makes a type of its parts, which are counted. Fields without a scalar are left out.
    fn keep(&mut self, mut shape: Shape) -> Result<Rc<Type>, Wrong> {
        let (mut scalars, mut depth, mut parts) = (Some(1_u64), 0, 1);
        match &mut shape {
            Shape::Scalar(_) => {}
            Shape::OpenArray(of, _) => (scalars, depth) = (None, of.depth + 1),
            Shape::Array(of, range) => {
                scalars = of.scalars.map(|n| n.saturating_mul(range.length()));
                depth = of.depth + 1;
            }
            Shape::Record(fields) => {
                fields.retain(|field| field.1.scalars != Some(0));
                let mut of = fields.iter().map(|field| field.1.scalars);
                scalars = of.try_fold(0_u64, |sum, n| n.map(|n| sum.saturating_add(n)));
                depth = 1 + fields.iter().fold(0, |most, field| most.max(field.1.depth));
                parts += fields.len();
            }
        }
        self.parts += parts;
        if self.parts > MOST_PARTS || depth > DEEPEST {
            return Err(too_many());
        }
        let of = Type {
            shape,
            scalars,
            depth,
        };
        Ok(Rc::new(of))
    }
}

fn too_many() -> Wrong {
    let expected = "at most 1048576 types and fields, and 64 within one another";
    (expected, "more".into())
}

/// Reads the bounds of a type; none for those of a real.
fn range(input: &mut Input<impl Read>) -> Result<Option<Range>, Wrong> {
    let kind = input.byte()?;
    let (of, is_down) = (kind & 0x7f, kind & 0x80 != 0);
    let (left, right) = match of {
        _ if ENUMERATIONS.contains(&of) => (input.byte()?.into(), input.byte()?.into()),
        _ if INTEGERS.contains(&of) || PHYSICALS.contains(&of) => {
            (input.signed()?, input.signed()?)
        }
        REAL => return input.take::<16>().map(|_| None),
        _ => return Err(input.wrong()),
    };
    Ok(Some(Range(left, right, is_down)))
}
