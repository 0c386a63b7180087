"""Pearson's chi-squared test of samples against expected counts."""

import numpy as np
from scipy.stats import chi2

MIN_EXPECTED = 8.0  # bins that expect less are pooled, where the statistic is not chi-squared


def p_value(observed, expected):
    """Probability of counts at least this far from the expected ones, if the density is right."""
    observed, expected = np.ravel(observed).astype(float), np.ravel(expected).astype(float)
    assert not np.any(observed[expected == 0.0]), "samples where the density is 0"
    order = np.argsort(expected)
    observed, expected = observed[order], expected[order]
    rare = np.cumsum(expected) < MIN_EXPECTED
    rare |= expected < MIN_EXPECTED
    obs = np.append(observed[~rare], observed[rare].sum())
    exp = np.append(expected[~rare], expected[rare].sum())
    keep = exp > 0.0
    statistic = ((obs[keep] - exp[keep]) ** 2 / exp[keep]).sum()
    return chi2.sf(statistic, keep.sum() - 1)


def least(tests, level=0.01):
    """Smallest p-value to accept when `tests` of them are made [Sidak 1967]."""
    return 1.0 - (1.0 - level) ** (1.0 / tests)
