"""The wrenches of the effects that a diagnosis added to a model."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import trundle
from trundle.export import Laws
from trundle.viewing.wrenches import added_laws, law_wrenches

BODY = """
format = "trundle-model/1"
[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 20.0
"""
WHEEL = """
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.4
mu_x = 15.0
mu_y = 180.0
"""
SECOND = WHEEL.replace("-0.5", "0.5")
CASTER = """
[[effect]]
kind = "caster_swivel"
x = 0.5
y = 0.3
trail = 0.05
mu_side = 60.0
"""
BIAS = """
[[effect]]
kind = "force_bias"
force_x = 1.0
force_y = 0.5
torque_z = 0.1
drift_x = 0.0
drift_y = 0.0
"""
DISCREPANCY = """
[unnamed]
inputs = ["position", "heading"]
axes = "world"
scales = [0.6, 0.6, 0.8, 0.8]
centres = [[0.1, 0.0, 1.0, 0.0], [0.4, 0.2, 0.9, 0.4]]
weights = [[6.0, -4.0, 1.0], [-5.0, 7.0, -0.5]]
"""
READING_DISCREPANCY = """
[unnamed]
inputs = ["since_contact"]
axes = "reading"
scales = [1.0]
centres = [[0.1], [0.5]]
weights = [[6.0, -4.0, 1.0], [-5.0, 7.0, -0.5]]
"""
NOMINAL = {"nominal": {"given": {"viscous_wheel.x": -0.5}, "before": {"mass": {}}, "after": {}}}


def motion(n: int = 40) -> dict[str, Any]:
    """Return a motion sideways that turns."""
    t = np.arange(n) * 0.05
    pose = np.column_stack([0.1 * t, 0.3 * t, 0.2 * t])
    return {"t": t, "pose": pose, "twist": np.tile([0.1, 0.3, 0.2], (n, 1))}


@pytest.mark.parametrize(
    ("added", "names"),
    [
        ("", []),
        (SECOND, ["viscous_wheel"]),
        (CASTER, ["caster_swivel"]),
        (CASTER + CASTER.replace("0.3", "-0.3"), ["caster_swivel", "caster_swivel_2"]),
        (BIAS, []),
        (DISCREPANCY, ["discrepancy"]),
        (READING_DISCREPANCY, []),
    ],
)
def test_only_added_effects_on_the_object_have_a_wrench(added: str, names: list[str]) -> None:
    assert list(added_laws(trundle.Model.from_toml(BODY + WHEEL + added), NOMINAL)) == names


@pytest.mark.parametrize("added", [SECOND, DISCREPANCY])
def test_the_wrench_is_the_difference_of_both_models(added: str) -> None:
    models = [trundle.Model.from_toml(BODY + WHEEL + text) for text in ("", added)]
    (law,) = added_laws(models[1], NOMINAL).values()
    moved = motion()
    found = law_wrenches(law, moved, np.zeros((40, 3)), 0.0, 0)
    each = [
        np.array(
            [
                Laws(model).wrench(pose, twist)
                for pose, twist in zip(moved["pose"], moved["twist"], strict=True)
            ]
        )
        for model in models
    ]
    assert np.abs(found).max() > 1.0
    np.testing.assert_allclose(found, each[1] - each[0], atol=1e-9)


def test_inner_states_follow_the_motion() -> None:
    (law,) = added_laws(trundle.Model.from_toml(BODY + WHEEL + CASTER), NOMINAL).values()
    n = 200
    straight = {
        "t": np.arange(n) * 0.02,
        "pose": np.zeros((n, 3)),
        "twist": np.tile([0.0, 0.3, 0.0], (n, 1)),
    }
    sideways = np.abs(law_wrenches(law, straight, np.zeros((n, 3)), 0.0, 0)[:, 1])
    assert sideways[0] > 1.0
    assert sideways[-1] < 0.1 * sideways[0], "the caster has turned into the direction of motion"
