"""Holding back an object that is about to be lost."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from trundle._native import Pushing
from trundle.envs.observation import Observation

__all__ = ["braking", "runs_away"]

Array: TypeAlias = NDArray[np.float64]

LOST = np.array([Pushing.TOP_SPEED, Pushing.TOP_SPEED, Pushing.TOP_SPIN])
"""Speed along an axis (m/s) and spin (rad/s) of an object that is lost."""
AHEAD = 2
"""Actions for which an object may go on to speed up as it does without being lost."""


def runs_away(seen: Sequence[Observation]) -> bool:
    """Tell whether an object is lost soon if it goes on to speed up as it does; no model is asked."""
    now, before = seen[-1].twist, seen[-2 if len(seen) > 1 else -1].twist
    vx, vy, spin = now + AHEAD * (now - before)
    return bool(np.hypot(vx, vy) > LOST[0] or abs(spin) > LOST[2])


def braking(observation: Observation) -> Array:
    """Return the action that resists the motion of the grasp: it takes energy out of any object."""
    (vx, vy, spin), (cos, sin), (x, y) = observation.twist, observation.direction, observation.grasp
    forward, sideways = cos * vx + sin * vy, cos * vy - sin * vx
    action: Array = -np.array([forward - spin * y, sideways + spin * x, spin]) / LOST
    return action
