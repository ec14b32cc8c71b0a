//! Dumps beside the same waveforms as VCD, and dumps that are damaged.

use std::fmt::Write;

use super::super::draws::{Draws, mutate};
use super::super::dump;
use super::writer::*;
use super::*;

/// Kinds of signals of one bit: the type, and the letters of its literals.
const BITS: [(u64, &[u8]); 4] = [
    (STD_LOGIC, b"UX01ZWLH-"),
    (STD_ULOGIC, b"UX01ZWLH-"),
    (BIT, b"01"),
    (BOOLEAN, b"01"),
];

/// A scalar of a waveform: its kind in [`BITS`] and the code of its VCD, if it is of one bit, or its type.
enum Drawn {
    Bit(usize, String),
    Bus,
    Other(u64),
}

/// Two dumps of one waveform as they grow.
struct Both {
    ghw: Writer,
    vcd: String,
    scalars: Vec<Drawn>,
}

impl Both {
    /// Declares a signal of one bit, in a vector or without one, or again under another name as a port does.
    fn bit(&mut self, draw: &mut Draws) {
        let bits: Vec<usize> = (0..self.scalars.len())
            .filter(|n| matches!(self.scalars[*n], Drawn::Bit(..)))
            .collect();
        let name = format!("pin{}", self.scalars.len());
        if draw.below(4) == 0 && !bits.is_empty() {
            let n = bits[draw.below(bits.len())];
            let Drawn::Bit(kind, code) = &self.scalars[n] else {
                unreachable!()
            };
            let of = BITS[*kind].0;
            writeln!(self.vcd, "$var wire 1 {code} {name} $end").unwrap();
            self.ghw.signal(&name, of, &[n as u64 + 1]);
            return;
        }
        let kind = draw.below(4);
        let of = BITS[kind].0;
        let code = format!("c{}", self.scalars.len());
        let is_vector = of == STD_LOGIC && draw.below(2) == 0;
        let (of, index) = match is_vector {
            true => (self.ghw.vector(STD_LOGIC_VECTOR, 2, 2), "[2:2]"),
            false => (of, ""),
        };
        writeln!(self.vcd, "$var reg 1 {code} {name}{index} $end").unwrap();
        self.ghw.signal(&name, of, &[self.scalars.len() as u64 + 1]);
        self.scalars.push(Drawn::Bit(kind, code));
    }

    /// Declares what has no level of its own: a bus, numbers, a null vector, and an array of records, which has pins in it.
    fn beside(&mut self, draw: &mut Draws) {
        let first = self.scalars.len() as u64 + 1;
        match draw.below(4) {
            0 => {
                let of = self.ghw.vector(STD_LOGIC_VECTOR, 3, 0);
                let numbers: Vec<u64> = (first..first + 4).collect();
                self.ghw.signal("bus", of, &numbers);
                self.scalars.extend([(); 4].map(|()| Drawn::Bus));
            }
            1 => {
                let of = [INTEGER, REAL, TIME][draw.below(3)];
                self.ghw.signal("count", of, &[first]);
                self.scalars.push(Drawn::Other(of));
            }
            2 => {
                let of = self.ghw.vector(STD_LOGIC_VECTOR, 0, 3);
                let null = self.ghw.null(STD_LOGIC_VECTOR);
                let of = self.ghw.record(
                    "pair",
                    &[("led", BIT), ("n", INTEGER), ("v", of), ("none", null)],
                );
                let index = [INTEGER as u8];
                let of = self.ghw.of_type(31, "pairs", &[&number(of), &[1], &index]);
                let of = self.ghw.vector(of, 1, 0);
                let numbers: Vec<u64> = (first..first + 12).collect();
                self.ghw.signal("pairs", of, &numbers);
                for n in [1, 0] {
                    let code = format!("c{}", self.scalars.len());
                    let scope =
                        format!("$scope module pairs[{n}] $end\n$var reg 1 {code} led $end\n");
                    self.vcd += &(scope + "$upscope $end\n");
                    self.scalars
                        .extend([Drawn::Bit(2, code), Drawn::Other(INTEGER)]);
                    self.scalars.extend([(); 4].map(|()| Drawn::Bus));
                }
            }
            _ => {
                let of = self.ghw.null(STD_LOGIC_VECTOR);
                self.ghw.signal("none", of, &[]);
            }
        }
    }

    /// Draws the bytes of a value, and writes one of a bit to the VCD.
    fn value(&mut self, n: usize, draw: &mut Draws) -> Vec<u8> {
        match &self.scalars[n] {
            Drawn::Bit(kind, code) => {
                let letters = BITS[*kind].1;
                let literal = draw.below(letters.len());
                writeln!(self.vcd, "{}{code}", char::from(letters[literal])).unwrap();
                vec![literal as u8]
            }
            Drawn::Bus => vec![draw.below(9) as u8],
            Drawn::Other(REAL) => 1.5_f64.to_le_bytes().to_vec(),
            Drawn::Other(_) => signed(draw.below(1 << 40) as i64 - (1 << 39)),
        }
    }
}

