//! Phases that exclude one another against Dormand and Prince's fifth-order method, over the same pieces of the bow.
//!
//! Nothing of the solver's own lines is used: what turns next comes from the law as it is written, a billionth of a kelvin
//! further on, and both balances, of heat and of length, are solved as two equations at every stage. A step ends where
//! anything ends.

// Indices name nodes and shares, several arrays of them at once.
#![allow(clippy::needless_range_loop)]

use super::*;
use crate::display::finger::{NODES, ThermalNetwork};
use palpate_core::physics::{
    Bow, Curve, History, Mechanics, Mount, RPhase, SHARES, TissueParameters, WireParameters,
    WireState,
};

/// Nodes, shares, what they have expanded for, and the play of R.
const SIZE: usize = NODES + 2 * SHARES + 1;
const RHO: usize = SIZE - 1;
type State = [f64; SIZE];
/// How far ahead the law is asked what turns, K; and what may be past an end, K.
const AHEAD_K: f64 = 1e-9;
const PAST_K: f64 = 1e-11;

struct Plain<'a> {
    wire: &'a WireParameters,
    network: ThermalNetwork,
    curve: Curve,
    r: RPhase,
    /// Strain at which the bow is at rest.
    rest: f64,
}

/// What turns, until something ends.
#[derive(Clone, Debug)]
struct Mode {
    rises: bool,
    /// By share and for the play: whether it turns, and whether it shrinks.
    turns: [Option<bool>; SHARES + 1],
    by_play: [bool; SHARES],
    piece: usize,
}

