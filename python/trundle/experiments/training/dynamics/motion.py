"""Observed motion as inputs and targets of a dynamics model, all in axes of the object."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.belief import about_origin
from trundle.envs.observation import Observation
from trundle.experiments.sampling import Floats

__all__ = ["INPUTS", "SHAPE", "TARGETS", "Motion", "motion_of", "object_axes", "shape_of"]


INPUTS, TARGETS, SHAPE = 9, 6, 4
"""Numbers of entries of an input, of a target, and of the shape of an object."""


class Motion(NamedTuple):
    """Steps between successive observations.

    Attributes
    ----------
    inputs : ndarray, shape (steps, n, INPUTS)
        Twist at the start of the step (m/s, rad/s), and the measured wrenches at its start and at its end
        about the object's origin (N, N m).
    targets : ndarray, shape (steps, n, TARGETS)
        Change of the twist, and displacement (m, rad), both in the axes at the start of the step.
    """

    inputs: Floats
    targets: Floats


def motion_of(observations: Floats) -> Motion:
    """Return the steps between observations of shape (steps + 1, n, entries)."""
    seen = Observation(observations)
    heading = seen.heading
    wrench = np.moveaxis(about_origin(np.moveaxis(seen.wrench, -1, 0), np.moveaxis(seen.grasp, -1, 0)), 0, -1)
    before = object_axes(seen.twist[:-1], heading[:-1])
    after = object_axes(seen.twist[1:], heading[:-1])
    turn = np.diff(heading, axis=0)
    moved = np.concatenate([np.diff(seen.position, axis=0), wrapped(turn)[..., None]], axis=-1)
    inputs = np.concatenate([before, wrench[:-1], wrench[1:]], axis=-1)
    return Motion(inputs, np.concatenate([after - before, object_axes(moved, heading[:-1])], axis=-1))


def shape_of(observations: Floats) -> Floats:
    """Return half the sides of the bounding box and its middle, m; shape (..., SHAPE)."""
    seen = Observation(observations)
    return np.concatenate([seen.half_size, seen.middle], axis=-1)


def object_axes(vectors: Floats, heading: Floats) -> Floats:
    """Return planar vectors with a third entry, shape (..., 3), in axes with a heading (...)."""
    cos, sin = np.cos(heading), np.sin(heading)
    x, y, turn = np.moveaxis(vectors, -1, 0)
    return np.stack([cos * x + sin * y, cos * y - sin * x, turn], axis=-1)


def wrapped(angle: Floats) -> Floats:
    """Return the same angles in [-pi, pi]."""
    return np.asarray(angle - 2 * np.pi * np.round(angle / (2 * np.pi)))
