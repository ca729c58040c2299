"""Forward simulation against inverse dynamics and closed formulas."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.mechanism.models import ARM, JOINTS, Floats
from trundle import TrundleError
from trundle.mechanism import EffortDrive, Mechanism, PositionDrive, SwitchedDrive, simulate
from trundle.mechanism.simulation import JointLaws

MASS = 2.0
CART = (
    '<mujoco><worldbody><body name="cart"><joint name="rail" type="slide" axis="1 0 0"/>'
    '<inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/></body></worldbody></mujoco>'
)
PENDULUM = (
    '<mujoco><worldbody><body name="arm"><joint name="elbow" axis="0 1 0"/>'
    '<inertial pos="1 0 0" mass="2" diaginertia="1e-6 1e-6 1e-6"/></body></worldbody></mujoco>'
)


def constant(effort: float = 0.0, friction: float = 0.0, damping: float = 0.0) -> JointLaws:
    def laws(t: float, q: Floats, v: Floats, load: Floats) -> tuple[Floats, Floats, Floats]:
        return np.full_like(q, effort), np.full_like(q, friction), np.full_like(q, damping)

    return laws


def cart(
    drive: float, laws: JointLaws | None = None, seconds: float = 1.0, v0: float = 0.0
) -> tuple[float, float]:
    mechanism = Mechanism.load(CART, ["rail"])
    q, v = simulate(mechanism, [0.0, seconds], [0.0], [v0], EffortDrive([0.0], [[drive]]), laws)
    return float(q[-1, 0]), float(v[-1, 0])


def test_the_effort_of_the_inverse_dynamics_reproduces_the_motion() -> None:
    text = ARM.replace('frictionloss="0.4"', "").replace('frictionloss="0.02"', "")
    arm = Mechanism.load(text, JOINTS)
    t = np.linspace(0.0, 0.5, 501)
    rate, size = np.array([6.0, 7.0, 8.0, 5.0]), np.array([0.1, 0.3, 0.4, 0.05])
    phase = t[:, None] * rate + np.arange(4.0)
    q, v, a = size * np.sin(phase), size * rate * np.cos(phase), -size * rate**2 * np.sin(phase)
    drive = EffortDrive(t, arm.inverse_dynamics(q, v, a))
    found, speed = simulate(arm, t[::50], q[0], v[0], drive, step=1e-4)
    # The follower's constraint is soft in MuJoCo and exact in the inverse dynamics.
    np.testing.assert_allclose(found, q[::50], atol=4e-3)
    np.testing.assert_allclose(speed, v[::50], atol=6e-2)


def test_a_joint_sticks_below_its_dry_friction_and_slides_above() -> None:
    place, speed = cart(2.9, constant(friction=3.0), seconds=2.0)
    assert abs(place) < 1e-4
    assert abs(speed) < 1e-4
    place, speed = cart(5.0, constant(friction=3.0), seconds=2.0)
    assert speed == pytest.approx((5.0 - 3.0) / MASS * 2.0, rel=2e-3)
    assert cart(0.0, constant(friction=3.0), seconds=1.0, v0=2.0)[1] == pytest.approx(0.5, rel=5e-3)


def test_the_friction_of_the_model_acts() -> None:
    rough = Mechanism.load(CART.replace("<joint", '<joint frictionloss="3"'), ["rail"])
    _, v = simulate(rough, [0.0, 2.0], [0.0], [0.0], EffortDrive([0.0], [[5.0]]), constant(friction=1.0))
    assert v[-1, 0] == pytest.approx((5.0 - 4.0) / MASS * 2.0, rel=3e-3)


def test_damping_is_implicit() -> None:
    assert cart(5.0, constant(damping=1e5), seconds=1.0)[1] == pytest.approx(5e-5, rel=1e-6)
    assert cart(0.0, constant(damping=4.0), seconds=1.0, v0=1.0)[1] == pytest.approx(np.exp(-2.0), rel=5e-3)
    assert cart(0.0, constant(effort=3.0), seconds=1.0)[1] == pytest.approx(1.5)


def test_fitted_values_act() -> None:
    heavy = Mechanism.load(CART, ["rail"]).adjusted(armature={"rail": 1.0}, mass={"cart": 4.0})
    _, v = simulate(heavy, [0.0, 1.0], [0.0], [0.0], EffortDrive([0.0], [[5.0]]))
    assert v[-1, 0] == pytest.approx(1.0)


def test_a_position_drive_is_limited_and_reaches_its_target() -> None:
    mechanism = Mechanism.load(CART, ["rail"])
    drive = PositionDrive([0.0, 1.0], [[0.0], [1.0]], stiffness=[200.0], damping=[60.0], limit=[4.0])
    t = np.linspace(0.0, 6.0, 601)
    q, v = simulate(mechanism, t, [0.0], [0.0], drive)
    assert np.abs(q[t < 1.0]).max() == 0.0
    assert np.diff(v[:, 0]).max() == pytest.approx(4.0 / MASS * 0.01, rel=1e-6)
    assert q[-1, 0] == pytest.approx(1.0, abs=1e-3)


def test_commands_are_held_and_measurements_interpolated() -> None:
    mechanism = Mechanism.load(CART, ["rail"])
    t = np.linspace(0.0, 2.0, 3)
    for hold, impulse in ((True, 0.0 + 4.0), (False, 2.0 + 6.0)):
        drive = EffortDrive([0.0, 1.0, 2.0], [[0.0], [4.0], [8.0]], hold=hold)
        _, v = simulate(mechanism, t, [0.0], [0.0], drive, step=1e-3)
        assert v[-1, 0] == pytest.approx(impulse / MASS, rel=2e-3)


def test_a_drive_that_is_off_exerts_nothing() -> None:
    mechanism = Mechanism.load(CART, ["rail"])
    servo = PositionDrive([0.0], [[1.0]], stiffness=[200.0], damping=[60.0])
    drive = SwitchedDrive(servo, [0.0, 1.0], [[0.0], [1.0]])
    q, _ = simulate(mechanism, np.linspace(0.0, 1.5, 151), [0.0], [0.0], drive)
    assert np.abs(q[:101]).max() == 0.0
    assert q[-1, 0] > 0.5


def test_laws_get_the_transmitted_load() -> None:
    """An arm held level: drive and gravity load the joint from both sides."""
    arm = Mechanism.load(PENDULUM, ["elbow"])
    loads = []

    def laws(t: float, q: Floats, v: Floats, load: Floats) -> tuple[Floats, Floats, Floats]:
        loads.append(float(load[0]))
        return np.zeros(1), np.array([0.5]), np.zeros(1)

    weight = 2.0 * 9.81
    drive = EffortDrive([0.0], [[-weight]])
    simulate(arm, [0.0, 0.05], [0.0], [0.0], drive, laws)
    assert loads[0] == 0.0
    np.testing.assert_allclose(loads[1:], -2 * weight, rtol=1e-6)
    loads.clear()
    nothing = EffortDrive([0.0], [[0.0]])
    simulate(arm, [0.0, 0.05], [0.0], [0.0], nothing, laws, known=drive)
    np.testing.assert_allclose(loads[1:], 0.0, atol=1e-6)


def test_a_follower_follows_in_the_simulation() -> None:
    arm = Mechanism.load(ARM, JOINTS)
    free = EffortDrive([0.0], [[0.0] * 4])
    q, _ = simulate(arm, np.linspace(0, 0.2, 21), [0.0] * 4, [0.0, 0.0, 0.0, 0.5], free)
    assert np.isfinite(q).all()
    assert abs(q[-1, 3] - q[0, 3]) > 1e-3


def explosive(t: float, q: Floats, v: Floats, load: Floats) -> tuple[Floats, Floats, Floats]:
    return 1e4 * v, np.zeros(1), np.zeros(1)


def test_divergence_is_marked() -> None:
    mechanism = Mechanism.load(CART, ["rail"])
    drive = EffortDrive([0.0], [[1.0]])
    q, v = simulate(mechanism, np.linspace(0, 1, 101), [0.0], [0.0], drive, explosive)
    ended = np.isnan(q[:, 0])
    assert not ended[:2].any()
    assert ended[-1]
    assert (np.diff(ended.astype(int)) >= 0).all()
    np.testing.assert_array_equal(np.isnan(v), np.isnan(q))


def test_divergence_between_two_outputs_leaves_no_message_and_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    mechanism = Mechanism.load(CART, ["rail"])
    q, _ = simulate(mechanism, [0.0, 1.0], [0.0], [0.0], EffortDrive([0.0], [[1.0]]), explosive)
    assert np.isnan(q[-1]).all()
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []


def test_refusals() -> None:
    mechanism = Mechanism.load(CART, ["rail"])
    drive = EffortDrive([0.0], [[0.0]])
    with pytest.raises(TrundleError, match="t: give increasing times"):
        simulate(mechanism, [0.0, 0.0], [0.0], [0.0], drive)
    with pytest.raises(TrundleError, match=r"q0, v0: shapes \(2,\) and \(1,\); give 1"):
        simulate(mechanism, [0.0, 1.0], [0.0, 1.0], [0.0], drive)
    with pytest.raises(TrundleError, match="one row of values for each time"):
        EffortDrive([0.0, 1.0], [[0.0]])
    with pytest.raises(TrundleError, match="times must increase"):
        PositionDrive([0.0, 0.0], [[0.0], [1.0]], [1.0], [1.0])
