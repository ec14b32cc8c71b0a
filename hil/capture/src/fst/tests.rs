//! Dumps beside the same waveforms as VCD, and dumps that are damaged.

use std::fmt::Write;
use std::io::Cursor;

use fst_writer::{
    FstBodyWriter, FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalId, FstSignalType,
    FstVarDirection, FstVarType,
};

use super::super::draws::{Draws, mutate};
use super::super::dump;
use super::*;

const KINDS: [(&str, FstVarType); 4] = [
    ("wire", FstVarType::Wire),
    ("reg", FstVarType::Reg),
    ("logic", FstVarType::Logic),
    ("bit", FstVarType::Bit),
];

/// Two dumps of one waveform as they grow.
struct Both {
    fst: FstBodyWriter<Cursor<Vec<u8>>>,
    vcd: String,
    bits: Vec<(FstSignalId, String)>,
    wide: [FstSignalId; 2],
}

impl Both {
    /// Declares signals of one bit, some of them under two names, a bus and a real, in scopes.
    fn begin(draw: &mut Draws) -> Self {
        let (exponent, scale) =
            [(-9, "1 ns"), (-8, "10 ns"), (-12, "1 ps"), (-6, "1us")][draw.below(4)];
        let info = FstInfo {
            start_time: 0,
            timescale_exponent: exponent,
            version: "test".into(),
            date: "today".into(),
            file_type: FstFileType::Verilog,
        };
        let mut fst = FstHeaderWriter::write_to_mem(&info).unwrap();
        let mut vcd = format!("$timescale {scale} $end\n");
        let (bit, bus, real) = (
            FstSignalType::bit_vec(1),
            FstSignalType::bit_vec(9),
            FstSignalType::real(),
        );
        let way = FstVarDirection::Implicit;
        let mut bits: Vec<(FstSignalId, String)> = Vec::new();
        for scope in 0..=draw.below(3) {
            fst.scope(format!("s{scope}"), "", FstScopeType::Module)
                .unwrap();
            writeln!(vcd, "$scope module s{scope} $end").unwrap();
            for _ in 0..=draw.below(3) {
                let (kind, of_fst) = KINDS[draw.below(4)];
                let name = [
                    format!("pin{}", bits.len()),
                    format!("pwm [{}]", bits.len()),
                ];
                let name = &name[draw.below(2)];
                let alias = (draw.below(3) == 0).then(|| draw.below(bits.len()));
                let other = alias.and_then(|n| bits.get(n)).cloned();
                let id = fst
                    .var(name, bit, of_fst, way, other.as_ref().map(|o| o.0))
                    .unwrap();
                let code = other
                    .as_ref()
                    .map_or(format!("c{}", bits.len()), |o| o.1.clone());
                writeln!(vcd, "$var {kind} 1 {code} {name} $end").unwrap();
                if other.is_none() {
                    bits.push((id, code));
                }
            }
        }
        let wide = [
            ("bus [8:0]", bus, FstVarType::Wire),
            ("t", real, FstVarType::Real),
        ];
        let wide = wide.map(|(name, of, kind)| fst.var(name, of, kind, way, None).unwrap());
        vcd += "$var wire 9 b bus [8:0] $end\n$var real 64 r t $end\n";
        while vcd.matches("$upscope").count() < vcd.matches("$scope").count() {
            fst.up_scope().unwrap();
            vcd += "$upscope $end\n";
        }
        vcd += "$enddefinitions $end\n";
        Self {
            fst: fst.finish().unwrap(),
            vcd,
            bits,
            wide,
        }
    }

    fn at(&mut self, time: u64) {
        self.fst.time_change(time).unwrap();
        writeln!(self.vcd, "#{time}").unwrap();
    }

    fn bit(&mut self, n: usize, value: u8) {
        let (id, code) = &self.bits[n];
        self.fst.signal_change(*id, &[value]).unwrap();
        writeln!(self.vcd, "{}{code}", char::from(value)).unwrap();
    }
}

/// A waveform as FST and VCD.
fn waveform(draw: &mut Draws) -> (Vec<u8>, String) {
    let mut both = Both::begin(draw);
    both.at(0);
    for n in 0..both.bits.len() {
        both.bit(n, draw.one(b"0011xz"));
    }
    let [bus, real] = both.wide;
    let mut now = 0;
    let steps = draw.below(300);
    for _ in 0..steps {
        if now > 0 && draw.below(50) == 0 {
            both.fst.flush().unwrap();
        }
        now += 1 + draw.below(2000) as u64;
        both.at(now);
        for n in 0..both.bits.len() {
            if draw.below(3) == 0 {
                both.bit(n, draw.one(b"00001111xzhl"));
            }
        }
        both.fst.signal_change(bus, &[draw.one(b"01x"); 9]).unwrap();
        both.fst
            .signal_change(real, &(now as f64).to_le_bytes())
            .unwrap();
        both.vcd += "b1 b\nr1.5 r\n";
    }
    both.at(now + 10);
    (both.fst.finish().unwrap().into_inner(), both.vcd)
}

