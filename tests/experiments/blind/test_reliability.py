"""Probabilities of names, from the answers of the wide benchmark."""

from __future__ import annotations

import math
from typing import Any

import pytest

from trundle.experiments.blind.reliability import PREVALENCE, Platt, current_platt, fit_platt

IDENTITY = Platt(0.0, 1.0, 6.9)


def row(probability: float, *, right: bool, clean: bool = False) -> dict[str, Any]:
    effect = "latency" if right else "tether"
    missing = [{"effect": effect, "probability": probability}]
    truth = {"names": [] if clean else ["latency"], "outside": False}
    return {"answer": {"verdict": "explained", "missing": missing, "tied": []}, "truth": truth}


def test_prevalences_are_shares() -> None:
    assert sum(PREVALENCE.values()) == pytest.approx(1.0)


def test_the_logit_is_invertible() -> None:
    platt = Platt(-0.4, 0.7, 6.9)
    for logit in (-3.0, 0.0, 2.5, 6.9):
        assert platt.logit(platt.probability(logit)) == pytest.approx(logit)
    assert platt.probability(50.0) == platt.probability(6.9)
    assert current_platt().probability(6.9) > 0.5


def test_overconfident_odds_are_reduced() -> None:
    rows = [row(0.999, right=k % 4 > 0) for k in range(40)] + [row(0.6, right=k % 2 > 0) for k in range(40)]
    found = fit_platt(rows, IDENTITY)
    assert found is not None
    assert found.probability(6.9) == pytest.approx(0.75, abs=0.04)
    assert found.probability(IDENTITY.logit(0.6)) == pytest.approx(0.5, abs=0.04)


def test_few_right_names_bound_the_probability() -> None:
    found = fit_platt([row(0.9999, right=True) for _ in range(8)], IDENTITY)
    assert found is not None
    assert found.probability(6.9) < 0.95


def test_few_wrong_names_fit_the_bound_only() -> None:
    rows = [row(0.999, right=k > 0) for k in range(40)] + [row(0.6, right=k % 2 > 0) for k in range(20)]
    found = fit_platt(rows, IDENTITY)
    assert found is not None
    # All names have a single effect's prevalence, a quarter: 39 right and 1 wrong count as 9.75 and 0.25.
    assert (found.offset, found.slope) == (0.0, 1.0)
    assert found.most == pytest.approx(math.log(10.75 / 1.25))
    assert found.probability(IDENTITY.logit(0.6)) == pytest.approx(0.6)


def test_names_on_clean_recordings_have_the_weight_of_their_prevalence() -> None:
    rows = [row(0.999, right=True) for _ in range(90)] + [row(0.999, right=False, clean=True)]
    with_many = [*rows, *(row(0.999, right=False, clean=True) for _ in range(9))]
    one, many = fit_platt(rows, IDENTITY), fit_platt(with_many, IDENTITY)
    assert one is not None and many is not None
    # All clean recordings had a wrong name, however many were drawn.
    assert one.probability(6.9) == pytest.approx(many.probability(6.9), abs=0.1)
    assert one.probability(6.9) <= 0.5


def test_without_names_there_is_nothing_to_fit() -> None:
    silent = {"answer": {"verdict": "consistent", "missing": [], "tied": []}}
    assert fit_platt([{**silent, "truth": {"names": [], "outside": False}}], IDENTITY) is None
