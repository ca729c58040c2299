"""The sets of robots that a benchmark of mechanisms draws from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from trundle.experiments.blind.mechanism.robots import Robot

__all__ = ["ROBOT_SETS", "robots_of"]

ROBOT_SETS = ("own", "wheels")
"""Names: built-in robots, and those of published packages."""


def robots_of(names: Sequence[str]) -> list[Robot]:
    """Return the robots of several sets."""
    from trundle.experiments.blind.mechanism.robots import ROBOTS  # needs MuJoCo
    from trundle.experiments.blind.mechanism.wheels import read_robots

    found = [*ROBOTS.values()] if "own" in names else []
    return [*found, *read_robots().values()] if "wheels" in names else found