#[test]
fn a_dump_reads_like_the_same_waveform_as_vcd() {
    let mut draw = Draws(0x9E37_79B9_7F4A_7C15);
    let (mut edges, mut unseen) = (0, 0);
    for _ in 0..300 {
        let (fst, vcd) = waveform(&mut draw);
        let found = read("a.fst", Cursor::new(fst)).unwrap();
        assert_eq!(found, dump::read("a.vcd", vcd.as_bytes()).unwrap(), "{vcd}");
        edges += found.signals.iter().map(|s| s.edges.len()).sum::<usize>();
        unseen += found.signals.iter().map(|s| s.unseen.len()).sum::<usize>();
    }
    assert!(
        edges > 10_000 && unseen > 1000,
        "{edges} edges, {unseen} unseen"
    );
}

/// A dump packed as a whole, in one gzip stream without compression.
fn packed(plain: &[u8]) -> Vec<u8> {
    let block = |(n, part): (usize, &[u8])| {
        let length = part.len() as u16;
        let is_last = u8::from((n + 1) * 0xffff >= plain.len());
        let head = [
            [is_last].as_slice(),
            &length.to_le_bytes(),
            &(!length).to_le_bytes(),
        ]
        .concat();
        [&head, part].concat()
    };
    let blocks: Vec<u8> = plain.chunks(0xffff).enumerate().flat_map(block).collect();
    let length = 16 + 10 + blocks.len() as u64;
    [
        &[PACKED][..],
        &length.to_be_bytes(),
        &(plain.len() as u64).to_be_bytes(),
        &[0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3],
        &blocks,
    ]
    .concat()
}

#[test]
fn a_dump_that_is_packed_as_a_whole_is_read() {
    let (plain, _) = waveform(&mut Draws(3));
    let whole = packed(&plain);
    let found = read("a.fst", Cursor::new(&whole)).unwrap();
    assert_eq!(found, read("a.fst", Cursor::new(plain)).unwrap());
    for length in 0..whole.len() {
        assert!(
            read("a.fst", Cursor::new(&whole[..length])).is_err(),
            "{length}"
        );
    }
    let mut long = whole;
    long[9] = 1;
    let error = read("a.fst", Cursor::new(&long)).unwrap_err().to_string();
    assert!(error.contains("at most 64 MiB"), "{error}");
}

#[test]
fn a_dump_that_is_cut_is_refused_wherever_it_is_cut() {
    let mut draw = Draws(77);
    let (whole, _) = waveform(&mut draw);
    assert!(read("a.fst", Cursor::new(&whole)).is_ok());
    for length in 0..whole.len() {
        let error = read("a.fst", Cursor::new(&whole[..length])).unwrap_err();
        assert!(
            error.to_string().contains("a damaged or unfinished dump"),
            "{length}: {error}"
        );
    }
}

#[test]
fn mutations_of_a_dump_are_read_or_refused() {
    mutate(
        5,
        |draw| waveform(draw).0,
        |bytes| {
            _ = dump::read("a.vcd", bytes);
            let found = read("a.fst", Cursor::new(bytes));
            found
                .map_err(|error| assert!(!error.found.is_empty()))
                .is_ok()
        },
    );
}

#[test]
fn matches_of_fast_lz_reach_back_and_into_themselves() {
    let unpack = |packed: &[u8], length| Packing::FastLz.unpack(packed, length);
    // three literals, then a match of five from three back
    let short = [2, b'a', b'b', b'c', 3 << 5, 2];
    assert_eq!(unpack(&short, 8).unwrap(), b"abcabcab");
    // level 2: one literal, then a match of 9 + 255 + 1 from one back
    let long = [0x20, b'a', 7 << 5, 0xff, 1, 0];
    assert_eq!(unpack(&long, 266).unwrap(), [b'a'; 266]);
    for wrong in [&short[..5], &[0, b'a', 3 << 5, 1], &[0x40, 0], &long[..5]] {
        assert_eq!(unpack(wrong, 8), None, "{wrong:?}");
    }
    assert_eq!(unpack(&short, 7), None);
}