impl Plain<'_> {
    /// Widths and ends of a play's bands, at no stress: heating finish and width, cooling start and width.
    fn band(&self, k: usize) -> [f64; 4] {
        if k == SHARES {
            let b = &self.r.bands;
            let warm = b.austenite_finish_c - b.austenite_start_c;
            let cold = b.martensite_start_c - b.martensite_finish_c;
            return [b.austenite_finish_c, warm, b.martensite_start_c, cold];
        }
        let b = self.wire.alloy.under(0.0);
        let warm = (b.austenite_finish_c - b.austenite_start_c) / SHARES as f64;
        let cold = (b.martensite_start_c - b.martensite_finish_c) / SHARES as f64;
        let place = (k + 1) as f64;
        [
            b.austenite_start_c + place * warm,
            warm,
            b.martensite_finish_c + place * cold,
            cold,
        ]
    }

    fn slope(&self, k: usize) -> f64 {
        if k == SHARES {
            self.r.bands.stress_per_kelvin
        } else {
            self.wire.alloy.stress_per_kelvin
        }
    }

    fn strain(&self, y: &State) -> f64 {
        let m = &self.wire.mechanics;
        let mut strain = m.expansion_austenite * (y[0] - m.rest_c) - self.rest;
        for k in 0..SHARES {
            let (share, x) = (y[NODES + k], y[NODES + SHARES + k]);
            let part = m.transformation_strain * share
                + (m.expansion_martensite - m.expansion_austenite) * x
                + self.r.strain * y[RHO].min(1.0 - share);
            strain += part / SHARES as f64;
        }
        strain
    }

    fn piece(&self, strain: f64) -> usize {
        let found = self.curve.pieces.iter().position(|p| strain <= p.high);
        found.unwrap()
    }

    fn stress(&self, piece: usize, strain: f64) -> f64 {
        self.wire.bias_stress_pa + self.curve.pieces[piece].stress_at(strain)
    }

    /// The state at another temperature close by, by the law: the strain is found by halving.
    fn near(&self, y: &State, t: f64) -> (State, f64) {
        let at = |strain: f64| {
            let mut next = *y;
            next[0] = t;
            let stress = self.stress(self.piece(strain), strain);
            for k in 0..=SHARES {
                let [hot, warm, cool, cold] = self.band(k);
                let theta = t - stress / self.slope(k);
                let place = if k == SHARES { RHO } else { NODES + k };
                let low = ((cool - theta) / cold).clamp(0.0, 1.0);
                let high = ((hot - theta) / warm).clamp(0.0, 1.0);
                next[place] = y[place].max(low).min(high);
                if k == SHARES {
                    continue;
                }
                let (m, x, new) = (y[NODES + k], y[NODES + SHARES + k], next[NODES + k]);
                let (before, after) = (
                    y[0] - self.wire.mechanics.rest_c,
                    t - self.wire.mechanics.rest_c,
                );
                next[NODES + SHARES + k] = if new < m {
                    x * new / m
                } else if new > m {
                    after - (before - x) * (1.0 - new) / (1.0 - m)
                } else {
                    x + m * (after - before)
                };
            }
            next
        };
        let here = self.strain(y);
        let (mut low, mut high) = (here - 1e-9, here + 1e-9);
        for _ in 0..80 {
            let middle = f64::midpoint(low, high);
            if self.strain(&at(middle)) > middle {
                low = middle
            } else {
                high = middle
            }
        }
        (at(low), low)
    }

    fn mode(&self, y: &State, watts: f64) -> Mode {
        let rises = self.heat(y, watts) > 0.0;
        let by = if rises { AHEAD_K } else { -AHEAD_K };
        let (next, strain) = self.near(y, y[0] + by);
        let mut mode = Mode {
            rises,
            turns: [None; SHARES + 1],
            by_play: [true; SHARES],
            piece: self.piece(strain),
        };
        for k in 0..=SHARES {
            let place = if k == SHARES { RHO } else { NODES + k };
            let change = next[place] - y[place];
            mode.turns[k] = (change.abs() > 1e-13).then_some(change < 0.0);
        }
        for k in 0..SHARES {
            mode.by_play[k] = next[RHO] < 1.0 - next[NODES + k];
        }
        mode
    }

    /// Heat that flows into the wire, W.
    fn heat(&self, y: &State, watts: f64) -> f64 {
        let nodes: [f64; NODES] = core::array::from_fn(|i| y[i]);
        self.network.rate(&nodes, watts, 1.0)[0]
    }

    /// Changes of the shares with changes of temperature and strain.
    fn follow(&self, y: &State, mode: &Mode, (dt, de): (f64, f64), out: &mut State) {
        let away = y[0] - self.wire.mechanics.rest_c;
        let stress = -self.curve.pieces[mode.piece].stiffness_pa * de;
        for k in 0..=SHARES {
            let [_, warm, _, cold] = self.band(k);
            let theta = dt - stress / self.slope(k);
            let change = match mode.turns[k] {
                None => 0.0,
                Some(true) => -theta / warm,
                Some(false) => -theta / cold,
            };
            if k == SHARES {
                out[RHO] = change;
                continue;
            }
            let (m, x) = (y[NODES + k], y[NODES + SHARES + k]);
            out[NODES + k] = change;
            out[NODES + SHARES + k] = match mode.turns[k] {
                None => m * dt,
                Some(true) => x / m * change,
                Some(false) => dt + (away - x) / (1.0 - m) * change,
            };
        }
    }

    /// What is left of both balances, of length and of heat.
    fn balances(&self, y: &State, mode: &Mode, (dt, de): (f64, f64)) -> [f64; 2] {
        let (mut change, m) = ([0.0; SIZE], &self.wire.mechanics);
        self.follow(y, mode, (dt, de), &mut change);
        let (mut whole_m, mut whole_r, mut x) = (0.0, 0.0, 0.0);
        for k in 0..SHARES {
            whole_m += change[NODES + k] / SHARES as f64;
            x += change[NODES + SHARES + k] / SHARES as f64;
            whole_r += match mode.by_play[k] {
                true => change[RHO],
                false => -change[NODES + k],
            } / SHARES as f64;
        }
        let w = self.wire;
        let length = m.expansion_austenite * dt
            + (m.expansion_martensite - m.expansion_austenite) * x
            + m.transformation_strain * whole_m
            + self.r.strain * whole_r
            - de;
        let heat = w.mass()
            * (w.specific_heat * dt - w.latent_heat * whole_m - self.r.latent_heat * whole_r);
        [length, heat]
    }

    fn rate(&self, y: &State, mode: &Mode, watts: f64) -> State {
        let nodes: [f64; NODES] = core::array::from_fn(|i| y[i]);
        let flow = self.network.rate(&nodes, watts, 1.0);
        let [a, c] = self.balances(y, mode, (1.0, 0.0));
        let [b, d] = self.balances(y, mode, (0.0, 1.0));
        let whole = a * d - b * c;
        let (dt, de) = (-b * flow[0] / whole, a * flow[0] / whole);
        let mut out = [0.0; SIZE];
        self.follow(y, mode, (dt, de), &mut out);
        out[1..NODES].copy_from_slice(&flow[1..]);
        out[0] = dt;
        out
    }

    /// One step of Dormand and Prince's method.
    fn step(&self, y: &State, mode: &Mode, watts: f64, h: f64) -> State {
        const A: [&[f64]; 6] = [
            &[],
            &[1.0 / 5.0],
            &[3.0 / 40.0, 9.0 / 40.0],
            &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
            &[
                19372.0 / 6561.0,
                -25360.0 / 2187.0,
                64448.0 / 6561.0,
                -212.0 / 729.0,
            ],
            &[
                9017.0 / 3168.0,
                -355.0 / 33.0,
                46732.0 / 5247.0,
                49.0 / 176.0,
                -5103.0 / 18656.0,
            ],
        ];
        const B: [f64; 6] = [
            35.0 / 384.0,
            0.0,
            500.0 / 1113.0,
            125.0 / 192.0,
            -2187.0 / 6784.0,
            11.0 / 84.0,
        ];
        let mut k = [[0.0; SIZE]; 6];
        for (stage, row) in A.iter().enumerate() {
            let mut at = *y;
            for (weight, rate) in row.iter().zip(&k) {
                for (value, rate) in at.iter_mut().zip(rate) {
                    *value += h * weight * rate;
                }
            }
            k[stage] = self.rate(&at, mode, watts);
        }
        let mut next = *y;
        for (weight, rate) in B.iter().zip(&k) {
            for (value, rate) in next.iter_mut().zip(rate) {
                *value += h * weight * rate;
            }
        }
        next
    }

    /// Whether something has ended since the mode began.
    fn ended(&self, y: &State, mode: &Mode, watts: f64) -> bool {
        let strain = self.strain(y);
        let piece = &self.curve.pieces[mode.piece];
        let stress = self.stress(mode.piece, strain);
        let mut ended = strain > piece.high + 1e-15 || strain < piece.low - 1e-15;
        for k in 0..=SHARES {
            let p = y[if k == SHARES { RHO } else { NODES + k }];
            let [hot, warm, cool, cold] = self.band(k);
            let theta = y[0] - stress / self.slope(k);
            ended |= match mode.turns[k] {
                Some(_) => p * warm < -PAST_K || (1.0 - p) * cold < -PAST_K,
                None => {
                    (p > 0.0 && theta > hot - p * warm + PAST_K)
                        || (p < 1.0 && theta < cool - p * cold - PAST_K)
                }
            };
            if k < SHARES {
                let over = y[RHO] - (1.0 - p);
                ended |= if mode.by_play[k] {
                    over > PAST_K
                } else {
                    over < -PAST_K
                };
            }
        }
        let turned = (self.heat(y, watts) > 0.0) != mode.rises;
        ended || (turned && mode.turns.iter().any(Option::is_some))
    }

    /// Goes on for `span` seconds; how often something ended.
    fn go(&self, y: &mut State, watts: f64, span: f64, longest: f64) -> u32 {
        let (mut left, mut ends) = (span, 0);
        let mut mode = self.mode(y, watts);
        while left > 0.0 {
            let h = left.min(longest);
            let next = self.step(y, &mode, watts, h);
            if !self.ended(&next, &mode, watts) {
                (*y, left) = (next, left - h);
                continue;
            }
            let (mut low, mut high) = (0.0, h);
            while high - low > h * 1e-14 {
                let middle = f64::midpoint(low, high);
                let there = self.step(y, &mode, watts, middle);
                if self.ended(&there, &mode, watts) {
                    high = middle
                } else {
                    low = middle
                }
            }
            *y = self.step(y, &mode, watts, high);
            for p in &mut y[NODES..NODES + SHARES] {
                *p = p.clamp(0.0, 1.0);
            }
            y[RHO] = y[RHO].clamp(0.0, 1.0);
            left -= high;
            ends += 1;
            mode = self.mode(y, watts);
        }
        ends
    }
}

