"""Limits of designed trajectories: as recorded, or as given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trundle._native import TrundleError

__all__ = ["GivenLimits", "JointLimits", "parse_limits"]

JointValue = float | Mapping[str, float]
"""One value for all joints, or values by joint."""


@dataclass(frozen=True)
class JointLimits:
    """Limits of a joint.

    Attributes
    ----------
    joint : str
    low, high : float
        Range of the positions, rad or m.
    speed, acceleration, effort : float
        Largest values.
    slowest : float
        Speed below which samples are not compared.
    is_effort_given : bool
        Whether the user gave the effort, which then holds with every load.
    """

    joint: str
    low: float
    high: float
    speed: float
    acceleration: float
    effort: float
    slowest: float
    is_effort_given: bool = False


@dataclass(frozen=True)
class GivenLimits:
    """Limits that the user gave: see `trundle.design`."""

    position: Mapping[str, tuple[float, float]] | None = None
    speed: JointValue | None = None
    acceleration: JointValue | None = None
    effort: JointValue | None = None


def parse_limits(recorded: Sequence[Mapping[str, Any]], given: GivenLimits) -> list[JointLimits]:
    """Return the limits of all joints: as recorded, except for those that are given.

    Raises
    ------
    TrundleError
        If a joint is unknown, a limit is not positive or a range is empty.
    """
    names = [one["joint"] for one in recorded]
    positions = given.position or {}
    speeds, accelerations, efforts = (
        _by_joint(key, getattr(given, key), names) for key in ("speed", "acceleration", "effort")
    )
    _check_joints("position", positions, names)
    found = []
    for one in recorded:
        joint = one["joint"]
        low, high = positions.get(joint, one["position"])
        if not (np.isfinite([low, high]).all() and low < high):
            raise TrundleError(f"position: {joint} = ({low}, {high}): give a lower and a higher position")
        own = JointLimits(
            joint, low, high, one["speed"], one["acceleration"], one["effort"], one["rest_speed"]
        )
        changes: dict[str, Any] = {
            key: values[joint]
            for key, values in (("speed", speeds), ("acceleration", accelerations), ("effort", efforts))
            if joint in values
        }
        found.append(replace(own, **changes, is_effort_given=joint in efforts))
    return found


def _by_joint(key: str, value: JointValue | None, names: Sequence[str]) -> dict[str, float]:
    if value is None:
        return {}
    values = dict(value) if isinstance(value, Mapping) else dict.fromkeys(names, value)
    _check_joints(key, values, names)
    for joint, limit in values.items():
        if not (np.isfinite(limit) and limit > 0):
            raise TrundleError(f"{key}: {joint} = {limit}: a limit must be positive")
    return {joint: float(limit) for joint, limit in values.items()}


def _check_joints(key: str, values: Mapping[str, Any], names: Sequence[str]) -> None:
    for joint in values:
        if joint not in names:
            raise TrundleError(f"{key}: unknown joint {joint!r}; the recorded joints are {', '.join(names)}")
