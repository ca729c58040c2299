"""Efforts that a black-box simulator needs for a motion, from short steps of it.

With h the effort at zero acceleration and M the mass matrix, an effort τ accelerates a smooth mechanism by
a = M⁻¹(τ − h). One step without effort and one for each joint give h and M at a state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.joint_simulator.calls import JointSimulator, Samples

__all__ = [
    "EffortScale",
    "InverseDynamics",
    "accelerations",
    "effort_scale",
    "inverse_dynamics",
    "mass_matrices",
]

Floats = NDArray[np.float64]
Values = Mapping[str, float]

STEP_S = 2e-4
"""Step, s. Two steps of different length remove the first-order error of any integrator."""
MAX_PROBES = 20
"""Samples that determine the size of the efforts."""
MAX_ASYMMETRY = 0.05
"""Difference of opposite entries of the scaled mass matrix from which efforts are in another order."""
MIN_RESPONSE = 1e-4
"""Singular value of the scaled response below which friction of the simulator holds a joint."""
MAX_NONLINEARITY = 0.01
"""Error of the effort, as a share of the joint's rms effort, from which a sample counts as not linear."""
MAX_NONLINEAR_SHARE = 0.1
"""Share of samples that may be not linear in the effort."""
MAX_CORRECTIONS = 3
"""Corrections of efforts where the simulator is not linear in them."""
MIN_SPEED_SHARE = 0.05
"""Speed, as a share of the joint's rms speed, from which a joint moves."""


@dataclass(frozen=True)
class EffortScale:
    """Sizes of accelerations, (n,), and of the efforts that cause them."""

    acceleration: Floats
    effort: Floats


@dataclass(frozen=True)
class InverseDynamics:
    """What a simulator needs at T samples.

    Attributes
    ----------
    effort : (T, n) array
    mass_matrix : (T, n, n) array
    nonlinear_share : float
        Share of the samples in motion at which the simulator is not linear in the effort.
    """

    effort: Floats
    mass_matrix: Floats
    nonlinear_share: float


def accelerations(
    simulator: JointSimulator, samples: Samples, q: Floats, v: Floats, efforts: Floats, values: Values
) -> Floats:
    """Return the accelerations, (T, n), that efforts cause."""
    states, n = np.hstack((q, v)), simulator.n
    ends = []
    for dt in (STEP_S, STEP_S / 2):
        ends.append(simulator.step(states, efforts, dt, values, samples))
        _check_duration(simulator, samples, q, v, ends[-1], dt)
    whole, half = ends
    return np.asarray((4.0 * (half[:, n:] - v) - (whole[:, n:] - v)) / STEP_S)


def _check_duration(
    simulator: JointSimulator, samples: Samples, q: Floats, v: Floats, after: Floats, dt: float
) -> None:
    """Refuse a simulator that advances by another duration, or whose positions jump."""
    n = simulator.n
    moved, expected = after[:, :n] - q, dt * v
    slack = dt * (0.1 * np.abs(v) + 2.0 * np.abs(after[:, n:] - v)) + 1e-6 * (1.0 + np.abs(q))
    wrong = np.argwhere(np.abs(moved - expected) > slack)
    if len(wrong):
        row, k = wrong[0]
        raise TrundleError(
            f"step: {samples[row]}: joint {simulator.joints[k]} moves by {moved[row, k]:.3g} within "
            f"dt = {dt} s at velocity {v[row, k]:.3g}, but {expected[row, k]:.3g} was expected; advance "
            "by exactly dt, with an internal time step of at most dt, and do not wrap angles"
        )


def effort_scale(
    simulator: JointSimulator, samples: Samples, q: Floats, v: Floats, a: Floats, values: Values
) -> EffortScale:
    """Return the efforts that accelerate each joint about as much as its motion.

    Raises
    ------
    TrundleError
        If a joint does not respond to its effort, or the same arguments give different states.
    """
    rows = np.unique(np.linspace(0, len(q) - 1, MAX_PROBES).astype(int))
    samples, q, v = samples.rows(rows), q[rows], v[rows]
    zero = np.zeros_like(q)
    rest, again = (accelerations(simulator, samples, q, v, zero, values) for _ in range(2))
    if not np.array_equal(rest, again):
        raise TrundleError(
            f"step: {samples[0]}: the same arguments give different states; the function must not keep a "
            "state or draw random numbers"
        )
    size = np.sqrt(np.mean(a**2, axis=0))
    size[size == 0] = 1.0
    efforts = np.ones(simulator.n)
    for k, joint in enumerate(simulator.joints):
        unit = zero.copy()
        unit[:, k] = 1.0
        change = accelerations(simulator, samples, q, v, unit, values)[:, k] - rest[:, k]
        response = float(np.median(change))
        if not response > 0.0:
            raise TrundleError(
                f"step: {samples[0]}: an effort of 1 at joint {joint} changes its acceleration by "
                f"{response:.3g}; effort[{k}] must accelerate joint {joint} in the direction of its position"
            )
        efforts[k] = size[k] / response
    return EffortScale(size, efforts)


