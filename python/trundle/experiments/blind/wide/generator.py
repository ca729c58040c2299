"""Draw cases with random outlines, grasps and instruments."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trundle.experiments.blind.case import Generator, PlannedCase, draw_case
from trundle.experiments.blind.family import Family, HiddenEffect, Values
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import Readings
from trundle.experiments.blind.scene import Scene
from trundle.experiments.blind.wide import mujoco_engine, ode_engine
from trundle.experiments.blind.wide.families import FAMILIES, is_allowed
from trundle.experiments.blind.wide.measurement import make_recording
from trundle.experiments.blind.wide.scene import draw_scene
from trundle.experiments.sampling import Floats

__all__ = ["GENERATOR", "draw", "simulate_case"]

MIN_MEDIAN_DISPLACEMENT_M = 0.05
"""Smallest displacement of the object in the median episode."""
MAX_DISPLACEMENT_M, MAX_ROTATION_RAD = 20.0, 60.0
"""Bounds of the workspace."""


def simulate_case(scene: Scene, hidden: Sequence[HiddenEffect]) -> list[Readings]:
    """Return the readings of perfect instruments in every episode."""
    engine = mujoco_engine if scene.engine == "mujoco" else ode_engine
    return [engine.simulate(scene, hidden, k) for k in range(len(scene.pushes))]


def moves_enough(bare: Sequence[Readings]) -> bool:
    """Return whether the object moves enough and stays within the workspace."""
    ways, turns = np.transpose(
        [(np.ptp(one.pose[:, :2], axis=0).max(), np.ptp(one.pose[:, 2])) for one in bare]
    )
    stays = ways.max() < MAX_DISPLACEMENT_M and turns.max() < MAX_ROTATION_RAD
    return bool(np.median(ways) > MIN_MEDIAN_DISPLACEMENT_M and stays)


def paths(family: Family, bare: Sequence[Readings]) -> list[Floats]:
    """Return the poses of each episode from contact on, or the wrenches if the family reads them."""
    contact = int(np.searchsorted(bare[0].t, CONTACT_TIME_S))
    return [one.wrench if family.reads else one.pose[contact:] for one in bare]


def describe(
    planned: PlannedCase, scene: Scene, hidden: Sequence[HiddenEffect], seen: Sequence[Readings]
) -> Values:
    """Return the instrument, the wheel and the episodes."""
    return {
        "instrument": scene.instrument.plain(),
        "wheel": vars(scene.wheel),
        "centroid": scene.shape.centroid.tolist(),
        "episodes": len(scene.seconds),
        "seconds": list(scene.seconds),
        "held_out": scene.held_out,
    }


GENERATOR = Generator(
    draw_scene=lambda planned, attempt, options: draw_scene(planned.seed, attempt, planned.engine),
    families=FAMILIES,
    stream=13,
    paths=paths,
    is_allowed=is_allowed,
    simulate=simulate_case,
    is_usable=moves_enough,
    record=make_recording,
    describe=describe,
)


def draw(planned: Values, options: Values, folder: Path) -> dict[str, Any]:
    """Draw a case, write its recording, and return the truth."""
    return draw_case(GENERATOR, planned, options, folder)
