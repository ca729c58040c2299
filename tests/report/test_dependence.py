"""Quantities that predict the missing wrench, and results of tried models."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from tests.report.answers import Sample
from tests.report.test_page import words
from trundle.report import render
from trundle.report.dependence import predictors
from trundle.report.results import closest_rejected, results
from trundle.report.series import Series


def episode(seed: int, wrench: Any) -> dict[str, Any]:
    """A training episode whose missing wrench is a function of time, pose and twist."""
    draw = np.random.default_rng(seed)
    t = np.arange(0.0, 8.0, 0.02)
    heading = draw.uniform(-3.0, 3.0) + 1.5 * np.sin(draw.uniform(0.4, 0.9) * t)
    speed = 0.4 * np.sin(draw.uniform(0.3, 0.8) * t + draw.uniform(0.0, 6.0))
    x, y = (np.cumsum(speed * way) * 0.02 for way in (np.cos(heading), np.sin(heading)))
    missing = wrench(t, heading, speed) + draw.normal(size=(len(t), 3)) * 0.1
    residual = {"t": t, "before": missing, "sd": np.full((len(t), 3), 0.5)}
    pose = np.column_stack([x, y, heading])
    return {"name": f"e{seed}", "contact": 0.0, "t": t, "observed": pose, "residual": residual}


def best(wrench: Any) -> tuple[str, float]:
    series = Series.parse({"episodes": [episode(seed, wrench) for seed in range(8)]})
    return predictors(series)[0]


def along_x(values: Any) -> Any:
    return np.column_stack([values, 0.0 * values, 0.0 * values])


@pytest.mark.parametrize(
    ("wrench", "quantity"),
    [
        (lambda t, heading, speed: along_x(-5.0 * np.sign(speed)), "the direction of motion on the object"),
        (lambda t, heading, speed: along_x(30.0 * speed**2), "the speed"),
        (lambda t, heading, speed: along_x(4.0 * np.sin(heading)), "the heading"),
        (lambda t, heading, speed: along_x(np.where(t < 2.0, 6.0, -1.0)), "the time since contact"),
        (lambda t, heading, speed: along_x(np.full(len(t), 5.0)), "a constant alone"),
    ],
)
def test_the_best_predictor_is_the_cause(wrench: Any, quantity: str) -> None:
    name, share = best(wrench)
    assert share > 0.8
    assert name == quantity or quantity == "a constant alone"


def test_noise_depends_on_nothing() -> None:
    assert best(lambda t, heading, speed: np.zeros((len(t), 3)))[1] < 0.05


def test_a_single_episode_cannot_be_left_out() -> None:
    one = episode(0, lambda t, heading, speed: along_x(speed))
    assert predictors(Series.parse({"episodes": [one]})) == []
    assert predictors(Series.parse({"episodes": [one, one], "dof": ["x"]})) == []


RANKING = [
    {"effects": ["tether"], "log_evidence": -5.0, "reason": "an effect is not defined"},
    {"effects": ["latency"], "log_evidence": -6.0},
    {"effects": [], "log_evidence": -9.0},
    {"effects": ["floor_slope"], "log_evidence": -12.0},
]


def test_every_tried_model_has_a_result() -> None:
    assert results({"verdict": "unexplained"}, RANKING) == [
        "an effect is not defined",
        "less probable than a closer model, which is rejected",
        "the simulation, refitted: its residual exceeds what noise explains",
        "less probable than the simulation without it",
    ]
    explained = {"verdict": "explained", "missing": [{"effect": "latency"}]}
    assert results(explained, RANKING)[1:] == [
        "named",
        "the simulation, refitted: an effect is missing",
        "less probable than the named model",
    ]
    assert closest_rejected({"verdict": "unexplained"}, RANKING) == (["tether"], "an effect is not defined")
    assert closest_rejected({}, RANKING[2:3]) is None


def test_the_next_recording_follows_the_residual_not_the_refitted_simulation(
    samples: dict[str, Sample],
) -> None:
    diagnosis, series = copy.deepcopy(samples["unexplained"])
    diagnosis["mismatch"] |= {"regime": "above 0.25 m/s", "regime_kind": "high_speed"}
    diagnosis["residual"] = {"regime": "within 0.2 s of each contact", "regime_kind": "after_contact"}
    text = words(render(diagnosis, series))
    assert "It occurs within 0.2 s of each contact." in text
    assert "Repeat a push with a slow first contact and with a fast one." in text
    assert "above 0.25" not in text


def test_on_a_rail_no_turn_of_the_object_is_advised(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["unexplained"])
    regime = "in all motions, as a force constant in the world along 0°"
    diagnosis["residual"] = {"regime": regime, "regime_kind": "constant_in_world"}
    series["dof"] = ["x"]
    text = words(render(diagnosis, series))
    assert "Turn the object" not in text
    assert "on another part of the rail" in text


def test_predictors_do_not_depend_on_units() -> None:
    """Millimetres and milliseconds give the same shares as metres and seconds."""
    plain = [episode(seed, lambda t, heading, speed: along_x(-5.0 * np.sign(speed))) for seed in range(4)]
    scaled = copy.deepcopy(plain)
    for one in scaled:
        one["t"] = one["t"] * 1000.0
        one["residual"]["t"] = one["residual"]["t"] * 1000.0
        one["observed"][:, :2] *= 1000.0
    found = [predictors(Series.parse({"episodes": episodes})) for episodes in (plain, scaled)]
    assert [name for name, _ in found[0]] == [name for name, _ in found[1]]
    np.testing.assert_allclose([share for _, share in found[0]], [share for _, share in found[1]], atol=1e-3)
