"""From what a native task lets be seen to a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from trundle._native import Pushing
from trundle.envs.drawing import picture
from trundle.envs.scene import Disc, Shape, View

__all__ = ["draw", "needed"]


def draw(seen: dict[str, Any], trail: Sequence[tuple[float, float]] = ()) -> NDArray[np.uint8]:
    """Draw what a native task lets be seen."""
    fixtures = tuple(
        Disc(tuple(part[0]), part[1]) if isinstance(part, tuple) else tuple(map(tuple, part))
        for part in seen["fixtures"]
    )
    return picture(
        View(
            object=tuple(seen["object"]),
            shape=Shape(fixtures, tuple(map(tuple, seen["wheels"]))),
            goal=tuple(seen["goal"]),
            obstacles=tuple(tuple(map(tuple, polygon)) for polygon in seen["obstacles"]),
            path=tuple(map(tuple, seen["path"])),
            gripper=tuple(seen["gripper"]),
            holds=seen["holds"],
            wrench=tuple(seen["wrench"]),
            trail=tuple(trail),
            arena=Pushing.ARENA,
        )
    )


def needed(value: dict[str, Any] | None) -> dict[str, Any]:
    """Return a value that there is from the first reset on."""
    if value is None:
        raise ResetNeeded("no episode has begun: call reset() first")
    return value
