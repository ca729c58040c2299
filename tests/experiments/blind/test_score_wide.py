"""Scoring of the wide benchmark."""

from __future__ import annotations

from typing import Any

import pytest

from trundle.experiments.blind.errors import coverage
from trundle.experiments.blind.score import (
    candidates,
    has_wrong_name,
    is_right,
    named_probabilities,
    relative_gain,
)


def truth(*names: str, outside: bool = False) -> dict[str, Any]:
    return {"names": list(names), "outside": outside, "truth": [], "mass_told": True, "mass": 10.0}


def answer(
    *names: str, tied: Any = (), tied_sets: Any = (), verdict: str = "explained", p: float = 0.95
) -> dict[str, Any]:
    missing: list[dict[str, Any]] = [
        {"effect": name, "probability": p, "parameters": {}, "where": None} for name in names
    ]
    return {"verdict": verdict, "missing": missing, "tied": list(tied), "tied_sets": list(tied_sets)}


def test_only_the_exact_set_is_right() -> None:
    assert is_right(answer("latency"), truth("latency"))
    assert is_right(answer("latency", "tether"), truth("tether", "latency"))
    assert not is_right(answer("latency"), truth("tether", "latency"))
    assert not is_right(answer("latency", "tether"), truth("tether"))
    assert not is_right(answer(verdict="unexplained"), truth("tether"))


def test_a_tie_with_the_truth_is_right_up_to_three_sets() -> None:
    two = answer("force_bias", tied=[["force_bias", "floor_slope"]])
    assert is_right(two, truth("floor_slope"))
    assert len(candidates(two)) == 2
    four = answer("force_bias", tied=[["force_bias", "floor_slope", "tether", "latency"]])
    assert not is_right(four, truth("floor_slope"))
    assert not is_right(two, truth("tether"))


def test_tied_sets_contain_complete_sets() -> None:
    found = answer("tether", tied_sets=[[["tether"], ["force_bias", "floor_slope"]]])
    assert is_right(found, truth("floor_slope", "force_bias"))
    assert is_right(found, truth("tether"))
    assert not is_right(found, truth("floor_slope"))
    # A class without the answer itself does not count.
    assert not is_right(answer("latency", tied_sets=[[["tether"], ["floor_slope"]]]), truth("tether"))


def test_masses_of_a_clean_mechanism_may_be_refitted() -> None:
    mechanism = {**truth(), "robot": "arm"}
    for verdict, right in (("consistent", True), ("reparameterised", True), ("unexplained", False)):
        assert is_right(answer(verdict=verdict), mechanism) is right


def test_clean_and_out_of_catalogue() -> None:
    assert is_right(answer(verdict="consistent"), truth())
    for verdict in ("unexplained", "reparameterised", "refused", "timeout"):
        assert not is_right(answer(verdict=verdict), truth())
    assert is_right(answer(verdict="unexplained"), truth("magnet", outside=True))
    assert not is_right(answer("tether"), truth("magnet", outside=True))


def test_confident_wrong_names_are_counted() -> None:
    assert has_wrong_name(answer("latency"), truth("tether"))
    assert not has_wrong_name(answer("latency", p=0.9), truth("tether"))
    assert not has_wrong_name(answer("latency"), truth("latency", "tether"))
    assert has_wrong_name(answer("latency"), truth("magnet", outside=True))
    assert not has_wrong_name(
        answer("force_bias", tied=[["force_bias", "floor_slope"]]), truth("floor_slope")
    )
    assert named_probabilities(answer("latency", "tether"), truth("tether")) == [(0.95, False), (0.95, True)]


def test_coverage_of_90_percent_intervals_of_right_answers() -> None:
    true = truth("latency")
    true["truth"] = [{"effect": "latency", "parameters": {"delay": 0.05}, "where": None}]
    for mean, held in ((0.05, True), (0.0516, True), (0.0517, False)):
        found = answer("latency")
        found["missing"][0]["parameters"] = {"delay": {"mean": mean, "sd": 0.001}}
        assert list(coverage({"answer": found, "truth": true})) == [("latency", held)]
    found["verdict"] = "unexplained"
    assert not list(coverage({"answer": found, "truth": true}))


def test_coverage_of_the_mass_if_it_was_not_given() -> None:
    found = answer(verdict="consistent")
    found["nominal"] = {"before": {"mass": {"mean": 10.2, "sd": 0.1}}}
    assert not list(coverage({"answer": found, "truth": truth()}))
    assert list(coverage({"answer": found, "truth": {**truth(), "mass_told": False}})) == [
        ("mass of the object", False)
    ]


def test_the_gain_of_the_oracle_is_one() -> None:
    true = {**truth("latency"), "oracle": {"before": 0.08, "after": 0.01}, "gyration": 0.0}
    held_out = {
        when: {"window_position_rmse": value, "window_heading_rmse": 0.0}
        for when, value in (("before", 0.04), ("after", 0.005))
    }
    assert relative_gain({**answer("latency"), "held_out": held_out}, true) == pytest.approx(1.0)
    assert relative_gain({**answer("latency"), "held_out": None}, true) is None
