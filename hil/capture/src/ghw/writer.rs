//! A writer of GHW dumps for tests.

/// Types that every dump of [`Writer`] begins with, by their numbers.
pub const STD_ULOGIC: u64 = 1;
pub const STD_LOGIC: u64 = 2;
pub const BIT: u64 = 3;
pub const BOOLEAN: u64 = 4;
pub const INTEGER: u64 = 5;
pub const REAL: u64 = 6;
pub const TIME: u64 = 7;
pub const STD_LOGIC_VECTOR: u64 = 8;

/// A cycle: its time, and the scalars that change with the bytes of their values.
pub type Cycle = (i64, Vec<(u64, Vec<u8>)>);

/// A dump as it grows.
pub struct Writer {
    is_big_endian: bool,
    names: Vec<String>,
    types: u32,
    type_bytes: Vec<u8>,
    hierarchy: Vec<u8>,
    body: Vec<u8>,
    sections: u32,
}

pub fn number(mut number: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while number > 0x7f {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
    bytes
}

pub fn signed(mut number: i64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while !(-0x40..0x40).contains(&number) {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8 & 0x7f);
    bytes
}

impl Writer {
    pub fn new(is_big_endian: bool) -> Self {
        let mut writer = Self {
            is_big_endian,
            names: Vec::new(),
            types: 0,
            type_bytes: Vec::new(),
            hierarchy: Vec::new(),
            body: Vec::new(),
            sections: 6,
        };
        let literals: Vec<String> = "UX01ZWLH-".chars().map(|c| format!("'{c}'")).collect();
        let literals: Vec<&str> = literals.iter().map(String::as_str).collect();
        writer.enumeration("std_ulogic", &literals);
        writer.of_type(34, "std_logic", &[&[STD_ULOGIC as u8, 23, 0, 8]]);
        writer.enumeration("bit", &["'0'", "'1'"]);
        writer.enumeration("boolean", &["false", "true"]);
        writer.of_type(25, "integer", &[]);
        writer.of_type(27, "real", &[]);
        let fs = number(writer.name("fs"));
        writer.of_type(29, "time", &[&[1], &fs, &[1]]);
        writer.of_type(
            31,
            "std_logic_vector",
            &[&[STD_LOGIC as u8, 1, INTEGER as u8]],
        );
        writer
    }

    fn name(&mut self, name: &str) -> u64 {
        let known = self.names.iter().position(|known| known == name);
        known.unwrap_or_else(|| {
            self.names.push(name.into());
            self.names.len() - 1
        }) as u64
            + 1
    }

    /// Adds a type, and gives its number.
    pub fn of_type(&mut self, kind: u8, name: &str, rest: &[&[u8]]) -> u64 {
        let name = self.name(name);
        self.type_bytes.push(kind);
        self.type_bytes.extend(number(name));
        self.type_bytes.extend(rest.concat());
        self.types += 1;
        self.types.into()
    }

    pub fn enumeration(&mut self, name: &str, literals: &[&str]) -> u64 {
        let mut rest = number(literals.len() as u64);
        for literal in literals {
            rest.extend(number(self.name(literal)));
        }
        self.of_type(if literals.len() == 2 { 22 } else { 23 }, name, &[&rest])
    }

    /// Adds an array type without open bounds, with integers for indices.
    pub fn vector(&mut self, array: u64, left: i64, right: i64) -> u64 {
        let kind = if left > right { 25 | 0x80 } else { 25 };
        let rest = [&number(array)[..], &[kind], &signed(left), &signed(right)];
        self.of_type(35, "", &rest)
    }

    /// Adds an array type without an element.
    pub fn null(&mut self, array: u64) -> u64 {
        self.of_type(35, "", &[&number(array), &[25, 1, 0]])
    }

    pub fn record(&mut self, name: &str, fields: &[(&str, u64)]) -> u64 {
        let mut rest = number(fields.len() as u64);
        for (field, of) in fields {
            rest.extend(number(self.name(field)));
            rest.extend(number(*of));
        }
        self.of_type(32, name, &[&rest])
    }

    pub fn scope(&mut self, kind: u8, name: &str) {
        let name = self.name(name);
        self.hierarchy.push(kind);
        self.hierarchy.extend(number(name));
    }

    /// Ends a scope, or follows a scope that is repeated with the index.
    pub fn raw(&mut self, bytes: &[u8]) {
        self.hierarchy.extend(bytes);
    }

    /// Declares a signal of this type with the numbers of its scalars.
    pub fn signal(&mut self, name: &str, of: u64, scalars: &[u64]) {
        self.scope(16, name);
        self.hierarchy.extend(number(of));
        self.hierarchy
            .extend(scalars.iter().flat_map(|n| number(*n)));
    }

    fn word(&self, word: u32) -> [u8; 4] {
        match self.is_big_endian {
            true => word.to_be_bytes(),
            false => word.to_le_bytes(),
        }
    }

    fn wide(&self, wide: i64) -> [u8; 8] {
        match self.is_big_endian {
            true => wide.to_be_bytes(),
            false => wide.to_le_bytes(),
        }
    }

    /// Adds a snapshot of all values, in bytes.
    pub fn snapshot(&mut self, time: i64, values: &[u8]) {
        let time = self.wide(time);
        let parts = [b"SNP\0\0\0\0\0", &time[..], values, b"ESN\0"].concat();
        self.body.extend(parts);
        self.sections += 1;
    }

    /// Adds cycles.
    pub fn cycles(&mut self, cycles: &[Cycle]) {
        let Some((first, _)) = cycles.first() else {
            return;
        };
        self.body
            .extend([&b"CYC\0"[..], &self.wide(*first)].concat());
        let mut now = *first;
        for (n, (time, changes)) in cycles.iter().enumerate() {
            if n > 0 {
                self.body.extend(signed(time - now));
            }
            now = *time;
            let mut last = 0;
            for (scalar, value) in changes {
                self.body.extend(number(scalar - last));
                self.body.extend(value);
                last = *scalar;
            }
            self.body.push(0);
        }
        self.body.extend(b"\x7fECY\0");
        self.sections += 1;
    }

    fn names(&self) -> Vec<u8> {
        let sum = self.names.iter().map(String::len).sum::<usize>();
        let mut bytes = b"STR\0\0\0\0\0".to_vec();
        bytes.extend(self.word(self.names.len() as u32));
        bytes.extend(self.word(sum as u32));
        let mut last = "";
        for (n, name) in self.names.iter().enumerate() {
            let pairs = last.bytes().zip(name.bytes());
            let shared = pairs.take_while(|(a, b)| a == b).count();
            let mut left = shared;
            while left > 31 {
                bytes.push((left % 32) as u8 | 0x80);
                left /= 32;
            }
            // The first name has none before it.
            bytes.extend((n > 0).then_some(left as u8));
            bytes.extend(&name.as_bytes()[shared..]);
            last = name;
        }
        bytes.extend(b"\0EOS\0");
        bytes
    }

    pub fn finish(self) -> Vec<u8> {
        let order = [if self.is_big_endian { 2 } else { 1 }, 4, 1, 0];
        let known = [1, BOOLEAN, 2, BIT, 3, STD_ULOGIC].map(|byte| byte as u8);
        let directory = [0; 8].repeat(self.sections as usize);
        [
            b"GHDLwave\n\x10\0\x01",
            &order[..],
            &self.names(),
            b"TYP\0\0\0\0\0",
            &self.word(self.types),
            &self.type_bytes,
            b"\0WKT\0\0\0\0\0",
            &known,
            b"\0HIE\0\0\0\0\0",
            &[0; 12],
            &self.hierarchy,
            b"\0EOH\0",
            &self.body,
            b"DIR\0",
            &order,
            &self.word(self.sections),
            &directory,
            b"EOD\0TAI\0",
            &order,
            &[0; 4],
        ]
        .concat()
    }
}
