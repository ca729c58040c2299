"""Forward simulation of a mechanism in MuJoCo, with laws at its joints."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle._native import TrundleError
from trundle.mechanism.drives import Drive
from trundle.mechanism.source import import_mujoco, silent_mujoco
from trundle.mechanism.transmissions import SplitModel, Transmission, split_model

if TYPE_CHECKING:
    from trundle.mechanism.model import Mechanism

__all__ = ["FRICTION_SOLIMP", "JointLaws", "simulate"]

Floats = NDArray[np.float64]

MAX_STEP_S = 0.002
"""Largest step of the integration, s. A smaller step of the model is kept."""
FRICTION_SOLIMP = (0.999, 0.9999, 0.001, 0.5, 2.0)
"""Impedance of dry friction. With MuJoCo's default a joint at rest creeps visibly under its load."""
MAX_SPEED = 1e6
"""Speed, rad/s or m/s, from which a simulation has diverged."""


class JointLaws(Protocol):
    """Physics at the recorded joints that the model does not have."""

    def __call__(self, t: float, q: Floats, v: Floats, load: Floats) -> tuple[Floats, Floats, Floats]:
        """Return explicit effort, dry friction and viscous damping, (n,) each.

        Parameters
        ----------
        t : float
            Time, s.
        q, v : (n,) arrays
            State of the recorded joints.
        load : (n,) array
            Transmitted load of the last step: the drive's effort, less what gravity, velocity terms, the
            other joints' accelerations and known efforts exert on the joint.
        """
        ...


def simulate(
    mechanism: Mechanism,
    t: ArrayLike,
    q0: ArrayLike,
    v0: ArrayLike,
    drive: Drive,
    laws: JointLaws | None = None,
    *,
    known: Drive | None = None,
    split: SplitModel | None = None,
    step: float | None = None,
) -> tuple[Floats, Floats]:
    """Simulate a mechanism in open loop.

    MuJoCo's implicit integrator steps the motion. Its constraint solver handles dry friction: joints stick.

    Parameters
    ----------
    mechanism : Mechanism
        With fitted values, see `Mechanism.adjusted`.
    t : (T,) array_like
        Times of the output, s, increasing. The first is that of the initial state.
    q0, v0 : (n,) array_like
        Initial positions and velocities of the recorded joints.
    drive : callable
        See `EffortDrive` and `PositionDrive`.
    laws : callable, optional
        Called at every step with time, positions, velocities and transmitted load; returns efforts, dry
        frictions and dampings that are added to the model's.
    known : callable, optional
        Further known efforts on the joints' side, as a drive.
    split : SplitModel, optional
        The mechanism's model with plays and springs between drives and joints. They begin with the
        deflections of what rigid transmissions would transmit. Positions and velocities are then those at
        the encoders. Drives act on their own side; laws depend on the links' positions and the drives'
        velocities.
    step : float, optional
        Largest step, s; by default the model's, at most 2 ms. Steps are shortened to end at the output times.

    Returns
    -------
    q, v : (T, n) arrays
        If the simulation diverges, all rows from then on are NaN.

    Raises
    ------
    TrundleError
        If times do not increase, or the initial state has another size.

    Examples
    --------
    A slide of 2 kg with a dry friction of 3 N, pushed by 5 N for a second:

    >>> import numpy as np
    >>> from trundle.mechanism import EffortDrive, Mechanism, simulate
    >>> cart = Mechanism.load(
    ...     '<mujoco><worldbody><body><joint name="rail" type="slide" axis="1 0 0"/>'
    ...     '<inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/></body></worldbody></mujoco>',
    ...     ["rail"],
    ... )
    >>> def friction(t, q, v, load):
    ...     return np.zeros(1), np.array([3.0]), np.zeros(1)
    >>> q, v = simulate(cart, [0.0, 1.0], [0.0], [0.0], EffortDrive([0.0], [[5.0]]), friction)
    >>> round(float(v[-1, 0]), 2)
    1.0
    """
    times, q, v = (np.asarray(each, float) for each in (t, q0, v0))
    n = len(mechanism.joints)
    if times.ndim != 1 or not len(times) or not np.all(np.diff(times) > 0):
        raise TrundleError("t: give increasing times in a one-dimensional array")
    if q.shape != (n,) or v.shape != (n,):
        raise TrundleError(f"q0, v0: shapes {q.shape} and {v.shape}; give {n} values, one for each joint")
    longest = min(mechanism.compiled.opt.timestep, MAX_STEP_S) if step is None else step
    split = split or split_model(mechanism, ())
    with silent_mujoco():
        return _Simulation(mechanism, split, times[0], q, v, drive, laws, known, longest).run(times, longest)


