"""What each hidden parameter changes: the same push of the same block, one parameter at a time."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np

from trundle.experiments.arena.planner import corners
from trundle.experiments.arena.world import (
    FRICTION_PX_PER_S2,
    MASS,
    NOMINAL,
    OFFSET_PX,
    PHYSICS,
    Hidden,
    make,
)
from trundle.experiments.markdown import table
from trundle.experiments.sampling import Floats

__all__ = ["displacement", "probes"]

START = [180.0, 240.0, 256.0, 256.0, 0.3]
"""Pusher and block, px and rad; the benchmark moves the block a little when it sets the angle."""
TARGET = np.array([260.0, 250.0])
ACTIONS = 15
CASES = {
    "mass": [replace(NOMINAL, mass=one) for one in MASS],
    "floor friction": [replace(NOMINAL, friction=one) for one in FRICTION_PX_PER_S2],
    "centre of mass along the bar": [replace(NOMINAL, offset_x=one) for one in (-OFFSET_PX, OFFSET_PX)],
    "centre of mass along the stem": [replace(NOMINAL, offset_y=one) for one in (-OFFSET_PX, OFFSET_PX)],
}


def final_pose(hidden: Hidden, physics: str) -> Floats:
    """Return the pose of the block (3,) at the end of the push."""
    env = make(physics)
    observation, _ = env.reset(seed=0, options={"reset_to_state": START, "hidden": asdict(hidden)})
    for _ in range(ACTIONS):
        observation = env.step(TARGET)[0]
    pose: Floats = observation[2:]
    return pose


def displacement(hidden: Hidden, physics: str) -> float:
    """Return the mean distance of the block's corners from those of the nominal block after the push, px."""
    apart = corners(final_pose(hidden, physics)) - corners(final_pose(NOMINAL, physics))
    return float(np.linalg.norm(apart, axis=-1).mean())


def probes() -> str:
    """Return the table of displacements at the ends of each parameter's range."""
    rows = []
    for name, ends in CASES.items():
        found = [" and ".join(f"{displacement(one, physics):.1f}" for one in ends) for physics in PHYSICS]
        rows.append([name, *found])
    return table(["changed to the ends of its range", *(f"{one}, px" for one in PHYSICS)], rows)
