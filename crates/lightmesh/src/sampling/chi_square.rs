//! Pearson's χ² test, for the tests of samplers.

/// Asserts that `counts` are a sample of the distribution in proportion to `weights`; cells without weight must be
/// empty.
///
/// The statistic must stay below the value that chance exceeds once in 10,000 times, by Wilson and Hilferty's
/// approximation ("The Distribution of Chi-Square", PNAS 17, 1931): χ²/k is nearly the cube of a normal variable of
/// mean 1 − 2/9k and variance 2/9k. That gives 19.3, 24.2, 67.9 and 115.0 for k = 2, 4, 30 and 64 degrees of freedom;
/// exact are 18.4, 23.5, 67.6 and 114.8.
pub(crate) fn assert_follows(counts: &[u32], weights: &[f64]) {
    assert_eq!(counts.len(), weights.len());
    const NORMAL_QUANTILE: f64 = 3.719;
    let n: f64 = counts.iter().copied().map(f64::from).sum();
    let total: f64 = weights.iter().sum();
    let (mut chi2, mut cells) = (0.0, 0);
    for (i, (&count, &weight)) in counts.iter().zip(weights).enumerate() {
        if weight == 0.0 {
            assert_eq!(count, 0, "cell {i} has no weight");
            continue;
        }
        let expected = weight / total * n;
        chi2 += (f64::from(count) - expected).powi(2) / expected;
        cells += 1;
    }
    let freedom = f64::from(cells - 1);
    let variance = 2.0 / (9.0 * freedom);
    let limit = freedom * (1.0 - variance + NORMAL_QUANTILE * variance.sqrt()).powi(3);
    assert!(chi2 < limit, "χ² = {chi2}, which chance exceeds {limit} with a probability of 1e-4");
}

/// [`assert_follows`] with equal weights.
pub(crate) fn assert_uniform(counts: &[u32]) {
    assert_follows(counts, &vec![1.0; counts.len()]);
}

#[test]
fn a_fair_die_passes() {
    assert_uniform(&[1010, 980, 1023, 995, 1002, 990]);
    assert_follows(&[500, 0, 1490], &[1.0, 0.0, 3.0]);
}

#[test]
#[should_panic(expected = "χ²")]
fn a_loaded_die_does_not() {
    assert_uniform(&[1200, 980, 1023, 995, 1002, 800]);
}

#[test]
#[should_panic(expected = "no weight")]
fn impossible_cells_stay_empty() {
    assert_follows(&[500, 1, 1490], &[1.0, 0.0, 3.0]);
}
