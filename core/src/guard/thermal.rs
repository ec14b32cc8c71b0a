//! The thermal budget: predicted temperature of the skin under each wire, from above over the whole parameter range.
//!
//! The heat of a pulse is felt at a depth as a sum of decays whose coefficients are the wire's [`Kernel`]: nowhere
//! below the response of the full model at any corner of the range, at that time or later. The prediction at the end
//! of a burst is therefore also the most that can come after it. A wire's memory is one number per decay, the bins of
//! its 10 s mean, and its dose.
//!
//! Heat is booked no earlier than the chip can deliver it: a response that falls with time makes the later
//! booking the hotter one. That allows for every oscillator, the bus, and the place of a pulse in its period.

use alloc::boxed::Box;
use alloc::vec;

use crate::schedule::Reason;
use crate::units::{Duration, Instant};

use super::decays::{Decays, RATES, Stretch, Stretches, Sums, dot};
use super::dose::{Dose, Doses};
use super::kernel::{Kernel, REST_C};
use super::limits::Limits;
use super::rest::Rest;
use super::table::{DECAYS, LATENT_K};
use super::used::Used;

/// Window of the mean.
const WINDOW: Duration = Duration::from_millis(10_000);
/// Length of a bin of the mean, microseconds.
pub(super) const BIN_US: u64 = 250_000;
/// Bins kept: a window of which both ends lie within bins.
pub(super) const BINS: usize = (WINDOW.as_micros() / BIN_US) as usize + 1;
/// Bins after the end of a burst at which the mean is looked at; between two of them it is taken to have the
/// heat of the later and the past of the earlier one.
const AHEAD: [u64; LOOKS] = [1, 2, 4, 8, 14, 20, 30, 40];
/// Number of looks ahead.
const LOOKS: usize = 8;

/// The thermal rows: all of the guard that needs floating point.
#[derive(Clone, Debug)]
pub(super) struct Heat {
    pub(super) budget: Budget,
    /// Tissue under each wire.
    pub(super) tissues: Box<[Tissue]>,
    pub(super) predicted: Predicted,
    /// Temperature of the tissue without a wire's heat.
    pub(super) rest: Rest,
}

impl Heat {
    pub(super) fn new(limits: &Limits, kernel: Kernel, wires: usize) -> Self {
        let rest_c = kernel.rest_c;
        Self {
            budget: Budget::new(limits, kernel),
            tissues: vec![Tissue::new(rest_c); wires].into(),
            predicted: Predicted::rest(rest_c),
            rest: Rest::default(),
        }
    }
}

/// The limits of the budget, as temperatures above rest of skin without latent heat, and the sums that look ahead.
#[derive(Clone, Debug)]
pub(super) struct Budget {
    /// The effect of a joule, and the tissue without it.
    pub(super) kernel: Kernel,
    pub(super) peak_k: f64,
    mean_k: f64,
    deep_k: f64,
    dose: Doses,
    /// Dose left beyond which the dose allows more than the peak does.
    ample: Doses,
    felt: Sums<{ 2 + LOOKS }>,
    pub(super) stretches: Stretches,
    response: Response,
}

/// Temperatures that decaying energies make in the skin.
#[derive(Clone, Copy, Debug)]
struct Felt {
    /// Temperature above rest at 0.1 mm and at 0.4 mm, K.
    shallow: f64,
    deep: f64,
    /// Time integral of the shallow one from now until each of [`AHEAD`], K s.
    ahead: [f64; LOOKS],
}

