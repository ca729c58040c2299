"""The wheels of the simulation under test on the map of the object, as they were fitted or given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.report.figures.plan import Plan, placed
from trundle.report.given import Array, finite
from trundle.report.markup import Html

__all__ = ["Wheel", "draw", "fitted"]

_LENGTH, _WIDTH = 20.0, 8.0
"""Size on the page, user units."""
_KIND = "viscous_wheel"


@dataclass(frozen=True)
class Wheel:
    """A wheel: its place (2,) m and the angle of its rolling direction, rad, object frame."""

    place: Array
    angle: float


def fitted(nominal: Mapping[str, Any]) -> list[Wheel]:
    """Return the wheels whose places the data hold, with the effects where there are any."""
    values = {**(nominal.get("given") or {}), **(nominal.get("after") or nominal.get("before") or {})}
    names = [name.removesuffix(".x") for name in values if name.startswith(_KIND) and name.endswith(".x")]
    wheels = []
    for name in names:
        x, y, angle = (_known(values.get(f"{name}.{key}")) for key in ("x", "y", "angle"))
        if x is not None and y is not None:
            wheels.append(Wheel(np.array([x, y]), 0.0 if angle is None else angle))
    return wheels


def draw(plan: Plan, wheel: Wheel) -> Html | None:
    """Return a wheel seen from above, long along its rolling direction."""
    half = 0.5 * np.array([_LENGTH, _WIDTH]) / plan.scale
    corners = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return plan.outline(placed(corners, np.array([*wheel.place, wheel.angle])), "wheel")


def _known(value: Any) -> float | None:
    if isinstance(value, Mapping):
        return None if value.get("identifiable") is False else finite(value.get("mean"))
    return finite(value)
