"""Braking of an object that is about to exceed the speed limits of the environment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from trundle._native import Pushing
from trundle.envs.observation import Observation

__all__ = ["braking_action", "exceeds_limits_soon"]

Array: TypeAlias = NDArray[np.float64]

MAX_TWIST = np.array([Pushing.TOP_SPEED, Pushing.TOP_SPEED, Pushing.TOP_SPIN])
"""Speed (m/s, twice) and spin (rad/s) above which an episode fails."""
LOOKAHEAD_STEPS = 2
"""Number of actions over which the present acceleration is extrapolated."""


def exceeds_limits_soon(observations: Sequence[Observation], delay_steps: float = 0.0) -> bool:
    """Return whether the extrapolated motion exceeds `MAX_TWIST`.

    The acceleration is that between the last two observations. It is zero if there is only one. The rule uses
    no model of the object.

    Parameters
    ----------
    observations : sequence of Observation
        One or more observations of an episode, the latest last.
    delay_steps : float
        Delay of the next command in periods, by which the motion is extrapolated further.
    """
    now, before = observations[-1].twist, observations[-2 if len(observations) > 1 else -1].twist
    vx, vy, spin = now + (LOOKAHEAD_STEPS + delay_steps) * (now - before)
    return bool(np.hypot(vx, vy) > MAX_TWIST[0] or abs(spin) > MAX_TWIST[2])


def braking_action(observation: Observation) -> Array:
    """Return the action that opposes the motion of the grasp point; it dissipates energy of any object.

    Returns
    -------
    ndarray, shape (3,)
        Force x, force y and torque, object axes, as shares of a full action; not clipped.
    """
    (vx, vy, spin), (cos, sin), (x, y) = observation.twist, observation.direction, observation.grasp
    forward, sideways = cos * vx + sin * vy, cos * vy - sin * vx
    action: Array = -np.array([forward - spin * y, sideways + spin * x, spin]) / MAX_TWIST
    return action