/// The guard's knowledge of the skin under one wire.
#[derive(Clone, Debug)]
pub(super) struct Tissue {
    /// Time until which everything is booked, counted from the first run of the session.
    pub(super) at: Instant,
    /// Start of this run in that time.
    pub(super) begun: Duration,
    /// Energy that each decay still feels, J.
    pub(super) energy: Decays,
    /// Time integral of the temperature above rest at 0.1 mm, K s, by bin of absolute time, the last one first.
    pub(super) bins: [f64; BINS],
    pub(super) dose: Dose,
    /// Upper bound of the skin's temperature before the next heat, degrees C, whatever the energies tell: those of a
    /// reserve lie above all that can have been.
    pub(super) most_c: f64,
    /// The excess over skin at rest without the wire's heat, K; never less than zero.
    pub(super) face_k: f64,
    /// Excess with the face's wanted temperature counted in, K: bursts to come make room for it.
    pub(super) rest_k: f64,
}

/// A burst as the budget books it: uniform between two times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Booking {
    /// The earliest start.
    pub(super) from: Instant,
    /// The end of all of it.
    pub(super) until: Instant,
}

/// Temperatures and doses predicted from above: the most of all so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Skin 0.1 mm deep at any time, degrees C.
    pub peak_c: f64,
    /// Skin 0.1 mm deep as a mean over 10 s, degrees C.
    pub mean_c: f64,
    /// Skin 0.4 mm deep at any time, degrees C.
    pub deep_c: f64,
    /// Henriques' Omega.
    pub omega: f64,
    /// Cumulative equivalent minutes at 43 C.
    pub cem43_min: f64,
}

impl Predicted {
    /// Skin at rest at 33 C, without any dose.
    pub(super) const REST: Self = Self::rest(REST_C);

    /// Skin at rest at some temperature, degrees C, without any dose.
    pub(super) const fn rest(rest_c: f64) -> Self {
        Self {
            peak_c: rest_c,
            mean_c: rest_c,
            deep_c: rest_c,
            omega: 0.0,
            cem43_min: 0.0,
        }
    }

    /// Takes over each figure that is higher.
    pub(super) fn raise(&mut self, other: &Self) {
        self.peak_c = self.peak_c.max(other.peak_c);
        self.mean_c = self.mean_c.max(other.mean_c);
        self.deep_c = self.deep_c.max(other.deep_c);
        self.omega = self.omega.max(other.omega);
        self.cem43_min = self.cem43_min.max(other.cem43_min);
    }
}

/// The effect of a joule spread over a burst, in the shapes that [`Tissue::room`] asks for.
#[derive(Clone, Copy, Debug)]
struct Response {
    stretch: Stretch,
    /// Temperatures at the end of the burst.
    felt: Felt,
    /// Time integral at 0.1 mm from its start until each of [`AHEAD`], K s/J.
    integrals: [f64; LOOKS],
}

impl Response {
    fn new(stretch: &Stretch, (kernel, sums): (&Kernel, &Sums<{ 2 + LOOKS }>)) -> Self {
        let burst = stretch.integral(&kernel.shallow, &Decays::default(), 1.0);
        let felt = Felt::new(sums, &stretch.kept);
        Self {
            stretch: *stretch,
            integrals: felt.ahead.map(|ahead| burst + ahead),
            felt,
        }
    }
}

impl Felt {
    fn new(sums: &Sums<{ 2 + LOOKS }>, energy: &Decays) -> Self {
        let [shallow, deep, ahead @ ..] = sums.evaluate(energy);
        Self {
            shallow,
            deep,
            ahead,
        }
    }
}

impl Budget {
    pub(super) fn new(limits: &Limits, kernel: Kernel) -> Self {
        let kelvin = |mc: u64, latent: f64| mc as f64 * 1e-3 - kernel.rest_c - latent;
        let integral = |bins: u64| {
            let seconds = (bins * BIN_US) as f64 * 1e-6;
            core::array::from_fn(|k| {
                kernel.shallow[k] / RATES[k] * (1.0 - libm::exp(-RATES[k] * seconds))
            })
        };
        let mut rows = [kernel.shallow; 2 + LOOKS];
        rows[1] = kernel.deep;
        for (row, bins) in rows[2..].iter_mut().zip(AHEAD) {
            *row = integral(bins);
        }
        let (mut stretches, felt) = (Stretches::new(), Sums::new(rows));
        Self {
            peak_k: kelvin(limits.skin_peak_mc, LATENT_K[0]),
            mean_k: kelvin(limits.skin_mean_mc, LATENT_K[1]),
            deep_k: kelvin(limits.skin_deep_mc, LATENT_K[2]),
            dose: Doses {
                omega: limits.dose_omega_ppm as f64 * 1e-6,
                cem43_min: limits.dose_cem43_ms as f64 / 60_000.0,
            },
            ample: Doses::ample(limits.skin_peak_mc),
            response: Response::new(stretches.stretch(Duration::ZERO), (&kernel, &felt)),
            kernel,
            felt,
            stretches,
        }
    }