def mass_matrices(
    simulator: JointSimulator, samples: Samples, q: Floats, v: Floats, values: Values, scale: EffortScale
) -> tuple[Floats, Floats]:
    """Return mass matrices, (T, n, n), and accelerations without effort, (T, n)."""
    zero = np.zeros_like(q)
    rest = accelerations(simulator, samples, q, v, zero, values)
    columns = []
    for k in range(simulator.n):
        effort = zero.copy()
        effort[:, k] = scale.effort[k]
        change = accelerations(simulator, samples, q, v, effort, values) - rest
        columns.append(change / scale.acceleration)
    # A joint that the simulator's own friction holds does not respond: it is left out of the inverse.
    inverse = np.linalg.pinv(np.stack(columns, axis=2), rcond=MIN_RESPONSE)
    matrices = scale.effort[:, None] * inverse / scale.acceleration
    return matrices, rest


def inverse_dynamics(
    simulator: JointSimulator,
    samples: Samples,
    q: Floats,
    v: Floats,
    a: Floats,
    values: Values,
    scale: EffortScale,
) -> InverseDynamics:
    """Return the efforts that the simulator needs for a motion, (T, n) each.

    Raises
    ------
    TrundleError
        If accelerations are not linear in the efforts at many samples in motion.
    """
    matrices, rest = mass_matrices(simulator, samples, q, v, values, scale)
    effort = np.einsum("tij,tj->ti", matrices, a - rest)
    size = np.maximum(np.sqrt(np.mean(effort**2, axis=0)), scale.effort)
    moves = (np.abs(v) > MIN_SPEED_SHARE * np.sqrt(np.mean(v**2, axis=0))).all(axis=1)
    wrong = np.ones(len(q), dtype=bool)
    share = 0.0
    for correction in range(MAX_CORRECTIONS + 1):
        rows = np.flatnonzero(wrong)
        found = accelerations(simulator, samples.rows(rows), q[rows], v[rows], effort[rows], values)
        missing = np.einsum("tij,tj->ti", matrices[rows], a[rows] - found)
        is_off = np.abs(missing) > MAX_NONLINEARITY * size
        effort[rows] += missing
        wrong[rows] = is_off.any(axis=1)
        if correction == 0:
            share = _nonlinear_share(simulator, samples, wrong & moves, is_off, int(moves.sum()))
        if not wrong.any():
            break
    _check_order(simulator, samples, matrices, scale)
    return InverseDynamics(effort, matrices, share)


def _check_order(simulator: JointSimulator, samples: Samples, matrices: Floats, scale: EffortScale) -> None:
    """Refuse efforts that act on other joints than those that move: the mass matrix is then not symmetric."""
    root = np.sqrt(scale.effort / scale.acceleration)
    scaled = np.median(matrices, axis=0) / np.outer(root, root)
    difference = np.abs(scaled - scaled.T)
    row, column = np.unravel_index(np.argmax(difference), difference.shape)
    if difference[row, column] > MAX_ASYMMETRY:
        first, second = simulator.joints[row], simulator.joints[column]
        raise TrundleError(
            f"step: episode {samples.episode}: the efforts of joints {first} and {second} act differently on "
            "each other, as in no mechanism; return positions and velocities in the order "
            f"{', '.join(simulator.joints)}, relative to the parent body, and apply efforts in this order"
        )


def _nonlinear_share(
    simulator: JointSimulator,
    samples: Samples,
    wrong: NDArray[np.bool_],
    is_off: NDArray[np.bool_],
    moving: int,
) -> float:
    share = float(wrong.sum()) / max(moving, 1)
    if share > MAX_NONLINEAR_SHARE:
        row = int(np.flatnonzero(wrong)[0])
        joint = simulator.joints[int(np.argmax(is_off[row]))]
        raise TrundleError(
            f"step: {samples[row]}: the acceleration of joint {joint} is not linear in the effort, as at "
            f"{100 * share:.0f} % of the samples in motion; remove limits of efforts, hard contacts and "
            "static friction from the simulator (friction of the sign of the velocity may stay)"
        )
    return share
