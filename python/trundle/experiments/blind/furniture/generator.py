"""Draw cases of furniture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from trundle.experiments.blind.case import Generator, PlannedCase, draw_case
from trundle.experiments.blind.family import HiddenEffect, Values
from trundle.experiments.blind.furniture.families import FAMILIES
from trundle.experiments.blind.furniture.scene import draw_scene
from trundle.experiments.blind.furniture.simulation import Motion, make_recording, simulate
from trundle.experiments.blind.readings import visited_cells
from trundle.experiments.blind.scene import Scene

__all__ = ["GENERATOR", "draw", "simulate_case"]


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
    families=FAMILIES,
    stream=3,
    paths=lambda family, bare: [one.pose for one in bare],
    is_allowed=lambda name, scene: True,
    simulate=simulate_case,
    is_usable=lambda bare: True,
    record=make_recording,
    describe=describe,
)


def draw(planned: Values, options: Values, folder: Path) -> dict[str, Any]:
    """Draw a case, write its recording, and return the truth."""
    return draw_case(GENERATOR, planned, options, folder)
