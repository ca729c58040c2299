"""The effort that a mechanism needs for a motion, with its derivatives by the model's quantities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle.mechanism.evaluation import inverse_with_frames
from trundle.mechanism.inertial import body_columns, gravity_columns

if TYPE_CHECKING:
    from trundle.mechanism.model import Mechanism

__all__ = ["Regressors", "evaluate_regressors"]

Floats = NDArray[np.float64]

CHUNK = 4096
"""Samples that are evaluated at once, which bounds the memory for poses."""
POSITION_STEP = 1e-5
"""Step of central differences by position, rad or m: truncation and rounding are near 1e-10 of the effort."""
VELOCITY_STEP = 1e-4
"""Step of central differences by velocity, which are exact for forces that are quadratic in it."""


@dataclass(frozen=True)
class Regressors:
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
    payload : dict of str to (T, n, 10) array
        By the inertial parameters of a mass on each moving body, in the body's axes about its origin: m,
        m·c_x, m·c_y, m·c_z, and the second moments xx, yy, zz, xy, xz, yz, which are m·c_i·c_j for a point
        mass m at c.
    position : (T, n, n) array or None
        By the positions: entry [t, i, k] is the derivative of effort i by position k. An encoder that reads
        true + offset gives its negative. Not of friction.
    velocity : (T, n, n) array or None
        By the velocities, friction not included.

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
    payload: dict[str, Floats]
    position: Floats | None
    velocity: Floats | None


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
    effort, matrix, frames = inverse_with_frames(model, mechanism.data, *motion[:3])
    friction = coordinates.project(model.dof_frictionloss * np.sign(motion[1]), slope)
    mass, payload, gravity = {}, {}, np.zeros((len(q), len(model.jnt_type), 3))
    # Compensation of gravity by an actuator is disabled with it, so that it is part of the effort.
    passive = ~model.jnt_actgravcomp.astype(bool)[:, None]
    for group in mechanism.groups:
        place = (frames, group.body, group.chain)
        total, weight = body_columns(*place, motion[1], motion[2], model.opt.gravity)
        own = total @ group.parameters - passive[:, 0] * (weight @ group.compensated)
        mass[group.name] = coordinates.project(own / group.mass, slope)
        payload[group.name] = coordinates.project(total, slope)
        gravity += gravity_columns(*place, group.parameters + group.carried)
        gravity -= passive * gravity_columns(*place, group.compensated)
    by_position = by_velocity = None
    if derivatives:
        by_position = _differences(mechanism, (q, v, a), 0, POSITION_STEP)
        by_velocity = _differences(mechanism, (q, v, a), 1, VELOCITY_STEP)
    inertia = coordinates.project(matrix, slope).transpose(0, 2, 1)
    return Regressors(
        effort=coordinates.project(effort, slope) + friction,
        friction=friction,
        mass_matrix=coordinates.project(inertia, slope),
        mass=mass,
        gravity=coordinates.project(gravity, slope),
        payload=payload,
        position=by_position,
        velocity=by_velocity,
    )


def _differences(
    mechanism: Mechanism, motion: tuple[Floats, Floats, Floats], which: int, step: float
) -> Floats:
    """Return central differences, (T, n, n), of the effort by one of position and velocity."""
    columns = []
    for k in range(mechanism.coordinates.n):
        sides = []
        for sign in (1.0, -1.0):
            moved = [each.copy() for each in motion]
            moved[which][:, k] += sign * step
            sides.append(mechanism.smooth_effort(*moved))
        columns.append((sides[0] - sides[1]) / (2 * step))
    return np.stack(columns, axis=2)
