"""Models of an object before any observation of its motion."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import tomli_w
from numpy.typing import NDArray

from trundle._native import Model
from trundle.picture import outlines

__all__ = ["bounding_box", "freely_rolling_model", "locked_corner_models", "uniform_model"]

Array: TypeAlias = NDArray[np.float64]

LOCKED_WHEEL_DRAG = 150.0
"""Drag of the locked wheel in a probing agent's first models, N s/m."""
SUSPECT_MARGIN = 0.85
"""Positions of suspected wheels, as a share of half the sides of the bounding box."""


def freely_rolling_model(description: dict[str, Any], mass: float) -> Model:
    """Return the model of a uniform object that rolls freely; see `uniform_model`."""
    return uniform_model(description, mass, [])


def uniform_model(description: dict[str, Any], mass: float, effects: list[dict[str, Any]]) -> Model:
    """Return the model of an object of uniform density with effects.

    Parameters
    ----------
    description : dict
        The table ``object`` of a recording.
    mass : float
        Mass, kg, if the description contains none.
    effects : list of dict
        Tables of ``model.toml``.
    """
    body = {key: description[key] for key in ("footprint", "fixture", "support") if description.get(key)}
    body["mass"] = description.get("mass", mass)
    return Model.from_toml(tomli_w.dumps({"format": "trundle-model/1", "body": body, "effect": effects}))


def locked_corner_models(description: dict[str, Any], mass: float) -> tuple[Model, ...]:
    """Return four models, each with a locked wheel near one corner of the object."""
    middle, half = bounding_box(description)
    wheel = {"kind": "viscous_wheel", "angle": 0.0, "mu_x": LOCKED_WHEEL_DRAG, "mu_y": LOCKED_WHEEL_DRAG}
    ways = ((-1, -1), (-1, 1), (1, -1), (1, 1))
    places = [middle + SUSPECT_MARGIN * half * np.array(way) for way in ways]
    wheels = [{**wheel, "x": float(x), "y": float(y)} for x, y in places]
    return tuple(uniform_model(description, mass, [one]) for one in wheels)


def bounding_box(description: dict[str, Any]) -> tuple[Array, Array]:
    """Return middle and half sides of the bounding box of an object, shape (2,) each, object frame, m."""
    points = np.concatenate(outlines(description))
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, (high - low) / 2
