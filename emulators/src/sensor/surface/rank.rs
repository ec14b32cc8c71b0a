//! Rank correlation, which tells how well a learnt coordinate follows a property of surfaces.

/// Spearman's rank correlation, -1 to 1: Pearson's of the ranks. Equal values share their mean rank; 0 where one side
/// does not vary. What has no partner on the other side does not count. NaN ranks above every number (or, with a sign,
/// below).
#[must_use]
pub fn spearman(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.len().min(b.len());
    let (a, b) = (ranks(&a[..pairs]), ranks(&b[..pairs]));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let product = libm::sqrt(dot(&a, &a) * dot(&b, &b));
    if product > 0.0 {
        dot(&a, &b) / product
    } else {
        0.0
    }
}

/// Ranks less their mean.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    // no zero below another
    let key = |i: usize| values[i] + 0.0;
    order.sort_by(|&a, &b| key(a).total_cmp(&key(b)));
    let middle = (values.len() as f64 - 1.0) / 2.0;
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for equal in order.chunk_by(|&a, &b| key(a).total_cmp(&key(b)).is_eq()) {
        let rank = first as f64 + (equal.len() as f64 - 1.0) / 2.0 - middle;
        equal.iter().for_each(|&index| ranks[index] = rank);
        first += equal.len();
    }
    ranks
}

#[cfg(test)]
#[path = "rank_tests.rs"]
mod tests;