class _Simulation:
    """A copy of the model with its state."""

    def __init__(
        self,
        mechanism: Mechanism,
        split: SplitModel,
        start: float,
        q: Floats,
        v: Floats,
        drive: Drive,
        laws: JointLaws | None,
        known: Drive | None,
        longest: float,
    ) -> None:
        self.mujoco = import_mujoco()
        self.model = forward_model(split.compiled, longest)
        self.model.jnt_solref[split.links] = [2 * longest, 1.0]
        self.data = self.mujoco.MjData(self.model)
        self.index = split.index[mechanism.coordinates.index]
        self.links, self.columns = split.links, split.columns
        at_link = np.array([not one.on_drive for one in split.transmissions], dtype=bool)
        self.seen_links, self.seen_columns = self.links[at_link], self.columns[at_link]
        self.drive, self.laws, self.known = drive, laws, known
        self.damping = self.model.dof_damping[self.index].copy()
        self.friction = self.model.dof_frictionloss[self.index].copy()
        self.load = np.zeros(len(q))
        position, velocity, _, _ = mechanism.coordinates.expand(q[None], v[None], 0 * v[None])
        self.data.time = start
        self.data.qpos[split.index], self.data.qvel[split.index] = position[0], velocity[0]
        self.deflect(split.transmissions)
        if laws is not None:
            # A law of the load needs that of the first step.
            self.apply()
            self.mujoco.mj_forward(self.model, self.data)
            self.measure_load()

    def run(self, times: Floats, longest: float) -> tuple[Floats, Floats]:
        """Return positions and velocities at the output times."""
        q, v = (np.full((len(times), len(self.index)), np.nan) for _ in range(2))
        for k in range(len(times)):
            if k > 0:
                self.advance(float(times[k] - times[k - 1]), longest)
            speeds = self.data.qvel
            if not (np.isfinite(self.data.qpos).all() and np.abs(speeds).max() < MAX_SPEED):
                break
            q[k], v[k] = self.measured()
        return q, v

    def deflect(self, transmissions: Sequence[Transmission]) -> None:
        """Begin with the deflections of what rigid transmissions would transmit, and encoders in place."""
        if not transmissions:
            return
        self.apply()
        model, data, links = self.model, self.data, self.links
        self.mujoco.mj_forward(model, data)
        matrix, rigid = np.zeros((model.nv, model.nv)), np.setdiff1d(np.arange(model.nv), links)
        self.mujoco.mj_fullM(model, data, matrix)
        friction = model.dof_frictionloss * np.sign(data.qvel)
        effort = data.qfrc_applied + data.qfrc_passive - data.qfrc_bias - friction
        acceleration = np.linalg.solve(matrix[np.ix_(rigid, rigid)], effort[rigid])
        loads = matrix[np.ix_(links, rigid)] @ acceleration + (data.qfrc_bias - data.qfrc_applied)[links]
        for one, column, link, load in zip(transmissions, self.columns, links, loads, strict=True):
            found = one.deflection(float(load))
            data.qpos[link] = found
            if not one.on_drive:
                data.qpos[self.index[column]] -= found

    def measured(self) -> tuple[Floats, Floats]:
        """Return positions and velocities at the encoders."""
        q, v = self.data.qpos[self.index], self.data.qvel[self.index]
        q[self.seen_columns] += self.data.qpos[self.seen_links]
        v[self.seen_columns] += self.data.qvel[self.seen_links]
        return q, v

    def advance(self, duration: float, longest: float) -> None:
        """Simulate a duration in equal steps."""
        count = max(1, math.ceil(duration / longest - 1e-9))
        self.model.opt.timestep = duration / count
        for _ in range(count):
            self.apply()
            self.mujoco.mj_step(self.model, self.data)
            if self.laws is not None:
                self.measure_load()

    def apply(self) -> None:
        """Apply drive and laws at the present state."""
        t, (q, v) = self.data.time, self.measured()
        effort, damping = self.drive(t, q, v)
        self.driven = effort - damping * v
        self.acting = np.zeros(len(q))
        if self.known is not None:
            exerted, resisted = self.known(t, q, v)
            self.acting = exerted - resisted * v
        total, dry, viscous = effort + self.acting, self.friction, self.damping + damping
        if self.laws is not None:
            joints = self.data.qpos[self.index]
            joints[self.columns] += self.data.qpos[self.links]
            added, friction, more = self.laws(t, joints, self.data.qvel[self.index], self.load)
            total, dry, viscous = total + added, np.maximum(dry + friction, 0.0), viscous + more
            at_links = self.acting + added
        else:
            at_links = self.acting
        self.data.qfrc_applied[self.index] = total
        # What acts on a link moves both the drive and the transmission.
        self.data.qfrc_applied[self.links] = at_links[self.columns]
        self.model.dof_frictionloss[self.index] = dry
        self.model.dof_damping[self.index] = viscous

    def measure_load(self) -> None:
        """Compute the load that the joints transmitted in the last step."""
        model, data = self.model, self.data
        inertial, column, unit = (np.zeros(model.nv) for _ in range(3))
        self.mujoco.mj_mulM(model, data, inertial, data.qacc)
        for k in self.index:
            unit[k] = 1.0
            self.mujoco.mj_mulM(model, data, column, unit)
            unit[k] = 0.0
            own = [k, *self.links[self.index[self.columns] == k]]
            inertial[k] -= column[own] @ data.qacc[own]
        self.load = self.driven - self.acting + (data.qfrc_bias + inertial)[self.index]


def forward_model(compiled: Any, longest: float) -> Any:
    """Return a copy of a mechanism's model for forward simulation."""
    mujoco = import_mujoco()
    model, bits = copy.copy(compiled), mujoco.mjtDisableBit
    model.opt.disableflags &= ~int(bits.mjDSBL_FRICTIONLOSS | bits.mjDSBL_EQUALITY)
    model.opt.disableflags |= int(bits.mjDSBL_AUTORESET)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model.dof_solref[:] = [2 * longest, 1.0]
    model.dof_solimp[:] = FRICTION_SOLIMP
    return model
