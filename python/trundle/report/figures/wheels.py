"""Wheels of the simulation under test on the map of the object, at their fitted or given positions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.picture import place_outline
from trundle.report.figures.top_view import TopView
from trundle.report.series import Array, finite
from trundle.report.svg import Markup

__all__ = ["Wheel", "draw", "known_wheels"]

_LENGTH, _WIDTH = 20.0, 8.0
"""Size on the page, user units."""
_EFFECT = "viscous_wheel"


@dataclass(frozen=True)
class Wheel:
    """A wheel: position (2,), m, and angle of its rolling direction, rad, object frame."""

    position: Array
    angle: float


def known_wheels(nominal: Mapping[str, Any]) -> list[Wheel]:
    """Return the wheels with identified or given positions, from the fit with the effects if there is one."""
    values = {**(nominal.get("given") or {}), **(nominal.get("after") or nominal.get("before") or {})}
    names = [name.removesuffix(".x") for name in values if name.startswith(_EFFECT) and name.endswith(".x")]
    wheels = []
    for name in names:
        x, y, angle = (_identified_value(values.get(f"{name}.{key}")) for key in ("x", "y", "angle"))
        if x is not None and y is not None:
            wheels.append(Wheel(np.array([x, y]), 0.0 if angle is None else angle))
    return wheels


def draw(view: TopView, wheel: Wheel, style: str = "wheel") -> Markup | None:
    """Return the outline of a wheel in top view; its long side is the rolling direction."""
    half = 0.5 * np.array([_LENGTH, _WIDTH]) / view.scale
    corners = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return view.outline(place_outline(corners, np.array([*wheel.position, wheel.angle])), style)


def _identified_value(value: Any) -> float | None:
    if isinstance(value, Mapping):
        return None if value.get("identifiable") is False else finite(value.get("mean"))
    return finite(value)
