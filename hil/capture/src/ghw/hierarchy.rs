//! Declarations of a dump: scopes, and signals by the numbers of their scalars.

use std::io::Read;

use super::super::declared::{Declared, Wrong};
use super::input::Input;
use super::types::{Scalar, Shape, Type, Types};

/// Kinds of entries, by the format's numbers.
const END: u8 = 0;
const REPEATED_SCOPE: u8 = 5;
const SCOPES: [u8; 6] = [3, 4, REPEATED_SCOPE, 6, 7, 14];
const PROCESS: u8 = 13;
const SCOPE_END: u8 = 15;
/// Most scalars of all signals.
const MOST_SCALARS: u64 = 4 << 20;

/// A hierarchy as far as it was read.
struct Hierarchy<'a, R> {
    input: &'a mut Input<R>,
    names: &'a [String],
    types: &'a Types,
    declared: Declared<u32>,
    scalars: Vec<Option<Scalar>>,
}

/// The signals of one bit, and the numbers and kinds of all scalars in the order of their values.
pub(super) type Declarations = (Declared<u32>, Vec<(u32, Scalar)>);

/// Reads the hierarchy.
pub(super) fn declared<R: Read>(
    input: &mut Input<R>,
    names: &[String],
    types: &Types,
) -> Result<Declarations, Wrong> {
    input.part = "a whole hierarchy of scopes and signals behind the types";
    input.expect(b"HIE\0\0\0\0\0")?;
    let _counts: [u8; 12] = input.take()?;
    let mut hierarchy = Hierarchy {
        input,
        names,
        types,
        declared: Declared::none(),
        scalars: Vec::new(),
    };
    let mut open = 0_u64;
    loop {
        match hierarchy.input.byte()? {
            END if open == 0 => break,
            SCOPE_END if open > 0 => {
                open -= 1;
                hierarchy.declared.leave();
            }
            kind => open += u64::from(hierarchy.entry(kind)?),
        }
    }
    hierarchy.input.expect(b"EOH\0")?;
    let scalars = (0..).zip(hierarchy.scalars);
    let scalars = scalars.filter_map(|(number, scalar)| Some((number, scalar?)));
    Ok((hierarchy.declared, scalars.collect()))
}

impl<R: Read> Hierarchy<'_, R> {
    /// Reads an entry with a name; true for one that begins a scope.
    fn entry(&mut self, kind: u8) -> Result<bool, Wrong> {
        let number = self.input.number()?;
        let mut name = self.name(number)?.to_owned();
        let is_scope = SCOPES.contains(&kind);
        match kind {
            PROCESS => {}
            _ if is_scope => {
                if kind == REPEATED_SCOPE {
                    let index = match self.types.named(self.input)?.shape {
                        Shape::Scalar(Scalar::Literal(_)) => self.input.byte()?.into(),
                        _ => self.input.signed()?,
                    };
                    name += &format!("({index})");
                }
                self.declared.enter(name)?;
            }
            // signals and ports
            16..=21 => {
                let of = self.types.named(self.input)?;
                self.signal(name, &of)?;
            }
            _ => return Err(self.input.wrong()),
        }
        Ok(is_scope)
    }

    fn name(&self, number: u64) -> Result<&str, Wrong> {
        let name = usize::try_from(number).ok();
        let name = name.and_then(|number| self.names.get(number));
        name.map(String::as_str).ok_or_else(|| self.input.wrong())
    }

    /// Reads the numbers of a signal's scalars. Parts of one bit are declared; a bus has no level.
    fn signal(&mut self, name: String, of: &Type) -> Result<(), Wrong> {
        match &of.shape {
            _ if of.scalars == Some(0) => {}
            Shape::Scalar(scalar) => self.scalar(*scalar, Some(&name))?,
            Shape::Array(element, range) => match element.shape {
                Shape::Scalar(scalar) => {
                    let is_bit = of.scalars == Some(1);
                    let name = is_bit.then(|| format!("{name}[{}:{}]", range.0, range.1));
                    for _ in range.indices() {
                        self.scalar(scalar, name.as_deref())?;
                    }
                }
                _ => {
                    for index in range.indices() {
                        self.signal(format!("{name}[{index}]"), element)?;
                    }
                }
            },
            Shape::Record(fields) => {
                self.declared.enter(name)?;
                for (field, of) in fields {
                    self.signal(self.name(*field)?.to_owned(), of)?;
                }
                self.declared.leave();
            }
            Shape::OpenArray(..) => return Err(self.input.wrong()),
        }
        Ok(())
    }

    /// Reads the number of a scalar, and declares one that is a level and has a name. Ports share the numbers of their signals.
    fn scalar(&mut self, scalar: Scalar, name: Option<&str>) -> Result<(), Wrong> {
        let number = self.input.number()?;
        if number > MOST_SCALARS {
            let expected =
                "at most 4194304 scalars (--read-wave-opt=FILE of ghdl leaves signals out)";
            return Err((expected, "more".into()));
        }
        let index = number as usize;
        if index >= self.scalars.len() {
            self.scalars.resize(index + 1, None);
        }
        let known = self.scalars[index].replace(scalar);
        if number == 0 || known.is_some_and(|known| known != scalar) {
            return Err(self.input.wrong());
        }
        match (scalar, name) {
            (Scalar::Literal(literals), Some(name))
                if !self.types.literals(literals).signs.is_empty() =>
            {
                self.declared.add(number as u32, [name])
            }
            _ => Ok(()),
        }
    }
}
