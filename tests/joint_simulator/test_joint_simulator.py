"""Diagnosis of the user's own simulator of joints: inverse dynamics, names, parameters, and errors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from tests.joint_simulator import arm
from trundle.joint_simulator import (
    InverseDynamics,
    JointSimulator,
    Samples,
    by_parameter,
    by_position,
    effort_scale,
    inverse_dynamics,
    simulate,
)
from trundle.mechanism import EffortDrive, MechanismModel

Floats = NDArray[np.float64]

FRICTION = 0.25
PARAMETERS: Any = {"upper_mass": 1.4, "fore_mass": (0.5, 0.1, 3.0), "damping": 0.2}


@pytest.fixture(scope="module")
def rubbing() -> trundle.JointRecording:
    return arm.recording(FRICTION)


def motion(count: int = 40) -> tuple[Floats, Floats, Floats]:
    rng = np.random.default_rng(0)
    q, v, a = (size * rng.uniform(-1, 1, (count, 2)) for size in (1.0, 3.0, 20.0))
    return q, v, a


def evaluated(step: Any, *, vectorized: bool) -> tuple[JointSimulator, Samples, InverseDynamics]:
    q, v, a = motion()
    simulator = JointSimulator(step, arm.JOINTS, vectorized=vectorized)
    samples = Samples("e0", 0.01 * np.arange(len(q)))
    scale = effort_scale(simulator, samples, q, v, a, arm.VALUES)
    return simulator, samples, inverse_dynamics(simulator, samples, q, v, a, arm.VALUES, scale)


def test_the_simulator_moves_as_wanted_under_the_efforts_of_inverse_dynamics() -> None:
    q, v, a = motion()
    _, _, found = evaluated(arm.step, vectorized=True)
    assert np.allclose(arm.acceleration(q, v, found.effort, arm.VALUES), a, atol=1e-8)
    assert found.nonlinear_share == 0.0
    assert np.allclose(found.mass_matrix, found.mass_matrix.transpose(0, 2, 1), atol=1e-10)


def test_one_call_for_many_states_gives_the_same_digits() -> None:
    single = evaluated(arm.step, vectorized=False)[2]
    batch = evaluated(arm.step, vectorized=True)[2]
    assert single.effort.tobytes() == batch.effort.tobytes()
    assert single.mass_matrix.tobytes() == batch.mass_matrix.tobytes()


def test_derivatives_agree_with_inverse_dynamics_at_other_values() -> None:
    q, v, a = motion()
    simulator, samples, found = evaluated(arm.step, vectorized=True)
    scale = effort_scale(simulator, samples, q, v, a, arm.VALUES)

    def effort(q: Floats, values: dict[str, float]) -> Floats:
        return inverse_dynamics(simulator, samples, q, v, a, values, scale).effort

    slopes = by_position(simulator, samples, q, v, arm.VALUES, found)
    for k, shift in enumerate(1e-4 * np.eye(2)):
        change = (effort(q + shift, arm.VALUES) - effort(q - shift, arm.VALUES)) / 2e-4
        assert np.allclose(slopes[:, :, k], change, atol=1e-4)
    described = [
        {"name": n, "start": x, "lower": 0.0, "upper": np.inf, "sd": None} for n, x in arm.VALUES.items()
    ]
    slopes = by_parameter(simulator, samples, q, v, arm.VALUES, found, described)
    for k, (name, value) in enumerate(arm.VALUES.items()):
        # The arm is linear in its masses and its damping.
        change = effort(q, {**arm.VALUES, name: 1.5 * value}) - effort(q, arm.VALUES)
        assert np.allclose(0.5 * value * slopes[:, :, k], change, atol=1e-5)


def test_friction_at_the_right_joint_is_named_and_parameters_are_refitted(
    rubbing: trundle.JointRecording, tmp_path: Path
) -> None:
    found = trundle.diagnose(rubbing, step=arm.step, parameters=PARAMETERS, vectorized=True)
    assert found.missing == ["joint_dry_friction:elbow"]
    effect = found.answer["missing"][0]
    assert effect["parameters"]["effort"]["mean"] == pytest.approx(FRICTION, rel=0.1)
    assert effect["parameters"]["effort"]["unit"] == "N·m"
    after = found.answer["nominal"]["after"]
    for name, value in arm.VALUES.items():
        assert after[name]["mean"] == pytest.approx(value, rel=0.1), name
    held_out = found.answer["fit"]["held_out"]
    for key in ("relative_position_rmse", "relative_window_rmse", "relative_effort_rmse"):
        assert held_out["after"][key] < 0.5 * held_out["before"][key], key
    assert any("black box" in warning for warning in found.answer["warnings"])
    model = MechanismModel.read(found.write(tmp_path / "found") / "model.toml")
    assert model.mechanism.types == {"shoulder": "hinge", "elbow": "hinge"}
    assert [effect.name for effect in model.effect] == found.missing


def test_values_are_tested_if_they_are_numbers_and_the_catalogue_replaces_free_parameters() -> None:
    clean = arm.recording(0.0, 5.0, held_out=())
    right = trundle.diagnose(clean, step=arm.step, parameters=arm.VALUES, vectorized=True)
    assert (right.verdict, right.missing) == ("consistent", [])
    wrong = {**arm.VALUES, "fore_mass": 0.9}
    values = trundle.diagnose(clean, step=arm.step, parameters=wrong, vectorized=True)
    assert (values.verdict, values.missing) == ("reparameterised", [])
    assert values.answer["nominal"]["given"]["fore_mass"] == 0.9

    def lighter(state: Floats, effort: Floats, dt: float, values: dict[str, float]) -> Floats:
        return arm.step(state, effort, dt, {**arm.VALUES, "damping": 0.0})

    fixed = trundle.diagnose(clean, step=lighter, vectorized=True)
    assert sorted(fixed.missing) == ["joint_viscous_friction:elbow", "joint_viscous_friction:shoulder"]


def test_a_parameter_in_which_efforts_are_not_linear_is_expanded_again() -> None:
    def step(state: Floats, effort: Floats, dt: float, values: dict[str, float]) -> Floats:
        return arm.step(state, effort, dt, {**arm.VALUES, "fore_mass": values["root"] ** 2})

    clean = arm.recording(0.0, 4.0, held_out=())
    found = trundle.diagnose(clean, step=step, parameters={"root": (0.5, 0.1, 2.0)}, vectorized=True)
    assert found.missing == []
    root = found.answer["nominal"]["after"]["root"]["mean"]
    assert root == pytest.approx(arm.VALUES["fore_mass"] ** 0.5, rel=5e-3)


def test_the_forward_simulation_holds_a_joint_by_dry_friction() -> None:
    simulator, samples, _ = evaluated(arm.step, vectorized=False)
    scale = effort_scale(simulator, samples, *motion(), arm.VALUES)
    t = 0.01 * np.arange(100)

    def laws(t: float, q: Floats, v: Floats, load: Floats) -> tuple[Floats, Floats, Floats]:
        return np.zeros(2), np.array([0.0, 10.0]), np.zeros(2)

    place: tuple[Any, ...] = (simulator, arm.VALUES, scale, "e0", t, (np.array([0.6, 0.3]), np.zeros(2)))
    drive = EffortDrive([0.0], [[0.0, 0.0]])
    held = simulate(*(*place, drive, laws))
    assert np.ptp(held[:, 1]) < 1e-3 < np.ptp(held[:, 0])
    assert np.ptp(simulate(*(*place, drive))[:, 1]) > 0.1


def nan(state: Floats, effort: Floats, dt: float, values: dict[str, float]) -> Floats:
    after = arm.step(state, effort, dt, values)
    after[3] = np.nan
    return after


def random(state: Floats, effort: Floats, dt: float, values: dict[str, float]) -> Floats:
    return arm.step(state, np.random.default_rng().normal(size=2), dt, values)


@pytest.mark.parametrize(
    ("step", "words"),
    [
        (lambda state, *_: state[:3], ["shape (3,)", "return 4 numbers", "shoulder, elbow"]),
        (nan, ["nan as the velocity of joint elbow", "finite numbers"]),
        (lambda *_: "nothing", ["returned str, not numbers"]),
        (lambda *_: 1 / 0, ["raised ZeroDivisionError", "call it with these arguments"]),
        (lambda state, *_: arm.step(state, np.zeros(2), 0.002, {}), ["joint shoulder moves", "exactly dt"]),
        (
            lambda state, effort, dt, _: arm.step(state, 0 * effort, dt, {}),
            ["must accelerate joint shoulder"],
        ),
        (random, ["the same arguments give different states"]),
    ],
)
def test_what_a_simulator_must_not_do(rubbing: trundle.JointRecording, step: Any, words: list[str]) -> None:
    with pytest.raises(trundle.TrundleError) as caught:
        trundle.diagnose(rubbing, step=step)
    for word in ["step: ", "episode e0, t = ", *words]:
        assert word in str(caught.value)


def swapped(state: Floats, effort: Floats, dt: float, values: dict[str, float]) -> Floats:
    return arm.step(state, effort + 0.8 * effort[..., ::-1] * [1.0, 0.0], dt, values)


def limited(state: Floats, effort: Floats, dt: float, values: dict[str, float]) -> Floats:
    return arm.step(state, np.clip(effort, -0.5, 0.5), dt, values)


@pytest.mark.parametrize(
    ("step", "words"),
    [(swapped, "in the order shoulder, elbow"), (limited, "is not linear in the effort")],
)
def test_a_simulator_that_is_no_mechanism_is_refused(
    rubbing: trundle.JointRecording, step: Any, words: str
) -> None:
    with pytest.raises(trundle.TrundleError, match=words):
        trundle.diagnose(rubbing, step=step, vectorized=True)


def test_arguments_that_exclude_each_other(rubbing: trundle.JointRecording, tmp_path: Path) -> None:
    for options, words in (
        ({"mjcf": tmp_path / "a.xml", "step": arm.step}, "only one simulation"),
        ({"parameters": arm.VALUES}, "need `step`"),
        ({"vectorized": True}, "need `step`"),
        ({}, "give a simulator as `step`"),
    ):
        with pytest.raises(trundle.TrundleError, match=words):
            trundle.diagnose(rubbing, **options)


def test_a_log_needs_no_model(tmp_path: Path) -> None:
    columns = arm.log(0, FRICTION)
    rows = [",".join(map(str, row)) for row in zip(*columns.values(), strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([",".join(columns), *rows]), encoding="utf-8")
    found = trundle.diagnose(path, step=arm.step, vectorized=True, without=["encoder_offset"])
    assert found.missing == ["joint_dry_friction:elbow"]


@pytest.mark.parametrize(
    ("mechanism", "words"),
    [
        ({"types": {"shoulder": "hinge"}}, "is a joint without a type"),
        ({"types": {"wrist": "hinge"}}, "does not name a recorded joint"),
        ({"types": "hinge", "axis": "hinge"}, "is given with model or axis"),
        ({"types": "hinge", "inertia": 1.0}, "describes one axis without a model"),
        ({"types": "ball"}, "hinge"),
    ],
)
def test_types_of_joints_are_checked(mechanism: dict[str, Any], words: str) -> None:
    metadata = {"format": "trundle-recording/2", "name": "arm", "split": {"held_out": []}}
    metadata["mechanism"] = {"joints": list(arm.JOINTS), **mechanism}
    with pytest.raises(trundle.TrundleError, match=words):
        trundle.JointRecording(metadata, {"e0": arm.log(0, 0.0, 1.0)})
