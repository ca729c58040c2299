"""Errors of the places, times and values of correctly named effects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from trundle.experiments.blind.geometry import region_overlap
from trundle.experiments.blind.score import correct_effects
from trundle.experiments.results import Row

__all__ = ["TARGETS", "parameter_errors", "place_errors"]

TARGETS = {
    "body point, m": ("at most", 0.05),
    "world point, m": ("at most", 0.05),
    "event time, s": ("at most", 0.15),
    "delay, s": ("at most", 0.010),
    "region overlap": ("at least", 0.6),
}
"""Target of each kind of place."""


def place_errors(rows: Sequence[Row]) -> dict[str, list[tuple[str, float]]]:
    """Return (effect, error) by kind of place; the error is infinite if the answer has no place."""
    found: dict[str, list[tuple[str, float]]] = {kind: [] for kind in TARGETS}
    for answer, true in correct_effects(rows):
        where, given = true["where"] or {}, answer["where"] or {}
        for key, kind in (("body_point", "body point, m"), ("world_point", "world point, m")):
            if key in where:
                off = point_error(given.get(key), where[key], where.get("radius", 0.0))
                found[kind].append((true["effect"], off))
        if "event" in where:
            found["event time, s"].append((true["effect"], time_error(given.get("event"), where["event"])))
        if true["effect"] == "latency":
            given_delay = answer["parameters"].get("delay", {}).get("mean", math.inf)
            found["delay, s"].append((true["effect"], abs(given_delay - true["parameters"]["delay"])))
        if "world_region" in where:
            region, cells = given.get("world_region"), answer["_truth"].get("visited", [])
            common = region_overlap(region, where["world_region"], cells) if region else 0.0
            found["region overlap"].append((true["effect"], common))
    return found


def point_error(given: Any, true: Sequence[float], radius: float = 0.0) -> float:
    """Return the distance of a reported point from the surface of a round obstacle, or infinity."""
    if not given or given.get("mean") is None:
        return math.inf
    return abs(math.dist(given["mean"], true) - radius)


def time_error(given: Any, true: Row) -> float:
    """Return the absolute error of a reported time; infinite in another episode."""
    if not given or given["episode"] != true["episode"]:
        return math.inf
    return abs(float(given["time"]["mean"]) - float(true["time"]))


def parameter_errors(rows: Sequence[Row]) -> dict[str, list[tuple[float, float]]]:
    """Return for each `effect.parameter` the relative error, and the error over the standard deviation.

    The error is relative to the norm of all values of the effect with the same unit, because a component of a
    vector may be near zero.
    """
    found: dict[str, list[tuple[float, float]]] = {}
    for answer, true in correct_effects(rows):
        given = answer["parameters"]
        said = {name for name, one in given.items() if one.get("mean") is not None}
        there = {name: value for name, value in true["parameters"].items() if name in said}
        for name, value in there.items():
            alike = [v for other, v in there.items() if given[other].get("unit") == given[name].get("unit")]
            size = float(np.linalg.norm(np.concatenate([np.ravel(v) for v in alike])))
            found.setdefault(f"{true['effect']}.{name}", []).append(
                relative_error(name, given[name], value, size)
            )
    return found


def relative_error(name: str, given: Row, value: Any, size: float) -> tuple[float, float]:
    """Return an error over a size and over the standard deviation; matrices use the norm."""
    off = np.asarray(given["mean"], dtype=float) - np.asarray(value, dtype=float)
    if name == "angle":
        off = np.asarray((off + np.pi / 2) % np.pi - np.pi / 2)
    error, sd = float(np.linalg.norm(off)), given.get("sd")
    spread = float(np.linalg.norm(np.asarray(sd, dtype=float))) if sd is not None else math.nan
    return error / size if size else math.nan, error / spread if spread else math.nan
