"""Medians with intervals, also of counts that are never reached."""

import math

import numpy as np
import pytest

from trundle.experiments.paper.open_loop import required_accuracy
from trundle.experiments.statistics import first_reached, first_sustained, median, median_difference

COUNTS = [1, 2, 5, 10]


@pytest.mark.parametrize(
    ("scores", "first", "kept"),
    [
        ([0.1, 0.996, 0.9, 0.999], 2, 10),
        ([0.1, 0.2, 0.995, 0.995], 5, 5),
        ([0.1, 0.996, 0.99, 0.99], 2, math.inf),
        ([None, 0.1, None, 0.99], math.inf, math.inf),
    ],
)
def test_counts_at_which_a_threshold_is_reached(
    scores: list[float | None], first: float, kept: float
) -> None:
    assert first_reached(COUNTS, scores, 0.995) == first
    assert first_sustained(COUNTS, scores, 0.995) == kept


def test_medians_with_unreached_thresholds() -> None:
    some = median([4, 5, 6, math.inf, 7])
    assert (some.middle, some.low) == (6, 4)
    assert math.isinf(some.high)
    assert some.text(".0f") == "6 [4, not reached]"
    assert median([math.inf] * 4).text() == "not reached"
    assert median([5, math.inf]).middle == math.inf


def test_intervals_of_medians_have_their_nominal_coverage() -> None:
    rng = np.random.default_rng(1)
    found = [median(rng.exponential(size=20)) for _ in range(300)]
    covered = np.mean([one.low <= math.log(2) <= one.high for one in found])
    assert 0.90 <= covered <= 0.99


def test_differences_are_paired_and_two_failures_are_equal() -> None:
    spread = np.array([3.0, 30.0, 10.0, 50.0, 20.0])
    assert median_difference(spread - 1, spread).high == -1
    assert median_difference([math.inf, 3], [math.inf, 3]).text() == "0"
    assert median_difference([3, 4], [math.inf, math.inf]).middle == -math.inf


def test_the_accuracy_needed_by_half_of_the_plans() -> None:
    plans = [{"r2": 0.1 * k, "share": 0.5 if k in (2, 5, 6, 8, 9) else 2.0} for k in range(10)]
    # The isotonic regression of success is 0, 0, three times 1/3, three times 2/3, 1, 1.
    assert required_accuracy(plans, 1 / 3 - 1e-9) == pytest.approx(0.2)
    assert required_accuracy(plans, 0.5) == pytest.approx(0.5)
    assert required_accuracy(plans, 0.8) == pytest.approx(0.8)
    assert math.isnan(required_accuracy([{"r2": 1.0, "share": 2.0}], 0.5))
