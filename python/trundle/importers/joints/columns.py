"""Columns of a recording of joints: `q_elbow`, `effort_elbow`, and others."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np

from trundle.importers.config import MapError
from trundle.importers.units import UNITS

__all__ = ["ANGULAR", "HELD", "HELD_SOURCES", "UNITS_OF", "Kind", "known", "split_column"]

Kind = Literal["q", "v", "effort", "target", "known", "on", "load"]
"""Kind of a column: the first part of its name."""

POSITION = UNITS["angle"] | UNITS["length"]
SPEED = {f"{name}/s": size for name, size in POSITION.items()} | {"rpm": 2.0 * np.pi / 60.0}
EFFORT = UNITS["torque"] | UNITS["force"]
UNITS_OF: dict[Kind, dict[str, float]] = {
    "q": POSITION,
    "v": SPEED,
    "effort": EFFORT,
    "target": POSITION,
    "known": EFFORT,
    "on": UNITS["ratio"],
    "load": UNITS["ratio"],
}
"""Units of each kind; without a unit a value is not converted."""
ANGULAR: tuple[Kind, ...] = ("q", "v", "target")
"""Kinds of columns that a log may have in degrees."""
HELD_SOURCES = ("commanded", "voltage")
"""Sources of an effort whose value holds until the next sample."""
HELD: tuple[Kind, ...] = ("target", "on")
"""Kinds of columns whose value holds until the next sample."""


def split_column(column: str, joints: Sequence[str], where: str) -> tuple[Kind, str]:
    """Return kind and joint of a column such as "effort_elbow".

    Raises
    ------
    MapError
        If the kind or the joint is unknown.
    """
    for kind in UNITS_OF:
        if column.startswith(f"{kind}_"):
            joint = column.removeprefix(f"{kind}_")
            if joint not in joints:
                raise MapError(f"`{where}.{column}`: unknown joint {joint!r}; {known(joints)}")
            return kind, joint
    columns = ", ".join(f"{kind}_JOINT" for kind in UNITS_OF)
    raise MapError(f"`{where}.{column}`: unknown column; the columns of joints are {columns}")


def known(joints: Iterable[str]) -> str:
    """Return the end of a message about an unknown joint."""
    return f"the joints are {', '.join(joints)}"
