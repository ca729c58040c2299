"""Draw cases of furniture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trundle.experiments.blind.case import Generator, PlannedCase, draw_case
from trundle.experiments.blind.family import HiddenEffect, Values
from trundle.experiments.blind.furniture.families import FAMILIES
from trundle.experiments.blind.furniture.scene import draw_scene
from trundle.experiments.blind.furniture.simulation import Motion, make_recording, simulate
from trundle.experiments.blind.readings import visited_cells
from trundle.experiments.blind.scene import Scene

__all__ = ["draw", "simulate_case"]


def draw_effects(
    planned: PlannedCase, attempt: int, scene: Scene, bare: Sequence[Motion]
) -> list[HiddenEffect] | None:
    """Return the hidden effects with their values; None if an effect does not fit this scene."""
    paths = [one.pose for one in bare]
    hidden = []
    for k, name in enumerate(planned.names):
        values = FAMILIES[name].draw(np.random.default_rng([planned.seed, attempt, 3, k]), scene, paths)
        if not values:
            return None
        hidden.append(HiddenEffect(FAMILIES[name], values))
    return hidden


def simulate_case(scene: Scene, hidden: Sequence[HiddenEffect]) -> list[Motion]:
    """Return the motions of all episodes."""
    return [simulate(scene, hidden, k) for k in range(len(scene.pushes))]


def describe(
    planned: PlannedCase, scene: Scene, hidden: Sequence[HiddenEffect], seen: Sequence[Motion]
) -> Values:
    """Return the size and the values of the effect, for further simulations, and the visited floor."""
    found: Values = {"size": planned.size, "values": [one.values for one in hidden]}
    if "floor_patch" in planned.names:
        found["visited"] = visited_cells(scene, [one.pose for one in seen])
    return found


GENERATOR = Generator(
    draw_scene=lambda planned, attempt, options: draw_scene(
        planned.seed, attempt, options["episodes"], alike=options["alike"]
    ),
    draw_effects=draw_effects,
    simulate=simulate_case,
    is_usable=lambda bare: True,
    record=make_recording,
    describe=describe,
)


def draw(planned: Values, options: Values, folder: Path) -> dict[str, Any]:
    """Draw a case, write its recording, and return the truth."""
    return draw_case(GENERATOR, PlannedCase(**{**planned, "names": tuple(planned["names"])}), options, folder)
