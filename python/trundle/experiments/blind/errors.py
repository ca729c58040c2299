"""Errors of the places, times and values of correctly named effects, and coverage of their intervals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from trundle.experiments.blind.outline import region_overlap
from trundle.experiments.blind.score import is_right, named_effects
from trundle.experiments.results import Row

__all__ = ["PLACE_TARGETS", "coverage", "meets_target", "parameter_errors", "place_errors"]

PLACE_TARGETS = {
    "body point, m": ("at most", 0.05),
    "world point, m": ("at most", 0.05),
    "event time, s": ("at most", 0.15),
    "delay, s": ("at most", 0.010),
    "region overlap": ("at least", 0.6),
}
"""Target of each kind of place."""
Z90 = 1.644854
"""Half width of a two-sided 90 % interval in standard deviations."""
DIRECT = {
    "mass_change": ("mass",),
    "swinging_load": ("mass",),
    "gripper_inertia": ("mass",),
    "com_offset": ("com_x", "com_y"),
    "mass_spread": ("inertia_factor",),
    "coulomb_friction": ("force",),
    "force_bias": ("force_x", "force_y"),
    "latency": ("delay",),
}
"""Parameters with a direct counterpart: mass, mass centre, force, delay."""
PLACES = {
    "coulomb_friction": ("body_point",),
    "caster_swivel": ("body_point",),
    "swinging_load": ("body_point",),
    "tether": ("body_point", "world_point"),
}
"""Places whose intervals are scored."""


def meets_target(kind: str, value: float) -> bool:
    """Return whether the error of a place meets its target."""
    direction, limit = PLACE_TARGETS[kind]
    return value <= limit if direction == "at most" else value >= limit


def place_errors(rows: Sequence[Row]) -> dict[str, list[tuple[str, float]]]:
    """Return (effect, error) by kind of place; the error is infinite if the answer has no place."""
    found: dict[str, list[tuple[str, float]]] = {kind: [] for kind in PLACE_TARGETS}
    for answer, true, truth in named_effects(rows):
        effect, where, given = true["effect"], true["where"] or {}, answer["where"] or {}
        for key, kind in (("body_point", "body point, m"), ("world_point", "world point, m")):
            if key in where:
                off = point_error(given.get(key), where[key], where.get("radius", 0.0))
                found[kind].append((effect, off))
        if "event" in where:
            found["event time, s"].append((effect, time_error(given.get("event"), where["event"])))
        if effect == "latency":
            delay = answer["parameters"].get("delay", {}).get("mean", math.inf)
            found["delay, s"].append((effect, abs(delay - true["parameters"]["delay"])))
        if "world_region" in where:
            region, cells = given.get("world_region"), truth.get("visited", [])
            common = region_overlap(region, where["world_region"], cells) if region else 0.0
            found["region overlap"].append((effect, common))
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
    for answer, true, _ in named_effects(rows):
        given = {name: one for name, one in answer["parameters"].items() if one.get("mean") is not None}
        known = {name: value for name, value in true["parameters"].items() if name in given}
        for name, value in known.items():
            same = [v for other, v in known.items() if given[other].get("unit") == given[name].get("unit")]
            size = float(np.linalg.norm(np.concatenate([np.ravel(v) for v in same])))
            errors = found.setdefault(f"{true['effect']}.{name}", [])
            errors.append(relative_error(name, given[name], value, size))
    return found


def relative_error(name: str, given: Row, value: Any, size: float) -> tuple[float, float]:
    """Return an error over a size and over the standard deviation; matrices use the norm."""
    off = np.asarray(given["mean"], dtype=float) - np.asarray(value, dtype=float)
    if name == "angle":
        off = np.asarray((off + np.pi / 2) % np.pi - np.pi / 2)
    error, sd = float(np.linalg.norm(off)), given.get("sd")
    spread = float(np.linalg.norm(np.asarray(sd, dtype=float))) if sd is not None else math.nan
    return error / size if size else math.nan, error / spread if spread else math.nan


def coverage(row: Row) -> Iterator[tuple[str, bool]]:
    """Yield (effect, whether the 90 % interval contains the truth) for each interval with a known truth.

    Intervals of named effects are scored if the answer is correct. The mass of the object is scored if it was
    not given.
    """
    answer, truth = row["answer"], row["truth"]
    if not is_right(answer, truth) or truth["outside"]:
        return
    nominal = (answer.get("nominal") or {}).get("after" if truth["names"] else "before") or {}
    if not truth["mass_told"] and "swinging_load" not in truth["names"]:
        yield from check_interval("mass of the object", nominal.get("mass"), truth["mass"])
    for one, true, _ in named_effects([row]):
        effect, where = true["effect"], true["where"] or {}
        for name in DIRECT.get(effect, ()):
            given = (one["parameters"] or {}).get(name)
            yield from check_interval(effect, given, true["parameters"].get(name))
        for key in PLACES.get(effect, ()):
            yield from check_interval(effect, (one["where"] or {}).get(key), where.get(key))


def check_interval(effect: str, given: Row | None, value: Any) -> Iterator[tuple[str, bool]]:
    """Yield whether each interval contains its value, if there are intervals and values."""
    mean, sd = (given or {}).get("mean"), (given or {}).get("sd")
    if mean is not None and sd is not None and value is not None:
        held = np.abs(np.subtract(mean, value)) <= Z90 * np.asarray(sd)
        yield from ((effect, bool(one)) for one in np.atleast_1d(held))
