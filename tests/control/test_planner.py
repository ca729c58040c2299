"""`trundle.Planner`: plans reach the goal, are reproducible, and invalid input is refused."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle

ROOT = Path(__file__).resolve().parents[2]
LOWER, UPPER = [-100.0, -100.0, -40.0], [100.0, 100.0, 40.0]
GRASP = [-0.6, 0.0]
TABLE = """
format = "trundle-model/1"
[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 22.0
[[effect]]
kind = "viscous_wheel"
x = 0.5
y = 0.3
angle = 0.4
mu_x = 150.0
mu_y = {mu_y}
"""
MODEL = trundle.Model.from_toml(TABLE.format(mu_y=90.0))
AT_REST: dict[str, Any] = {"pose": [0.0] * 3, "twist": [0.0] * 3, "goal": [0.3, 0.2, 0.3], "grasp": GRASP}


def test_an_executed_plan_ends_at_rest_at_the_goal() -> None:
    planner = trundle.Planner(LOWER, UPPER, seed=0)
    for _ in range(5):
        plan = planner.plan(MODEL, **AT_REST)
    assert plan.shape == (20, 3)
    assert np.all(np.abs(plan) <= UPPER)
    # About the origin of the object, and constant; rollout() interpolates between samples.
    wrench = plan + np.cross([*GRASP, 0.0], plan * [1, 1, 0])
    t = np.sort(np.concatenate([planner.hold * np.arange(20), planner.hold * np.arange(1, 21) - 1e-6]))
    poses, twists = MODEL.rollout([0.0] * 3, [0.0] * 3, t, np.repeat(wrench, 2, axis=0))
    error = poses[-1] - AT_REST["goal"]
    assert np.hypot(*error[:2]) < 0.03
    assert abs(error[2]) < 0.06
    assert np.hypot(*twists[-1, :2]) < 0.1


def test_plans_depend_on_the_seed_only() -> None:
    def plan(seed: int) -> list[list[float]]:
        answer: list[list[float]] = trundle.Planner(LOWER, UPPER, seed=seed).plan(MODEL, **AT_REST).tolist()
        return answer

    assert plan(3) == plan(3)
    assert plan(3) != plan(4)


def test_plans_do_not_depend_on_the_number_of_threads() -> None:
    script = (
        "import tests.control.test_planner as t;"
        "print(t.trundle.Planner(t.LOWER, t.UPPER, seed=1).plan(t.MODEL, **t.AT_REST).tobytes().hex())"
    )
    runs = [
        subprocess.run(
            [sys.executable, "-c", script],
            cwd=ROOT,
            env={**os.environ, "RAYON_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "4")
    ]
    assert len(runs[0]) > 20 * 3 * 16
    assert runs[0] == runs[1]


def test_advance_shifts_the_plan_and_restart_clears_it() -> None:
    planner = trundle.Planner(LOWER, UPPER, seed=0)
    first = planner.plan(MODEL, **AT_REST)
    planner.advance(planner.hold)
    assert not np.array_equal(planner.plan(MODEL, **AT_REST), first)
    planner.restart()
    assert np.array_equal(planner.plan(MODEL, **AT_REST), first)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"lower": UPPER, "upper": LOWER}, r"lower, upper = .*below its upper bound"),
        ({"lower": [np.nan] * 3}, r"lower, upper = .*finite"),
        ({"lower": [0.0]}, r"planner: .*length"),
        ({"horizon": 0}, r"horizon = 0: must be at least 1"),
        ({"horizon": -1}, r"planner: .*-1"),
        ({"samples": 0}, r"samples = 0"),
        ({"hold": 0.0}, r"hold = 0.0: must be positive"),
        ({"smoothness": 1.0}, r"smoothness = 1.0: must lie in \[0, 1\)"),
        ({"horizont": 3}, r"unknown field `horizont`"),
        ({"cost": {"heading": -1.0}}, r"cost.heading = -1.0"),
        ({"cost": {"speed_limit": 0.0}}, r"cost.speed_limit = 0.0: must be positive"),
        ({"cost": object()}, r"planner.cost: a value of type object"),
    ],
)
def test_invalid_settings_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(trundle.TrundleError, match=message):
        trundle.Planner(**{"lower": LOWER, "upper": UPPER, **settings})


@pytest.mark.parametrize("key", ["pose", "twist", "goal", "grasp"])
def test_non_finite_numbers_are_refused(key: str) -> None:
    planner = trundle.Planner(LOWER, UPPER)
    broken = [np.nan, *AT_REST[key][1:]]
    with pytest.raises(trundle.TrundleError, match=rf"{key} = \[NaN.*must be finite"):
        planner.plan(MODEL, **{**AT_REST, key: broken})


def test_a_model_with_free_values_is_refused() -> None:
    free = trundle.Model.from_toml(TABLE.replace("mu_y = {mu_y}", ""))
    with pytest.raises(trundle.TrundleError, match=r"viscous_wheel.mu_y has no value"):
        trundle.Planner(LOWER, UPPER).plan(free, **AT_REST)


def test_a_negative_time_is_refused() -> None:
    with pytest.raises(trundle.TrundleError, match=r"seconds = -1.0"):
        trundle.Planner(LOWER, UPPER).advance(-1.0)


BOX = [[[1.0, -0.3], [1.2, -0.3], [1.2, 0.2], [1.0, 0.2]]]


def test_a_restarted_planner_has_no_obstacle_map() -> None:
    used, new = (trundle.Planner(LOWER, UPPER, seed=0, samples=32) for _ in range(2))
    near, far = ({**AT_REST, "goal": [2.2, 0.0, 0.0], "pose": [x, 0.0, 0.0]} for x in (0.0, -2.5))
    used.plan(MODEL, **near, obstacles=BOX)
    used.restart()
    assert np.array_equal(used.plan(MODEL, **far, obstacles=BOX), new.plan(MODEL, **far, obstacles=BOX))


@pytest.mark.parametrize("away", [50.0, 1e12, 1e300])
def test_a_distant_goal_has_no_obstacle_map(away: float) -> None:
    planner = trundle.Planner(LOWER, UPPER, seed=0, samples=4)
    with pytest.raises(trundle.TrundleError, match="too far away for a path around obstacles"):
        planner.plan(MODEL, **{**AT_REST, "goal": [away, 0.0, 0.0]}, obstacles=BOX)


@pytest.mark.parametrize("wrong", [{"horizon": 10**18}, {"samples": 2**60}, {"hold": 1e9}])
def test_excessive_settings_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(trundle.TrundleError, match=next(iter(wrong))):
        trundle.Planner(LOWER, UPPER, **wrong)


def test_a_plan_on_predicted_motions_is_that_on_the_model() -> None:
    steps = 40
    wrench_times = np.repeat(0.05 * np.arange(steps + 1), 2)[1:-1]
    t = wrench_times + np.tile([0.0, -1e-9], steps)

    def simulate(plans: Any) -> Any:
        motions = []
        for plan in plans:
            wrench = np.repeat(plan, 2, axis=0)
            about = wrench + np.cross([*GRASP, 0.0], wrench * [1, 1, 0])
            poses, twists = MODEL.rollout([0.0] * 3, [0.0] * 3, t, np.repeat(about, 2, axis=0))
            motions.append(np.concatenate([poses, twists], axis=1)[1::2])
        return np.array(motions)[None]

    settings: dict[str, Any] = {"seed": 0, "samples": 16, "iterations": 2}
    exact = trundle.Planner(LOWER, UPPER, **settings).plan(MODEL, **AT_REST)
    planner = trundle.Planner(LOWER, UPPER, **settings)
    assert np.allclose(planner.plan(MODEL, **AT_REST, learnt=simulate), exact, atol=0.5)


class Predictions:
    """The same answer for all plans."""

    def __init__(self, found: Any) -> None:
        self.found = found

    def __call__(self, plans: Any) -> Any:
        return self.found


def test_invalid_predictions_are_refused() -> None:
    planner = trundle.Planner(LOWER, UPPER, samples=8)
    for found, message in (
        (np.zeros((1, 7, 40, 6)), r"shape \[1, 7, 40, 6\] for 8 plans"),
        (np.zeros((1, 8, 40, 5)), r"shape \[1, 8, 40, 5\]"),
        (np.zeros((1, 8, 39, 6)), r"312 predicted states: must be a multiple of 320"),
        ([1.0], "must return an array"),
    ):
        predictions = Predictions(found)
        with pytest.raises(trundle.TrundleError, match=message):
            planner.plan(MODEL, **AT_REST, learnt=predictions)

    def fail(plans: Any) -> Any:
        raise KeyError(len(plans))

    with pytest.raises(KeyError, match="8"):
        planner.plan(MODEL, **AT_REST, learnt=fail)
