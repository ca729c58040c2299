"""Calibration of a diagnosis' odds by Platt's method, on the answers of a tuning range.

The odds compare the models that a diagnosis fitted. The share of correct names also depends on whether the
catalogue has the true law. Platt (1999) fits

    P(right) = 1 / (1 + exp(−(offset + slope · logit(odds))))

by maximum likelihood, with targets (n₊ + 1)/(n₊ + 2) and 1/(n₋ + 2) instead of one and zero, so that a finite
number of correct names does not give certainty. Each parameter needs ten wrong names (Peduzzi et al. 1996).
With fewer than twenty, offset and slope stay at zero and one, and only the bound on the odds is fitted: the
rule of succession, (n₊ + 1)/(n₋ + 1), on the names with a probability above 0.9.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from trundle import _native
from trundle.experiments.blind.score import CERTAIN_PROBABILITY, GROUPS, case_group, named_probabilities
from trundle.experiments.results import Row
from trundle.experiments.sampling import Floats

__all__ = ["PREVALENCE", "Platt", "current_platt", "fit_platt"]


PREVALENCE = dict(zip(GROUPS, (0.25, 0.1, 0.05, 0.02, 0.5, 0.08), strict=True))
"""Share of recordings of each kind for which probabilities are calibrated. Half of them are clean."""
EVENTS_PER_PARAMETER = 10
"""Smallest number of wrong names per fitted parameter (Peduzzi et al. 1996)."""


@dataclass(frozen=True)
class Platt:
    """Map from odds to probabilities.

    Attributes
    ----------
    offset, slope : float
        Of the logit.
    most : float
        Bound on the logit of the odds.
    """

    offset: float
    slope: float
    most: float

    def probability(self, logit: float) -> float:
        """Return the probability of a name."""
        bounded = max(-self.most, min(logit, self.most))
        return 1.0 / (1.0 + math.exp(-(self.offset + self.slope * bounded)))

    def logit(self, probability: float) -> float:
        """Return the logit of the odds for a probability, within ±`most`."""
        bounded = min(max(probability, 1e-12), 1.0 - 1e-12)
        logit = (math.log(bounded / (1.0 - bounded)) - self.offset) / self.slope
        return max(-self.most, min(logit, self.most))


def current_platt() -> Platt:
    """Return the parameters that diagnoses use."""
    return Platt(*_native._platt())


def fit_platt(rows: Sequence[Row], used: Platt) -> Platt | None:
    """Fit answers with a known truth, each kind of recording at its prevalence; None if no effect is named.

    Parameters
    ----------
    rows : sequence of dict
        With `answer` and `truth`.
    used : Platt
        The parameters behind the answers' probabilities.
    """
    counts = Counter(case_group(row["truth"]) for row in rows)
    found = []
    for row in rows:
        kind = case_group(row["truth"])
        weight = PREVALENCE[kind] / counts[kind] * len(rows)
        found += [
            (used.logit(p), right, weight) for p, right in named_probabilities(row["answer"], row["truth"])
        ]
    if not found:
        return None
    logits, right, weights = (np.array(column, dtype=float) for column in zip(*found, strict=True))
    if (right == 0.0).sum() < 2 * EVENTS_PER_PARAMETER:
        certain = logits > math.log(CERTAIN_PROBABILITY / (1.0 - CERTAIN_PROBABILITY))
        return Platt(0.0, 1.0, fit_bound(certain, right, weights))
    good, bad = float(weights @ right), float(weights @ (1.0 - right))
    target = np.where(right > 0.0, (good + 1.0) / (good + 2.0), 1.0 / (bad + 2.0))

    def cost(parameters: Any) -> float:
        eta = parameters[0] + parameters[1] * logits
        return float(weights @ (np.logaddexp(0.0, eta) - target * eta))

    # A slope of zero or below would reverse the order of the odds.
    best = minimize(cost, [0.0, 1.0], method="L-BFGS-B", bounds=[(None, None), (0.05, None)])
    return Platt(float(best.x[0]), float(best.x[1]), used.most)


def fit_bound(certain: NDArray[np.bool_], right: Floats, weights: Floats) -> float:
    """Return the logit of the share of certain names that are correct (rule of succession), at least zero."""
    good, bad = (float(weights @ (certain * held)) for held in (right, 1.0 - right))
    return max(math.log((good + 1.0) / (bad + 1.0)), 0.0)
