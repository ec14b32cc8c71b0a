//! Tests of `limits.rs`.

use super::*;

#[test]
fn nothing_loosens() {
    let loose = Limits {
        pulse_width_ns: u64::MAX,
        burst: Duration::from_millis(51),
        burst_energy_nj: u64::MAX,
        wire_1s_uw: 45_001,
        wire_10s_uw: 20_001,
        fingertip_1s_uw: 110_001,
        fingertip_60s_uw: 60_001,
        hand_60s_uw: 600_001,
        skin_mean_mc: 41_001,
        skin_peak_mc: 43_001,
        skin_deep_mc: 41_001,
        dose_omega_ppm: 10_001,
        dose_cem43_ms: 120_001,
        stale: Duration::from_millis(101),
        supply: Milliamps(2500),
    };
    let hard = Limits {
        supply: Milliamps(2500),
        ..HARD
    };
    assert_eq!(loose.tightened(), hard);
}

#[test]
fn what_is_tighter_stays() {
    let tight = Limits {
        pulse_width_ns: 1,
        burst: Duration::from_micros(2),
        burst_energy_nj: 3,
        wire_1s_uw: 4,
        wire_10s_uw: 5,
        fingertip_1s_uw: 6,
        fingertip_60s_uw: 7,
        hand_60s_uw: 15,
        skin_mean_mc: 8,
        skin_peak_mc: 9,
        skin_deep_mc: 10,
        dose_omega_ppm: 11,
        dose_cem43_ms: 12,
        stale: Duration::from_micros(13),
        supply: Milliamps(14),
    };
    assert_eq!(tight.tightened(), tight);
}

#[test]
fn a_table_comes_back_from_its_rows() {
    let rows: [u64; 15] = core::array::from_fn(|row| row as u64 + 1);
    assert_eq!(Limits::from_rows(rows).rows(), rows);
    assert_eq!(Limits::from_rows(HARD.rows()), HARD);
    assert_eq!(Limits::from_rows([u64::MAX; 15]).supply, HARD.supply);
}

#[test]
fn fingertips_of_a_hand_share_its_power() {
    let share = |fingertips| HARD.of_hand(fingertips).fingertip_60s_uw;
    assert_eq!(
        [0, 1, 10, 11, 16].map(share),
        [60_000, 60_000, 60_000, 54_545, 37_500]
    );
    let others = Limits {
        fingertip_60s_uw: HARD.fingertip_60s_uw,
        ..HARD.of_hand(16)
    };
    assert_eq!(others, HARD);
}
