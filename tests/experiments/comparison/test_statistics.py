"""Statistics and intervals, compared with SciPy and with known results."""

import numpy as np
import pytest
from scipy.stats import trim_mean

from trundle.experiments.statistics import difference, improvement, iqm, rate, relative_excess


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 200])
def test_the_interquartile_mean_agrees_with_scipy(count: int) -> None:
    values = np.random.default_rng(1).lognormal(size=(count, 1))
    assert iqm(values).value == pytest.approx(trim_mean(values[:, 0], 0.25))


def test_intervals_have_their_nominal_coverage() -> None:
    # The interquartile mean of a symmetric distribution is its centre.
    random = np.random.default_rng(2)
    held = 0
    for _ in range(200):
        found = iqm(random.normal(3.0, 1.0, size=(60, 1)))
        held += found.low <= 3.0 <= found.high
    assert 0.89 <= held / 200 <= 0.99


def test_rates_have_wilson_intervals() -> None:
    found = rate(np.ones((200, 1)))
    assert found.value == 1.0
    assert found.high == pytest.approx(1.0)
    assert found.low == pytest.approx(0.9811, abs=1e-4)  # 200 of 200 by Wilson


def test_runs_that_differ_widen_an_interval() -> None:
    alike = np.repeat(np.random.default_rng(3).random((100, 1)) < 0.5, 3, axis=1).astype(float)
    apart = np.repeat([[0.0, 0.5, 1.0]], 100, axis=0)
    assert rate(alike).high - rate(alike).low < 0.21
    assert rate(apart).low == 0.0
    assert rate(apart).high == 1.0


def test_differences_are_paired_by_world() -> None:
    a = np.random.default_rng(4).normal(0.0, 9.0, size=(50, 1))
    shift = difference(a + 0.5, a)
    assert (shift.low, shift.value, shift.high) == pytest.approx((0.5, 0.5, 0.5))
    double = relative_excess(3 * np.abs(a), np.abs(a))
    assert (double.low, double.value, double.high) == pytest.approx((2.0, 2.0, 2.0))


def test_improvement_counts_worlds_and_ties_half() -> None:
    a, b = np.array([[1.0], [2.0], [5.0], [0.0]]), np.array([[1.0], [1.0], [4.0], [3.0]])
    assert improvement(a, b).value == pytest.approx(2.5 / 4)
    runs = np.array([[0.0, 2.0]])
    assert improvement(runs, np.array([[1.0]])).value == 0.5


def test_the_same_scores_give_the_same_interval() -> None:
    scores = np.random.default_rng(5).random((20, 2))
    assert iqm(scores) == iqm(scores.copy())