/// Bursts on a wire by both; the largest distances in temperature, K, fractions, and stress, Pa, and how much ended.
fn compare(wire: &WireParameters, start_m: f64, pulse: (u64, f64)) -> ([f64; 3], u32) {
    let tissue = TissueParameters::DEFAULT;
    let bow = Bow::new(wire, &tissue).unwrap();
    let mut plain = Plain {
        wire,
        network: ThermalNetwork::new(wire, &tissue).unwrap(),
        curve: Curve::new(&bow, wire),
        r: wire.r_phase.unwrap(),
        rest: 0.0,
    };
    let mut y = [33.0; SIZE];
    y[NODES..].fill(0.0);
    y[NODES..NODES + SHARES].fill(start_m);
    y[RHO] = 1.0;
    plain.rest = plain.strain(&y);
    let mut exact = Wire::new(wire, &tissue, 33.0).unwrap();
    let (mut worst, mut ends) = ([0.0_f64; 3], 0);
    let mut now = Nanos::ZERO;
    let mut edges = vec![(Nanos(1_000_000), 0.0)];
    for burst in 0..5 {
        for second in 0..2 {
            let at = Nanos(1_000_000 + burst * 117_000_000 + second * 15_200_000);
            edges.extend([(at, pulse.1), (at + Nanos(pulse.0), 0.0)]);
        }
        edges.push((Nanos(117_900_000 + burst * 117_000_000), 0.0));
    }
    let mut watts = 0.0;
    for (at, next) in edges {
        let longest = if watts > 0.0 { 5e-6 } else { 25e-6 };
        ends += plain.go(&mut y, watts, at.since(now).as_secs_f64(), longest);
        exact.advance(at);
        for (a, b) in exact.solver().nodes().iter().zip(&y) {
            worst[0] = worst[0].max((a - b).abs());
        }
        let m = y[NODES..NODES + SHARES].iter().sum::<f64>() / SHARES as f64;
        worst[1] = worst[1].max((exact.fraction(at) - m).abs());
        let stress = plain.stress(plain.piece(plain.strain(&y)), plain.strain(&y));
        let modulus = wire.mechanics.modulus_martensite_pa;
        worst[2] = worst[2].max((exact.strain(at).elastic * modulus - stress).abs());
        exact.set_power(at, next);
        (watts, now) = (next, at);
    }
    (worst, ends)
}

