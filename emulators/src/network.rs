//! A network between a host and a driver unit: delay, jitter, loss in bursts, duplicates, reordering, outages.
//!
//! Each datagram takes a time of its own, so that jitter reorders. Losses come in runs, by two states (Gilbert 1960).

use palpate_core::random::RandomStream;

use crate::time::Nanos;

/// Parts of a million.
const MILLION: f64 = 1e6;

/// Delays, losses and duplicates of a network, the same both ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// One-way times, microseconds: the least, then those that 50, 95 and 99 of 100 do not exceed, and the most.
    /// Between them the share grows straight.
    pub delay_us: [u32; 5],
    /// Datagrams lost, parts per million.
    pub loss_ppm: u32,
    /// Mean length of a run of losses, in datagrams, 1 or more.
    pub burst: f64,
    /// Datagrams that come twice, parts per million.
    pub twice_ppm: u32,
}

impl Profile {
    /// A cable and a quiet switch: 0.1 to 0.5 ms, nothing lost. Assumed.
    pub const WIRE: Self = Self {
        delay_us: [100, 200, 300, 400, 500],
        loss_ppm: 0,
        burst: 1.0,
        twice_ppm: 0,
    };

    /// A Wi-Fi microcontroller near its access point: round trips of a u-blox NORA-W radio, 512 bytes at 100 Hz for 30
    /// minutes, of 6.474, 7.195, 8.236, 9.738 and 116.316 ms (least, p50, p95, p99, most), 1.41 % lost, at most 4 in a row.
    /// Measured by the SSL A-Team (github.com/SSL-A-Team/firmware, wiki, `nora1.pdf`, 2026). A way is half of a round trip;
    /// the mean run of losses and the duplicates are assumed.
    pub const WIFI: Self = Self {
        delay_us: [3237, 3598, 4118, 4869, 58_158],
        loss_ppm: 14_100,
        burst: 1.5,
        twice_ppm: 1000,
    };

    /// A Wi-Fi microcontroller with a worse radio in worse air: u-blox ODIN-W2, 4.225, 5.676, 15.577, 108.909 and
    /// 1835.662 ms, 1.86 % lost, up to 86 in a row (the same source, `odin1.pdf`).
    pub const ROUGH: Self = Self {
        delay_us: [2112, 2838, 7788, 54_454, 917_831],
        loss_ppm: 18_600,
        burst: 8.0,
        twice_ppm: 1000,
    };

    /// The time that a share of all datagrams does not exceed.
    fn delay(&self, share: f64) -> Nanos {
        const SHARES: [f64; 5] = [0.0, 0.5, 0.95, 0.99, 1.0];
        let over = SHARES.iter().skip(1).position(|s| share < *s);
        let below = over.unwrap_or(SHARES.len() - 2);
        let [from, to] = [self.delay_us[below], self.delay_us[below + 1]].map(f64::from);
        let part = (share - SHARES[below]) / (SHARES[below + 1] - SHARES[below]);
        Nanos(((from + (to - from) * part) * 1e3) as u64)
    }
}

/// A datagram on its way.
#[derive(Clone, Debug)]
struct Flying {
    lands: Nanos,
    bytes: Vec<u8>,
}

/// One direction of a network.
#[derive(Clone, Debug)]
pub struct Way {
    profile: Profile,
    stream: RandomStream,
    losing: bool,
    cut: bool,
    flying: Vec<Flying>,
    lost: u64,
}

impl Way {
    /// A direction with dice of its own.
    pub fn new(profile: Profile, seed: u64, name: &str) -> Self {
        Self {
            profile,
            stream: RandomStream::new(seed, name),
            losing: false,
            cut: false,
            flying: Vec::new(),
            lost: 0,
        }
    }

    /// Changes what the network does to datagrams to come.
    pub const fn set_profile(&mut self, profile: Profile) {
        self.profile = profile;
    }

    /// Cuts the way, or opens it again. Datagrams on their way still land.
    pub const fn set_cut(&mut self, cut: bool) {
        self.cut = cut;
    }

    /// Datagrams lost so far.
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Sends a datagram off at `now`.
    pub fn send(&mut self, now: Nanos, datagram: &[u8]) {
        // Every datagram throws the same dice, so that an outage leaves those after it alone.
        let [fate, time, again, second] = [(); 4].map(|()| self.stream.uniform());
        let loss = f64::from(self.profile.loss_ppm) / MILLION;
        // In the losing state all is lost: it is left after a mean run, and entered as often as the share of losses asks.
        let leave = 1.0 / self.profile.burst.max(1.0);
        let enter = leave * loss / (1.0 - loss).max(f64::EPSILON);
        self.losing = match self.losing {
            true => fate >= leave,
            false => fate < enter,
        };
        if self.cut || self.losing {
            self.lost += 1;
            return;
        }
        let twice = again * MILLION < f64::from(self.profile.twice_ppm);
        for share in [Some(time), twice.then_some(second)].into_iter().flatten() {
            self.flying.push(Flying {
                lands: now + self.profile.delay(share),
                bytes: datagram.to_vec(),
            });
        }
    }

    /// Time at which the next datagram lands.
    pub fn next(&self) -> Option<Nanos> {
        self.flying.iter().map(|f| f.lands).min()
    }

    /// A datagram that has landed by `now`, the earliest first.
    pub fn land(&mut self, now: Nanos) -> Option<Vec<u8>> {
        let each = self.flying.iter().enumerate();
        let landed = each.filter(|(_, f)| f.lands <= now);
        // Of two at one time that which was sent first lands first.
        let (first, _) = landed.min_by_key(|(index, f)| (f.lands, *index))?;
        Some(self.flying.remove(first).bytes)
    }
}

#[cfg(test)]
#[path = "network_tests.rs"]
mod tests;
