"""Derivatives against finite differences and against MuJoCo with changed models."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tests.mechanism.models import ARM, JOINTS, Floats, motion
from trundle.mechanism import Mechanism, Payload, Regressors

GROUPS = {"upper": ["upper", "wedge"], "rail": ["rail", "hand"], "left": ["left"], "right": ["right"]}
"""Bodies of `ARM` that move as one."""


@pytest.fixture(scope="module")
def arm() -> Mechanism:
    return Mechanism.load(ARM, JOINTS)


@pytest.fixture(scope="module")
def found(arm: Mechanism) -> Regressors:
    return arm.regressors(*motion())


def changed(arm: Mechanism) -> Mechanism:
    """Return a mechanism of its own whose compiled model may be changed."""
    return arm.adjusted()


def mass_matrix(mechanism: Mechanism) -> Floats:
    """Return the mass matrix along the motion, (T, n, n)."""
    return mechanism.regressors(*motion(), derivatives=False).mass_matrix


def test_the_effort_is_that_of_inverse_dynamics(arm: Mechanism, found: Regressors) -> None:
    np.testing.assert_array_equal(found.effort, arm.inverse_dynamics(*motion()))
    without = arm.regressors(*motion(), derivatives=False)
    np.testing.assert_array_equal(found.effort, without.effort)
    assert without.position is None
    assert without.velocity is None


def test_chunks_do_not_change_the_columns(arm: Mechanism, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = arm.regressors(*motion(7))
    monkeypatch.setattr("trundle.mechanism.regressors.CHUNK", 3)
    parts = arm.regressors(*motion(7))
    assert whole.position is not None
    np.testing.assert_array_equal(parts.effort, whole.effort)
    np.testing.assert_allclose(parts.payload["rail"], whole.payload["rail"], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(parts.position, whole.position)


@pytest.mark.parametrize("body", GROUPS)
def test_mass(arm: Mechanism, found: Regressors, body: str) -> None:
    other = changed(arm)
    indices = [other.compiled.body(name).id for name in GROUPS[body]]
    mass = other.compiled.body_mass[indices].sum()
    assert arm.masses[body] == pytest.approx(mass)
    added = 0.7
    other.compiled.body_mass[indices] *= 1 + added / mass
    other.compiled.body_inertia[indices] *= 1 + added / mass
    mujoco.mj_setConst(other.compiled, other.data)
    change = other.inverse_dynamics(*motion()) - found.effort
    assert np.abs(change).max() > 0.1
    np.testing.assert_allclose(added * found.mass[body], change, atol=1e-11)
    matrix_change = mass_matrix(other) - mass_matrix(arm)
    np.testing.assert_allclose(added * found.matrix_mass[body], matrix_change, atol=1e-11)
    np.testing.assert_allclose(
        arm.adjusted(mass={GROUPS[body][-1]: mass + added}).inverse_dynamics(*motion()),
        found.effort + change,
        atol=1e-11,
    )


def test_gravity(arm: Mechanism, found: Regressors) -> None:
    added = np.array([1.0, -2.0, 3.0])
    other = changed(arm)
    other.compiled.opt.gravity += added
    np.testing.assert_allclose(
        other.inverse_dynamics(*motion()) - found.effort, found.gravity @ added, atol=1e-11
    )


@pytest.mark.parametrize("body", GROUPS)
def test_mass_and_gravity_together(arm: Mechanism, found: Regressors, body: str) -> None:
    heavier = arm.adjusted(mass={body: arm.masses[body] + 0.7})
    change = heavier.regressors(*motion(), derivatives=False).gravity - found.gravity
    np.testing.assert_allclose(0.7 * found.mass_gravity[body], change, atol=1e-11)


@pytest.mark.parametrize("body", GROUPS)
def test_mass_and_position_together(arm: Mechanism, found: Regressors, body: str) -> None:
    heavier = arm.adjusted(mass={body: arm.masses[body] + 0.7}).regressors(*motion())
    assert found.mass_position is not None
    assert found.position is not None
    assert heavier.position is not None
    change = heavier.position - found.position
    np.testing.assert_allclose(0.7 * found.mass_position[body], change, atol=3e-3 * np.abs(change).max())


def test_an_offset_to_second_order(arm: Mechanism, found: Regressors) -> None:
    assert found.position is not None
    assert found.curvature is not None
    offset = 0.05
    change = arm.effort_with_offset(*motion(), "shoulder", offset) - found.effort
    expanded = -offset * found.position[:, :, 1] + 0.5 * offset**2 * found.curvature[:, :, 1]
    first = np.abs(change + offset * found.position[:, :, 1]).max()
    assert np.abs(change - expanded).max() < 0.1 * first


@pytest.mark.parametrize("body", ["upper", "wedge", "rail", "hand", "left", "right"])
def test_payload(arm: Mechanism, found: Regressors, body: str) -> None:
    mass, com = 0.6, np.array([0.1, -0.07, 0.05])
    loaded = Mechanism.load(ARM, JOINTS, payload=Payload(body, mass, (0.1, -0.07, 0.05)))
    data = mujoco.MjData(arm.compiled)
    mujoco.mj_kinematics(arm.compiled, data)
    first = arm.rigid_group(body)
    frame = data.body(first).xmat.reshape(3, 3)
    centre = frame.T @ (
        data.body(body).xpos + data.body(body).xmat.reshape(3, 3) @ com - data.body(first).xpos
    )
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    parameters = mass * np.array([1.0, *centre, *(centre[i] * centre[j] for i, j in pairs)])
    change = loaded.inverse_dynamics(*motion()) - found.effort
    assert np.abs(change).max() > 0.1
    np.testing.assert_allclose(found.payload[first] @ parameters, change, atol=1e-11)
    change = np.einsum("tii->ti", mass_matrix(loaded) - mass_matrix(arm))
    assert np.abs(change).max() > 1e-3
    np.testing.assert_allclose(found.own_payload[first] @ parameters, change, atol=1e-11)


def test_the_payload_is_no_part_of_the_mass_but_has_weight(arm: Mechanism) -> None:
    loaded = Mechanism.load(ARM, JOINTS, payload=Payload("hand", 0.6, (0.1, 0.0, 0.0)))
    assert loaded.masses == pytest.approx(arm.masses)
    plain, found = arm.regressors(*motion()), loaded.regressors(*motion())
    np.testing.assert_allclose(found.mass["rail"], plain.mass["rail"], atol=1e-11)
    other = changed(loaded)
    other.compiled.opt.gravity[2] += 1.0
    change = other.inverse_dynamics(*motion()) - found.effort
    np.testing.assert_allclose(change, found.gravity[:, :, 2], atol=1e-11)


def test_options_of_the_compiler_do_not_change_a_payload() -> None:
    text = ARM.replace("<compiler ", '<compiler boundmass="0.01" boundinertia="0.001" ')
    loaded = Mechanism.load(text, JOINTS, payload=Payload("hand", 0.6, (0.1, 0.0, 0.0)))
    assert loaded.compiled.body("trundle_payload").mass[0] == 0.6
    assert loaded.compiled.body("trundle_payload").inertia.tolist() == [0.0, 0.0, 0.0]


def test_the_mass_matrix_is_the_derivative_by_acceleration(arm: Mechanism, found: Regressors) -> None:
    q, v, a = motion()
    for k in range(len(JOINTS)):
        moved = a.copy()
        moved[:, k] += 1.0
        change = arm.inverse_dynamics(q, v, moved) - found.effort
        np.testing.assert_allclose(found.mass_matrix[:, :, k], change, atol=1e-11)


@pytest.mark.parametrize(("which", "step", "tolerance"), [(0, 1e-4, 3e-6), (1, 1e-3, 1e-8)])
def test_position_and_velocity(
    arm: Mechanism, found: Regressors, which: int, step: float, tolerance: float
) -> None:
    columns = (found.position, found.velocity)[which]
    assert columns is not None
    for k in range(len(JOINTS)):
        sides: list[Floats] = []
        for sign in (1, -1):
            moved = [each.copy() for each in motion()]
            moved[which][:, k] += sign * step
            sides.append(arm.smooth_effort(moved[0], moved[1], moved[2]))
        np.testing.assert_allclose(columns[:, :, k], (sides[0] - sides[1]) / (2 * step), atol=tolerance)


def test_an_offset_of_the_encoder(arm: Mechanism, found: Regressors) -> None:
    q, v, a = motion()
    assert found.position is not None
    offset = 1e-4
    change = arm.effort_with_offset(q, v, a, "shoulder", offset) - found.effort
    np.testing.assert_allclose(change, -offset * found.position[:, :, 1], atol=1e-6)
    exact = arm.inverse_dynamics(q - [0.0, offset, 0.0, 0.0], v, a)
    np.testing.assert_array_equal(arm.effort_with_offset(q, v, a, "shoulder", offset), exact)


def test_armature_and_damping(arm: Mechanism, found: Regressors) -> None:
    q, v, a = motion()
    other = arm.adjusted(armature={"roll": 0.51}, damping={"lift": 5.0})
    change = other.inverse_dynamics(q, v, a) - found.effort
    np.testing.assert_allclose(change[:, 2], 0.5 * a[:, 2], atol=1e-12)
    np.testing.assert_allclose(change[:, 0], 3.0 * v[:, 0], atol=1e-12)
    np.testing.assert_allclose(change[:, [1, 3]], 0.0, atol=1e-12)
    assert arm.armature.tolist() == [0.0, 0.02, 0.01, 0.0]


def test_friction_has_the_sign_of_the_velocity(arm: Mechanism, found: Regressors) -> None:
    q, v, a = motion()
    np.testing.assert_allclose(found.friction[:, 1], 0.4 * np.sign(v[:, 1]))
    reference = arm.regressors(np.zeros((1, 4)), np.zeros((1, 4)), np.zeros((1, 4)))
    np.testing.assert_array_equal(reference.friction, 0.0)
    rough = changed(arm)
    rough.compiled.dof_frictionloss[:] = 0.0
    np.testing.assert_allclose(rough.inverse_dynamics(q, v, a) + found.friction, found.effort, atol=1e-12)
