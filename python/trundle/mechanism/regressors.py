"""The effort that a mechanism needs for a motion, with its derivatives by the model's quantities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle.display.fields import DisplayedFields
from trundle.mechanism.evaluation import evaluate, inverse_by_velocity
from trundle.mechanism.inertial import (
    Frames,
    body_columns,
    body_mass_matrix,
    gravity_columns,
    inertia_columns,
    projected_jacobian,
)

if TYPE_CHECKING:
    from trundle.mechanism.model import Mechanism
    from trundle.mechanism.rigid_groups import RigidGroup

__all__ = ["Regressors", "evaluate_regressors"]

Floats = NDArray[np.float64]

CHUNK = 4096
"""Samples that are evaluated at once, which bounds the memory for poses."""
POSITION_STEP = 1e-4
"""Step of central differences by position, rad or m: truncation and rounding are near 1e-8 of the effort."""
VELOCITY_STEP = 1e-4
"""Step of central differences by velocity, which are exact for forces that are quadratic in it."""


@dataclass(frozen=True, repr=False)
class Regressors(DisplayedFields):
    """Effort and derivatives at T samples of n recorded joints.

    Attributes
    ----------
    effort : (T, n) array
        What the model needs for the motion, in N·m or N: see `Mechanism.inverse_dynamics`.
    friction : (T, n) array
        The part of it that is the model's own dry friction, loss·sign(v).
    mass_matrix : (T, n, n) array
        Derivative of the effort by acceleration; armature is on the diagonal.
    mass : dict of str to (T, n) array
        By the mass of each moving body, per kg. The inertia scales with the mass, the centre stays.
    gravity : (T, n, 3) array
        By the components of gravity in world axes.
    mass_gravity : dict of str to (T, n, 3) array
        By the mass of each moving body and by the components of gravity.
    payload : dict of str to (T, n, 10) array
        By the inertial parameters of a mass on each moving body, in the body's axes about its origin: m,
        m·c_x, m·c_y, m·c_z, and the second moments xx, yy, zz, xy, xz, yz, which are m·c_i·c_j for a point
        mass m at c.
    matrix_mass : dict of str to (T, n, n) array
        Derivative of the mass matrix by the mass of each moving body, per kg.
    own_payload : dict of str to (T, n, 10) array
        Derivative of the diagonal of the mass matrix by the inertial parameters of a mass on each body.
    position : (T, n, n) array or None
        By the positions: entry [t, i, k] is the derivative of effort i by position k. An encoder that reads
        true + offset gives its negative. Not of friction.
    curvature : (T, n, n) array or None
        Second derivatives by the positions: entry [t, i, k] is that of effort i by position k.
    mass_position : dict of str to (T, n, n) array, or None
        By the mass of each moving body and by the positions.
    velocity : (T, n, n) array or None
        By the velocities, friction not included.
    constraint : (T, n) array
        The part of the effort that works against limits and contacts. It is not part of the derivatives by
        mass, gravity and payload.
    contacts : (T,) array
        Number of contacts that MuJoCo finds in each pose.

    Examples
    --------
    >>> import numpy as np
    >>> from trundle.mechanism import Mechanism
    >>> arm = Mechanism.load(
    ...     "<mujoco><worldbody><body name='arm'><joint name='elbow' axis='0 1 0'/>"
    ...     "<inertial pos='1 0 0' mass='2' diaginertia='1e-6 1e-6 1e-6'/></body></worldbody></mujoco>",
    ...     ["elbow"],
    ... )
    >>> found = arm.regressors(np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1)))
    >>> float(found.effort[0, 0].round(6)), float(found.mass["arm"][0, 0].round(6))
    (-19.62, -9.81)
    """

    effort: Floats
    friction: Floats
    mass_matrix: Floats
    mass: dict[str, Floats]
    gravity: Floats
    mass_gravity: dict[str, Floats]
    payload: dict[str, Floats]
    matrix_mass: dict[str, Floats]
    own_payload: dict[str, Floats]
    position: Floats | None
    curvature: Floats | None
    mass_position: dict[str, Floats] | None
    velocity: Floats | None
    constraint: Floats
    contacts: NDArray[np.intp]


def evaluate_regressors(
    mechanism: Mechanism, q: Floats, v: Floats, a: Floats, *, derivatives: bool
) -> Regressors:
    """Evaluate all columns in chunks of samples; `Mechanism.regressors` describes the arguments."""
    rows = [slice(start, start + CHUNK) for start in range(0, max(len(q), 1), CHUNK)]
    parts = [_evaluate(mechanism, q[chunk], v[chunk], a[chunk], derivatives) for chunk in rows]
    names = [field.name for field in fields(Regressors)]
    return Regressors(**{name: _join([getattr(part, name) for part in parts]) for name in names})


def _join(parts: Sequence[Any]) -> Any:
    if len(parts) == 1 or parts[0] is None:
        return parts[0]
    if isinstance(parts[0], dict):
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return np.concatenate(parts)


def _evaluate(mechanism: Mechanism, q: Floats, v: Floats, a: Floats, derivatives: bool) -> Regressors:
    coordinates, model = mechanism.coordinates, mechanism.compiled
    motion = coordinates.expand(q, v, a)
    slope = motion[3]
    found = evaluate(model, mechanism.data, *motion[:3])
    friction = coordinates.project(model.dof_frictionloss * np.sign(motion[1]), slope)
    gravity = np.zeros((len(q), len(model.jnt_type), 3))
    mass, mass_gravity, payload, matrix_mass, own_payload = ({} for _ in range(5))
    # Compensation of gravity by an actuator is disabled with it, so that it is part of the effort.
    passive = ~model.jnt_actgravcomp.astype(bool)[:, None]
    for group in mechanism.groups:
        place = (found.frames, group.body, group.chain)
        total, by_mass = _body(mechanism, group, found.frames, motion[1], motion[2])
        mass[group.name] = coordinates.project(by_mass, slope)
        payload[group.name] = coordinates.project(total, slope)
        jacobian = projected_jacobian(*place, lambda effort: coordinates.project(effort, slope))
        own_payload[group.name] = inertia_columns(*jacobian)
        matrix_mass[group.name] = body_mass_matrix(*jacobian, group.parameters / group.mass)
        scaling = gravity_columns(*place, group.parameters)
        scaling -= passive * gravity_columns(*place, group.compensated)
        mass_gravity[group.name] = coordinates.project(scaling / group.mass, slope)
        gravity += scaling + gravity_columns(*place, group.carried)
    inertia = coordinates.project(found.matrix, slope).transpose(0, 2, 1)
    slope_and_curvature = _by_position(mechanism, q, v, a) if derivatives else (None, None)
    return Regressors(
        effort=coordinates.project(found.effort, slope) + friction,
        friction=friction,
        mass_matrix=coordinates.project(inertia, slope),
        mass=mass,
        gravity=coordinates.project(gravity, slope),
        mass_gravity=mass_gravity,
        payload=payload,
        matrix_mass=matrix_mass,
        own_payload=own_payload,
        position=slope_and_curvature[0],
        curvature=slope_and_curvature[1],
        mass_position=_mass_by_position(mechanism, mass, q, v, a) if derivatives else None,
        velocity=_by_velocity(mechanism, q, v, a) if derivatives else None,
        constraint=coordinates.project(found.constraint, slope),
        contacts=found.contacts,
    )


def _body(
    mechanism: Mechanism, group: RigidGroup, frames: Frames, v: Floats, a: Floats
) -> tuple[Floats, Floats]:
    """Return the efforts by a body's inertial parameters, (T, N, 10), and by its mass, (T, N)."""
    model = mechanism.compiled
    total, weight = body_columns(frames, group.body, group.chain, v, a, model.opt.gravity)
    passive = ~model.jnt_actgravcomp.astype(bool)
    own = total @ group.parameters - passive * (weight @ group.compensated)
    return total, own / group.mass