    /// Most dose of a session.
    pub(super) const fn doses(&self) -> Doses {
        self.dose
    }

    /// The power, W, that may flow evenly where a watt warms tissue by `shallow` K at 0.1 mm and `deep` K at 0.4 mm.
    pub(super) fn even_w(&self, shallow: f64, deep: f64) -> f64 {
        (self.mean_k / shallow).min(self.deep_k / deep)
    }
}

impl Tissue {
    /// Skin at rest, degrees C, at the start of the run.
    pub(super) fn new(rest_c: f64) -> Self {
        Self {
            at: Instant::ZERO,
            begun: Duration::ZERO,
            energy: [0.0; DECAYS],
            bins: [0.0; BINS],
            dose: Dose::new(rest_c + LATENT_K[0]),
            most_c: f64::INFINITY,
            face_k: 0.0,
            rest_k: 0.0,
        }
    }

    /// Booking of a burst that is on between two times: after all that is booked, and as late as `latency` allows it
    /// to come.
    pub(super) fn booking(&self, on: Instant, off: Instant, latency: Duration) -> Booking {
        let from = self.at.max(on + self.begun + latency);
        let least = from + Duration::from_micros(1);
        Booking {
            from,
            until: least.max(off + self.begun + latency),
        }
    }

    /// Electrical energy, J, that a booking may bring until a limit is met, and that limit; at most zero if one is
    /// met already.
    pub(super) fn room(&mut self, budget: &mut Budget, booking: Booking) -> (f64, Reason) {
        self.relax((&budget.kernel, &mut budget.stretches), booking.from);
        let span = booking.until.since(booking.from);
        if budget.response.stretch.span != span {
            let sums = (&budget.kernel, &budget.felt);
            budget.response = Response::new(budget.stretches.stretch(span), sums);
        }
        let [first, others @ ..] = self.rooms(budget, &budget.response, booking);
        let least = |least: (f64, Reason), row: (f64, Reason)| {
            if row.0 < least.0 { row } else { least }
        };
        others.into_iter().fold(first, least)
    }

    /// Energy that each limit leaves; the tissue stays unchanged.
    pub(super) fn each_room(&self, budget: &Budget, booking: Booking) -> [(f64, Reason); 4] {
        let (mut tissue, mut stretches) = (self.clone(), budget.stretches);
        tissue.relax((&budget.kernel, &mut stretches), booking.from);
        let span = booking.until.since(booking.from);
        if budget.response.stretch.span == span {
            return tissue.rooms(budget, &budget.response, booking);
        }
        let response = Response::new(stretches.stretch(span), (&budget.kernel, &budget.felt));
        tissue.rooms(budget, &response, booking)
    }

