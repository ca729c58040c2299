"""Pictures of the state of a native environment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from trundle._native import Pushing
from trundle.envs.drawing import picture
from trundle.envs.scene import Disc, HiddenWheel, Point, Shape, View

__all__ = ["draw", "require_episode"]


def draw(
    state: dict[str, Any], trail: Sequence[Point] = (), hidden: dict[str, Any] | None = None
) -> NDArray[np.uint8]:
    """Draw the visible state of a native environment, and the wheels of a hidden model if given."""
    fixtures = tuple(
        Disc(tuple(part[0]), part[1]) if isinstance(part, tuple) else tuple(map(tuple, part))
        for part in state["fixtures"]
    )
    return picture(
        View(
            object=tuple(state["object"]),
            shape=Shape(fixtures, tuple(map(tuple, state["wheels"]))),
            goal=tuple(state["goal"]),
            obstacles=tuple(tuple(map(tuple, polygon)) for polygon in state["obstacles"]),
            path=tuple(map(tuple, state["path"])),
            gripper=tuple(state["gripper"]),
            holds=state["holds"],
            wrench=tuple(state["wrench"]),
            trail=tuple(trail),
            arena=Pushing.ARENA,
            revealed=_wheels(hidden or {}),
        )
    )


def _wheels(hidden: dict[str, Any]) -> tuple[HiddenWheel, ...]:
    """Return the viscous wheels of a model, with their friction along and across."""
    wheels = [effect for effect in hidden.get("effect", ()) if effect["kind"] == "viscous_wheel"]
    return tuple((w["x"], w["y"], w["angle"], f"{w['mu_x']:.0f}, {w['mu_y']:.0f}") for w in wheels)


def require_episode(value: dict[str, Any] | None) -> dict[str, Any]:
    """Return `value`, or raise `ResetNeeded` if it is None because no episode has begun."""
    if value is None:
        raise ResetNeeded("no episode has begun: call reset() first")
    return value