#[test]
fn phases_in_a_bow_agree_with_another_method() {
    let wire = |state, sag_um: f64| WireParameters {
        length_m: 8e-3,
        wire_share: 1.0,
        reversible: 0.0,
        mount: Mount {
            sag_m: sag_um * 1e-6,
            ..Mount::DEFAULT
        },
        history: History {
            state,
            sag_state: state,
            coldest_c: None,
        },
        ..trained()
    };
    let strong = WireParameters {
        r_phase: Some(RPhase {
            strain: 9e-3,
            ..RPhase::LOW
        }),
        ..wire(WireState::Passed, 170.0)
    };
    let thin = WireParameters {
        diameter_m: 50e-6,
        air_h: 240.0,
        mechanics: Mechanics {
            transformation_strain: 0.002,
            ..Mechanics::DEFAULT
        },
        ..wire(WireState::Passed, 250.0)
    };
    for (name, wire, start_m, pulse) in [
        ("cold", wire(WireState::Cold, 170.0), 1.0, (120_000, 7.098)),
        ("passed and thin", thin, 0.0, (100_000, 5.926)),
        ("strong R phase", strong, 0.0, (120_000, 9.0)),
    ] {
        let ([kelvin, fraction, pascal], ends) = compare(&wire, start_m, pulse);
        println!("{name}: {kelvin:.2e} K, {fraction:.2e}, {pascal:.2e} Pa, {ends} ends");
        assert!(ends > 50, "{name}: {ends}");
        assert!(
            kelvin < 1e-9 && fraction < 1e-9,
            "{name}: {kelvin} {fraction}"
        );
        assert!(pascal < 1.0, "{name}: {pascal}");
    }
}
