"""Forward simulation of a black-box simulator with laws at its joints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle.joint_simulator.calls import JointSimulator, Samples
from trundle.joint_simulator.inverse import EffortScale, mass_matrices

if TYPE_CHECKING:
    from trundle.mechanism.drives import Drive
    from trundle.mechanism.simulation import JointLaws

__all__ = ["simulate"]

Floats = NDArray[np.float64]

MAX_STEP_S = 0.002
"""Longest step, s."""
MATRIX_STEPS = 10
"""Steps after which the mass matrix, which shares efforts between inertia and friction, is computed again."""
MAX_SPEED = 1e6
"""Speed, rad/s or m/s, from which a simulation has diverged."""
MAX_SWEEPS = 30
"""Sweeps of the Gauss–Seidel iteration over the dry frictions of all joints."""
SWEEP_TOLERANCE = 1e-6
"""Change of a dry friction, as a share of its level, at which the iteration ends."""


def simulate(
    simulator: JointSimulator,
    values: Mapping[str, float],
    scale: EffortScale,
    episode: str,
    t: Floats,
    start: tuple[ArrayLike, ArrayLike],
    drive: Drive,
    laws: JointLaws | None = None,
    *,
    known: Drive | None = None,
    armature: Floats | None = None,
) -> Floats:
    """Return positions, (T, n), in open loop; NaN after a divergence.

    Parameters
    ----------
    simulator : JointSimulator
    values : mapping of str to float
        Values of its parameters.
    scale : EffortScale
        Of the recording.
    episode : str
        For messages.
    t : (T,) array
        Times of the output, s.
    start : pair of (n,) array_like
        First positions and velocities.
    drive, known : callable
        See `trundle.mechanism.EffortDrive`.
    laws : callable, optional
        Efforts, dry frictions and dampings: see `trundle.mechanism.simulation.JointLaws`.
    armature : (n,) array, optional
        Inertia in addition to that of the simulator.
    """
    q, v = (np.asarray(each, dtype=float) for each in start)
    run = _Simulation(simulator, values, scale, episode, np.r_[q, v], drive, laws, known, armature)
    found = np.full((len(t), simulator.n), np.nan)
    found[0] = q
    for k in range(1, len(t)):
        count = max(1, math.ceil((t[k] - t[k - 1]) / MAX_STEP_S - 1e-9))
        dt = (t[k] - t[k - 1]) / count
        for part in range(count):
            run.advance(float(t[k - 1] + part * dt), float(dt))
        if not (np.isfinite(run.state).all() and np.abs(run.state[simulator.n :]).max() < MAX_SPEED):
            break
        found[k] = run.state[: simulator.n]
    return found


class _Simulation:
    """The state of a simulation."""

    def __init__(
        self,
        simulator: JointSimulator,
        values: Mapping[str, float],
        scale: EffortScale,
        episode: str,
        state: Floats,
        drive: Drive,
        laws: JointLaws | None,
        known: Drive | None,
        armature: Floats | None,
    ) -> None:
        self.simulator, self.values, self.scale, self.episode = simulator, values, scale, episode
        self.state, self.drive, self.laws, self.known = state, drive, laws, known
        self.armature = np.zeros(simulator.n) if armature is None else armature
        self.count = 0
        self.acceleration: Floats | None = None

    def advance(self, t: float, dt: float) -> None:
        """Simulate one step."""
        n = self.simulator.n
        q, v = self.state[:n], self.state[n:]
        effort, damping = self.drive(t, q, v)
        acting = np.zeros(n)
        if self.known is not None:
            exerted, resisted = self.known(t, q, v)
            acting = exerted - resisted * v
        total = effort + acting
        free_state = self.call(t, dt, total)
        if self.laws is None and not damping.any() and not self.armature.any():
            self.state = free_state
            return
        if not np.isfinite(free_state).all():
            self.state = free_state
            return
        free = (free_state[n:] - v) / dt
        matrix = self.mass_matrix(t)
        previous = free if self.acceleration is None else self.acceleration
        added, dry, viscous = np.zeros(n), np.zeros(n), damping
        if self.laws is not None:
            # What the joint transmits: all but the acceleration of its own inertia.
            bias = total - matrix @ free
            load = effort - damping * v - acting + bias + matrix @ previous - np.diag(matrix) * previous
            added, dry, more = self.laws(t, q, v, load)
            viscous = damping + more
        inertia = matrix + np.diag(self.armature + dt * viscous)
        driven = matrix @ free + added - viscous * v
        inverse = np.asarray(np.linalg.inv(inertia), dtype=np.float64)
        self.acceleration = with_dry_friction(inverse, driven, dry, v, dt)
        self.state = self.call(t, dt, total + matrix @ (self.acceleration - free))

    def call(self, t: float, dt: float, effort: Floats) -> Floats:
        """Return the state after a step."""
        samples = Samples(self.episode, t)
        after: Floats = self.simulator.call(self.state[None], effort[None], dt, self.values, samples)[0]
        return after

    def mass_matrix(self, t: float) -> Floats:
        """Return the mass matrix, which is computed once for several steps."""
        if self.count % MATRIX_STEPS == 0:
            n = self.simulator.n
            q, v = self.state[None, :n], self.state[None, n:]
            samples = Samples(self.episode, t)
            self.matrix: Floats = mass_matrices(self.simulator, samples, q, v, self.values, self.scale)[0][0]
        self.count += 1
        return self.matrix


def with_dry_friction(inverse: Floats, driven: Floats, dry: Floats, v: Floats, dt: float) -> Floats:
    """Return accelerations under dry friction that opposes the velocities at the end of a step.

    Parameters
    ----------
    inverse : (n, n) array
        Inverse of the mass matrix.
    driven, dry : (n,) arrays
        Efforts without friction, and levels of friction.
    v : (n,) array
        Velocities at the start.
    dt : float
        s.
    """
    acceleration: Floats = inverse @ driven
    rubbing = np.flatnonzero(dry > 0).tolist()
    friction = [0.0] * len(driven)
    for _ in range(MAX_SWEEPS):
        largest = 0.0
        for j in rubbing:
            level = float(dry[j])
            wanted = friction[j] - float((v[j] + dt * acceleration[j]) / (dt * inverse[j, j]))
            change = min(max(wanted, -level), level) - friction[j]
            friction[j] += change
            acceleration = acceleration + inverse[:, j] * change
            largest = max(largest, abs(change) / level)
        if largest < SWEEP_TOLERANCE:
            break
    return acceleration