def _mass_by_position(
    mechanism: Mechanism, mass: Mapping[str, Floats], q: Floats, v: Floats, a: Floats
) -> dict[str, Floats]:
    """Return differences, (T, n, n), of the effort by each body's mass by position."""
    coordinates = mechanism.coordinates
    columns: dict[str, list[Floats]] = {name: [] for name in mass}
    for step in POSITION_STEP * np.eye(coordinates.n):
        positions, velocity, acceleration, slope = coordinates.expand(q + step, v, a)
        motion = (positions, velocity, acceleration)
        frames = evaluate(mechanism.compiled, mechanism.data, *motion).frames
        for group in mechanism.groups:
            _, by_mass = _body(mechanism, group, frames, velocity, acceleration)
            moved = coordinates.project(by_mass, slope)
            columns[group.name].append((moved - mass[group.name]) / POSITION_STEP)
    return {name: np.stack(own, axis=2) for name, own in columns.items()}


def _by_position(mechanism: Mechanism, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
    """Return central differences of first and second order, (T, n, n), of the effort by position."""
    here = mechanism.smooth_effort(q, v, a)
    slopes, curvatures = [], []
    for step in POSITION_STEP * np.eye(mechanism.coordinates.n):
        above, below = mechanism.smooth_effort(q + step, v, a), mechanism.smooth_effort(q - step, v, a)
        slopes.append((above - below) / (2 * POSITION_STEP))
        curvatures.append((above - 2 * here + below) / POSITION_STEP**2)
    return np.stack(slopes, axis=2), np.stack(curvatures, axis=2)


def _by_velocity(mechanism: Mechanism, q: Floats, v: Floats, a: Floats) -> Floats:
    """Return central differences, (T, n, n), of the effort by velocity."""
    coordinates = mechanism.coordinates
    positions, _, _, slope = coordinates.expand(q, v, a)
    steps = VELOCITY_STEP * np.eye(coordinates.n)
    motions = [coordinates.expand(q, v + sign * step, a)[1:3] for step in steps for sign in (1, -1)]
    efforts = inverse_by_velocity(mechanism.compiled, mechanism.data, positions, motions)
    changes = [up - down for up, down in zip(efforts[::2], efforts[1::2], strict=True)]
    columns = [coordinates.project(change, slope) / (2 * VELOCITY_STEP) for change in changes]
    return np.stack(columns, axis=2)
