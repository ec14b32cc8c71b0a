//! Tests of `layout.rs`.

use proptest::prelude::*;

use super::*;

prop_compose! {
    fn kept()(
        place in prop::array::uniform3(any::<u8>()),
        times in prop::array::uniform5(0u64..1 << 60),
        energy_j in prop::collection::vec(0.0f64..1e6, 14),
        bins_ks in prop::collection::vec(0.0f64..1e6, 41),
        figures in prop::array::uniform3(0.0f64..1e3),
        most_c in prop::option::of(0.0f64..1e3),
        spent in prop::array::uniform3(any::<u64>()),
    ) -> Kept {
        let [bus, board, channel] = place;
        let [us, now, before, ago, boot] = times;
        let spent_of = |pj| Spent { pj, ago: Duration::from_micros(ago) };
        Kept {
            output: Output { bus, board, channel },
            uptime: Uptime { boot, us },
            wire: WireMemory {
                now: Instant::from_micros(now),
                at: Instant::from_micros(now.min(before)),
                energy_j: energy_j.try_into().unwrap(),
                bins_ks: bins_ks.try_into().unwrap(),
                doses: Doses { omega: figures[0], cem43_min: figures[1] },
                most_c,
                power: spent_of(spent[0]),
            },
            tip: spent_of(spent[1]),
            face_k: figures[2],
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_written_is_what_is_read(all in prop::collection::vec(kept(), 0..9)) {
        let bytes = of_wires(&all);
        prop_assert_eq!(bytes.len(), 8 * WORDS * all.len());
        prop_assert_eq!(wires(&bytes), Some(all));
        prop_assert!(bytes.is_empty() || wires(&bytes[1..]).is_none());
        prop_assert!(bytes.is_empty() || wires(&bytes[8..]).is_none());
    }

    #[test]
    fn hostile_bytes_are_none_or_a_memory(bytes in prop::collection::vec(any::<u8>(), 0..1200)) {
        for kept in wires(&bytes).into_iter().flatten() {
            prop_assert_eq!(kept.wire.check(), Ok(()));
        }
        if let Some(Doses { omega, cem43_min }) = doses(&bytes) {
            prop_assert!(omega >= 0.0 && cem43_min >= 0.0);
        }
    }
}

#[test]
fn figures_that_are_none_are_refused() {
    let good = Kept {
        output: Output {
            bus: 1,
            board: 0x40,
            channel: 15,
        },
        uptime: Uptime { boot: 1, us: 2 },
        wire: WireMemory::default(),
        tip: Spent::default(),
        face_k: 0.0,
    };
    let bytes = of_wires(std::slice::from_ref(&good));
    assert_eq!(wires(&bytes), Some(vec![good]));
    let with = |word: usize, value: u64| {
        let mut bytes = bytes.clone();
        bytes[8 * word..8 * word + 8].copy_from_slice(&value.to_le_bytes());
        wires(&bytes)
    };
    for hostile in [f64::NAN, f64::INFINITY, -1.0, 1e7] {
        // Energies, bins, doses and the face.
        for word in 5..63 {
            assert_eq!(with(word, hostile.to_bits()), None, "{word} {hostile}");
        }
        assert_eq!(with(63, hostile.to_bits()), None, "{hostile}");
        let bytes = bytes_of(&[0.0, hostile]);
        assert_eq!(doses(&bytes), None);
        assert_eq!(doses(&bytes_of(&[hostile, 0.0])), None);
    }
    assert_eq!(with(0, 1 << 24), None, "no such place");
    assert!(with(0, (1 << 24) - 1).is_some());
    let both = Doses {
        omega: 0.5,
        cem43_min: 1.5,
    };
    assert_eq!(doses(&of_doses(&both)), Some(both));
    assert_eq!(doses(&bytes_of(&[0.0; 3])), None);
}

fn bytes_of(figures: &[f64]) -> Vec<u8> {
    bytes(figures.iter().map(|figure| figure.to_bits()))
}