    /// Energy that each limit leaves, J; infinity for the dose where it leaves more than the peak allows to spend.
    fn rooms(&self, budget: &Budget, each: &Response, booking: Booking) -> [(f64, Reason); 4] {
        let old = Felt::new(&budget.felt, &each.stretch.end(&self.energy, 0.0));
        let rest_k = self.rest_k;
        let peak = (budget.peak_k - rest_k - old.shallow) / each.felt.shallow;
        let mut dose = f64::INFINITY;
        if !self.dose.leaves(&budget.dose, &budget.ample) {
            let rest_c = budget.kernel.rest_c;
            let ceiling_k = self.dose.ceiling_c(&budget.dose) - rest_c - LATENT_K[0] - rest_k;
            dose = (ceiling_k - old.shallow) / each.felt.shallow;
        }
        let deep = (budget.deep_k - rest_k - old.deep) / each.felt.deep;
        let window_s = WINDOW.as_secs_f64();
        let so_far = each
            .stretch
            .integral(&budget.kernel.shallow, &self.energy, 0.0);
        let pasts = self.pasts(booking.until);
        let mut mean = f64::INFINITY;
        for ((past, ahead), more) in pasts.iter().zip(&old.ahead).zip(&each.integrals) {
            let spent = past + so_far + ahead;
            mean = mean.min(((budget.mean_k - rest_k) * window_s - spent) / more);
        }
        [
            (peak, Reason::SkinPeak),
            (dose, Reason::Dose),
            (deep, Reason::SkinDeep),
            (mean, Reason::SkinMean),
        ]
    }

    /// Books energy, J, and returns the most that is predicted from now on if nothing more comes.
    pub(super) fn heat(&mut self, budget: &mut Budget, booking: Booking, joules: f64) -> Predicted {
        self.relax((&budget.kernel, &mut budget.stretches), booking.from);
        let all = booking.until.since(booking.from).as_secs_f64();
        while self.at < booking.until {
            let until = booking.until.min(self.bin_end());
            let part = until.since(self.at).as_secs_f64() / all;
            let known = (&budget.kernel, &mut budget.stretches);
            self.step(known, until, joules * part);
        }
        self.to_come(budget)
    }

    /// Predicts temperatures and doses from what is booked, if nothing more comes.
    fn to_come(&self, budget: &Budget) -> Predicted {
        let felt = Felt::new(&budget.felt, &self.energy);
        let means = self.pasts(self.at).into_iter().zip(felt.ahead);
        let most = means.map(|(past, ahead)| past + ahead);
        let mean_k = most.fold(0.0, f64::max) / WINDOW.as_secs_f64();
        let rest_c = budget.kernel.rest_c + self.face_k;
        Predicted {
            peak_c: rest_c + LATENT_K[0] + felt.shallow,
            mean_c: rest_c + LATENT_K[1] + mean_k,
            deep_c: rest_c + LATENT_K[2] + felt.deep,
            omega: self.dose.omega,
            cem43_min: self.dose.cem43_min,
        }
    }

    /// Predicts temperatures and doses at `now` with a face `face_k` kelvin above skin at rest. The second figure is
    /// the warmest that the face may be, K above skin at rest, for what is booked to keep to the limits.
    pub(super) fn bears(&self, budget: &Budget, now: Instant, face_k: f64) -> (Predicted, f64) {
        let (mut tissue, mut stretches) = (self.clone(), budget.stretches);
        tissue.relax((&budget.kernel, &mut stretches), now + self.begun);
        tissue.face_k = face_k;
        let predicted = tissue.to_come(budget);
        let rest_c = budget.kernel.rest_c;
        let above = |c: f64, latent_k: f64| c - rest_c - latent_k - face_k;
        let left = (budget.peak_k - above(predicted.peak_c, LATENT_K[0]))
            .min(budget.deep_k - above(predicted.deep_c, LATENT_K[2]))
            .min(budget.mean_k - above(predicted.mean_c, LATENT_K[1]));
        (predicted, left)
    }