/// A waveform as GHW and VCD.
fn waveform(draw: &mut Draws) -> (Vec<u8>, String) {
    let mut both = Both {
        ghw: Writer::new(draw.below(2) == 0),
        vcd: "$timescale 1 fs $end\n".into(),
        scalars: Vec::new(),
    };
    let scopes = 1 + draw.below(3);
    for scope in 0..scopes {
        let (kind, name) = [(6, "tb"), (7, "package"), (5, "g(3)")][draw.below(3)];
        both.ghw.scope(kind, name.trim_end_matches("(3)"));
        if kind == 5 {
            both.ghw.raw(&[INTEGER as u8, 3]);
        }
        writeln!(both.vcd, "$scope module {name} $end").unwrap();
        if scope == 0 {
            both.bit(draw);
        }
        for _ in 0..draw.below(4) {
            both.bit(draw);
            both.beside(draw);
        }
        both.ghw.scope(13, "a process");
    }
    both.ghw.raw(&vec![15; scopes]);
    both.vcd += &"$upscope $end\n".repeat(scopes);
    both.vcd += "$enddefinitions $end\n";
    let mut now = draw.below(100) as i64 * 1_000_000;
    writeln!(both.vcd, "#{now}").unwrap();
    let values: Vec<u8> = (0..both.scalars.len())
        .flat_map(|n| both.value(n, draw))
        .collect();
    both.ghw.snapshot(now, &values);
    let mut cycles = Vec::new();
    for _ in 0..draw.below(300) {
        now += 1 + draw.below(3_000_000_000) as i64;
        writeln!(both.vcd, "#{now}").unwrap();
        let drawn: Vec<usize> = (0..both.scalars.len())
            .filter(|_| draw.below(3) == 0)
            .collect();
        // A change at the same time, which the last one overrides.
        let first: Vec<(u64, Vec<u8>)> = drawn
            .iter()
            .filter(|n| matches!(both.scalars[**n], Drawn::Bit(..)))
            .map(|n| (*n as u64 + 1, vec![1]))
            .collect();
        cycles.push((now, first));
        let changes = drawn.iter().map(|n| (*n as u64 + 1, both.value(*n, draw)));
        cycles.push((now, changes.collect()));
        if draw.below(20) == 0 {
            both.ghw.cycles(&std::mem::take(&mut cycles));
        }
    }
    both.ghw.cycles(&cycles);
    (both.ghw.finish(), both.vcd)
}

#[test]
fn a_dump_reads_like_the_same_waveform_as_vcd() {
    let mut draw = Draws(0x9E37_79B9_7F4A_7C15);
    let (mut edges, mut unseen, mut aliases) = (0, 0, 0);
    for _ in 0..300 {
        let (ghw, vcd) = waveform(&mut draw);
        let found = read("a.ghw", &*ghw).unwrap();
        assert_eq!(found, dump::read("a.vcd", vcd.as_bytes()).unwrap(), "{vcd}");
        edges += found.signals.iter().map(|s| s.edges.len()).sum::<usize>();
        unseen += found.signals.iter().map(|s| s.unseen.len()).sum::<usize>();
        aliases += found
            .signals
            .iter()
            .filter(|s| s.addresses.len() > 1)
            .count();
    }
    assert!(
        edges > 10_000 && unseen > 1000 && aliases > 100,
        "{edges} edges, {unseen} unseen, {aliases} aliases"
    );
}

#[test]
fn a_dump_that_is_cut_is_refused_wherever_it_is_cut() {
    let (whole, _) = waveform(&mut Draws(77));
    assert!(read("a.ghw", &*whole).is_ok());
    for length in 0..whole.len() {
        let error = read("a.ghw", &whole[..length]).unwrap_err();
        assert!(
            error.to_string().contains("a damaged or unfinished dump"),
            "{length}: {error}"
        );
    }
    assert!(read("a.ghw", &*[&whole[..], b"x"].concat()).is_err());
}

#[test]
fn mutations_of_a_dump_are_read_or_refused() {
    mutate(
        5,
        |draw| waveform(draw).0,
        |bytes| {
            let found = read("a.ghw", bytes);
            found
                .map_err(|error| assert!(!error.found.is_empty()))
                .is_ok()
        },
    );
}

/// Types that would take a processor or memory for hours.
#[test]
fn types_that_grow_without_end_are_refused() {
    let refused = |types: &dyn Fn(&mut Writer) -> u64, expected: &str| {
        let mut ghw = Writer::new(false);
        let of = types(&mut ghw);
        ghw.signal("all", of, &[1; 100]);
        ghw.snapshot(0, &[0]);
        let error = read("a.ghw", &*ghw.finish()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    let doubled =
        |ghw: &mut Writer| (0..100).fold(BIT, |of, _| ghw.record("both", &[("a", of), ("b", of)]));
    refused(&doubled, "64 within one another");
    let nothing = |ghw: &mut Writer| {
        let null = ghw.null(STD_LOGIC_VECTOR);
        let null = (0..60).fold(null, |of, _| ghw.record("both", &[("a", of), ("b", of)]));
        ghw.record("huge", &[("a", null), ("b", TIME + 100)])
    };
    refused(&nothing, "whole types");
    let long = |ghw: &mut Writer| ghw.vector(STD_LOGIC_VECTOR, i64::MIN, i64::MAX);
    refused(&long, "whole hierarchy");
    let open = |_: &mut Writer| STD_LOGIC_VECTOR;
    refused(&open, "whole hierarchy");
    let copied = |ghw: &mut Writer| {
        let fields = vec![("v", STD_LOGIC_VECTOR); 10_000];
        let of = ghw.record("open", &fields);
        let bounds = [25, 0, 0].repeat(10_000);
        (0..200).fold(of, |_, _| ghw.of_type(38, "", &[&number(of), &bounds]))
    };
    refused(&copied, "at most 1048576 types and fields");
}
