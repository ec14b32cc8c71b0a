//! Marginals against distributions that are known in closed form.

use super::*;

fn row(value: f64, tolerance: f64) -> EvidenceRow {
    EvidenceRow {
        quantity: "strain".to_owned(),
        value,
        unit: "%".to_owned(),
        tolerance: Some([tolerance; 2]),
        factor: None,
        bound: Bound::Near,
        times: 1,
        source: "test".to_owned(),
        drive: None,
    }
}

fn close(found: f64, expected: f64, by: f64) {
    assert!((found - expected).abs() < by, "{found} for {expected}");
}

#[test]
fn priors_alone_have_their_own_quantiles() {
    let quantiles = |prior| {
        let marginal = Marginal::new(prior, &[]).unwrap();
        [0.05, 0.5, 0.95].map(|u| marginal.value(u))
    };
    let [low, half, high] = quantiles(Prior::LogUniform(0.1, 10.0));
    close(half, 1.0, 1e-12);
    close(low * high, 1.0, 1e-12);
    let [low, half, high] = quantiles(Prior::Normal(30.5, 2.0));
    close(half, 30.5, 1e-9);
    close(high - low, 2.0 * 2.0 * 1.644_853_626_951, 1e-9);
    let [_, half, high] = quantiles(Prior::LogNormal(0.6, 0.42));
    close(half, 0.6, 1e-9);
    close(libm::log(high / 0.6), 0.42 * 1.644_853_626_951, 1e-9);
    // The ends are numbers too.
    let normal = Marginal::new(Prior::Normal(0.0, 1.0), &[]).unwrap();
    assert!(normal.value(0.0).is_finite() && normal.value(1.0).is_finite());
}

/// A normal prior and a normal row make a normal posterior of added precisions.
#[test]
fn a_row_and_a_normal_prior_are_conjugate() {
    for (value, tolerance) in [(31.0, 1.0), (33.0, 0.01), (29.0, 1e-5), (30.0, 50.0)] {
        let prior = Prior::Normal(30.5, 2.0);
        let marginal = Marginal::new(prior, &[&row(value, tolerance)]).unwrap();
        let (own, its) = (1.0 / 4.0, 1.0 / (tolerance * tolerance));
        let mean = (30.5 * own + value * its) / (own + its);
        let deviation = 1.0 / libm::sqrt(own + its);
        close(marginal.value(0.5), mean, 0.02 * deviation);
        close(
            marginal.value(0.95),
            mean + 1.6449 * deviation,
            0.03 * deviation,
        );
        let off = (value - 30.5) * (value - 30.5) / (2.0 * (4.0 + tolerance * tolerance));
        let log = libm::log(tolerance) - 0.5 * libm::log(4.0 + tolerance * tolerance) - off;
        close(marginal.log_evidence, log, 0.02);
    }
}

#[test]
fn a_row_far_from_every_value_leaves_nothing() {
    let prior = Prior::LogUniform(0.1, 3.0);
    assert!(Marginal::new(prior, &[&row(8.0, 0.01)]).is_none());
    assert!(Marginal::new(prior, &[&row(1.0, 0.01), &row(2.0, 0.01)]).is_none());
    assert!(Marginal::new(Prior::Known(0.2), &[&row(8.0, 0.01)]).is_none());
    assert!(Marginal::new(prior, &[&row(3.01, 0.01)]).is_some());
}

#[test]
fn sides_factors_and_bounds_count_as_they_say() {
    let stroke = EvidenceRow {
        tolerance: None,
        factor: Some([libm::exp(1.2), libm::exp(0.5)]),
        ..row(10.0, 1.0)
    };
    close(log_likelihood(&stroke, 10.0 * libm::exp(0.5)), -0.5, 1e-12);
    close(log_likelihood(&stroke, 10.0 * libm::exp(-1.2)), -0.5, 1e-12);
    assert!(log_likelihood(&stroke, 0.0).is_finite());
    let over = EvidenceRow {
        bound: Bound::Over,
        times: 2,
        ..row(0.0, 4.0)
    };
    close(libm::exp(log_likelihood(&over, 0.0)), 0.25, 1e-12);
    close(
        libm::exp(log_likelihood(&over, 4.0)),
        0.841_344_7 * 0.841_344_7,
        1e-6,
    );
    let silent = log_likelihood(&over, -200.0);
    assert!(silent.is_finite() && silent < -2000.0, "{silent}");
    let under = EvidenceRow {
        bound: Bound::Under,
        ..row(12.0, 4.0)
    };
    close(libm::exp(log_likelihood(&under, 8.0)), 0.841_344_7, 1e-6);
}