    /// Raises the rows of heat to their shares here at `now`, or at the end of the bookings if that is later.
    pub(super) fn add_used(&self, budget: &Budget, now: Instant, used: &mut Used) {
        let (mut tissue, mut stretches) = (self.clone(), budget.stretches);
        tissue.relax((&budget.kernel, &mut stretches), now + self.begun);
        let rest_k = self.face_k;
        let mean_k = rest_k + tissue.pasts(tissue.at)[0] / WINDOW.as_secs_f64();
        let raise = |row: &mut f64, part: f64, limit: f64| *row = row.max(part / limit);
        raise(&mut used.skin_mean, mean_k, budget.mean_k);
        let [shallow_k, deep_k] =
            [&budget.kernel.shallow, &budget.kernel.deep].map(|row| dot(row, &tissue.energy));
        raise(&mut used.skin_peak, rest_k + shallow_k, budget.peak_k);
        raise(&mut used.skin_deep, rest_k + deep_k, budget.deep_k);
        raise(&mut used.omega, tissue.dose.omega, budget.dose.omega);
        raise(
            &mut used.cem43,
            tissue.dose.cem43_min,
            budget.dose.cem43_min,
        );
    }

    /// Lets time pass until `to` without heat. Before the last window nothing but energy and dose matters, so the
    /// steps grow there. The bins of that time are shifted out, as many as are kept.
    pub(super) fn relax(&mut self, (kernel, stretches): (&Kernel, &mut Stretches), to: Instant) {
        let recent = to - WINDOW - Duration::from_micros(BIN_US);
        let mut stride = BIN_US;
        while self.at < recent {
            let until = recent.min(self.at + Duration::from_micros(stride));
            let stretch = Stretch::new(until.since(self.at));
            self.pass((kernel, &stretch), until, 0.0);
            stride = stride.saturating_mul(2);
        }
        while self.at < to {
            self.step((kernel, stretches), to.min(self.bin_end()), 0.0);
        }
    }

    /// Books `joules` over a stretch within one bin.
    fn step(
        &mut self,
        (kernel, stretches): (&Kernel, &mut Stretches),
        until: Instant,
        joules: f64,
    ) {
        let stretch = stretches.stretch(until.since(self.at));
        if self.at.as_micros().is_multiple_of(BIN_US) {
            self.bins.copy_within(..BINS - 1, 1);
            self.bins[0] = 0.0;
        }
        self.bins[0] += stretch.integral(&kernel.shallow, &self.energy, joules);
        self.pass((kernel, stretch), until, joules);
    }

    fn pass(&mut self, (kernel, stretch): (&Kernel, &Stretch), until: Instant, joules: f64) {
        self.energy = stretch.end(&self.energy, joules);
        self.at = until;
        if joules > 0.0 {
            self.most_c = f64::INFINITY;
            self.dose.heat(self.shallow_c(kernel), stretch.seconds);
        } else {
            self.dose.relax(self.shallow_c(kernel), stretch.seconds);
        }
    }

    /// Temperature of skin 0.1 mm deep, degrees C, at the end of the bookings.
    pub(super) fn shallow_c(&self, kernel: &Kernel) -> f64 {
        let warmth_k = dot(&kernel.shallow, &self.energy);
        let shallow_c = kernel.rest_c + self.face_k + LATENT_K[0] + warmth_k;
        shallow_c.min(self.most_c)
    }

    /// End of the bin that `at` lies in.
    fn bin_end(&self) -> Instant {
        Instant::from_micros((self.at.as_micros() / BIN_US + 1).saturating_mul(BIN_US))
    }

    /// The bins' part of each window that ends between `until` and the first of [`AHEAD`], between the first and the
    /// second, and so on, K s. Later windows hold fewer bins; each starts where the one before does.
    fn pasts(&self, until: Instant) -> [f64; LOOKS] {
        let mut sums = [0.0; BINS + 1];
        for (n, bin) in self.bins.iter().enumerate() {
            sums[n + 1] = sums[n] + bin;
        }
        let next = self.at.as_micros().div_ceil(BIN_US);
        core::array::from_fn(|n| {
            let ahead = if n == 0 { 0 } else { AHEAD[n - 1] };
            let end = until + Duration::from_micros(ahead * BIN_US);
            let first = (end - WINDOW).as_micros() / BIN_US;
            sums[(next.saturating_sub(first) as usize).min(BINS)]
        })
    }
}
