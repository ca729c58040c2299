"""Score answers against the truth: names, ties, wrong names, intervals and gain."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import chain, product
from typing import Any

from trundle.experiments.blind.oracle import misfit

__all__ = [
    "GROUPS",
    "Row",
    "candidates",
    "case_group",
    "coverage",
    "has_wrong_name",
    "is_right",
    "named_probabilities",
    "relative_gain",
]

Row = dict[str, Any]

MAX_TIE = 3
"""Largest number of tied sets in a correct answer."""
CERTAIN_PROBABILITY = 0.9
"""Probability above which a name counts as certain."""
Z90 = 1.644854
"""Half width of a two-sided 90 % interval in standard deviations."""
GROUPS = ("one effect", "two effects", "three effects", "four effects", "clean", "out of catalogue")


def case_group(truth: Row) -> str:
    """Return the member of `GROUPS` of a case."""
    if truth["outside"]:
        return "out of catalogue"
    return ("clean", "one effect", "two effects", "three effects", "four effects")[len(truth["names"])]


def candidates(answer: Row) -> set[frozenset[str]]:
    """Return the sets of effects of an answer: the named set, and the sets tied with it."""
    if answer["verdict"] != "explained":
        return set()
    names = [str(one["effect"]) for one in answer["missing"]]
    tied = [[tie for tie in answer["tied"] if name in tie] for name in names]
    choices = [{name, *chain(*ties)} for name, ties in zip(names, tied, strict=True)]
    found = {frozenset(chosen) for chosen in product(*choices)}
    for classes in answer.get("tied_sets", []):
        sets = {frozenset(one) for one in classes}
        found |= sets if frozenset(names) in sets else set()
    return found


def is_right(answer: Row, truth: Row) -> bool:
    """Return whether an answer is the exact set or a small tie that contains it, or the correct verdict."""
    if truth["outside"]:
        return bool(answer["verdict"] == "unexplained")
    if not truth["names"]:
        return bool(answer["verdict"] == "consistent")
    found = candidates(answer)
    return len(found) <= MAX_TIE and frozenset(truth["names"]) in found


def named_probabilities(answer: Row, truth: Row) -> list[tuple[float, bool]]:
    """Return for each name its probability, and whether it or a tied effect is present."""
    if answer["verdict"] != "explained":
        return []
    true = set() if truth["outside"] else set(truth["names"])
    found = []
    for one in answer["missing"]:
        ties = [tie for tie in answer["tied"] if one["effect"] in tie and len(tie) <= MAX_TIE]
        near = {one["effect"], *chain(*ties)}
        found.append((float(one["probability"]), bool(near & true)))
    return found


def has_wrong_name(answer: Row, truth: Row) -> bool:
    """Return whether a certain name is not in the recording."""
    return any(
        probability > CERTAIN_PROBABILITY and not right
        for probability, right in named_probabilities(answer, truth)
    )


def relative_gain(answer: Row, truth: Row) -> float | None:
    """Return the logarithmic held-out gain one second ahead, relative to the oracle's."""
    oracle, held_out = truth["oracle"], answer.get("held_out") or {}
    if oracle.get("after") is None or not {"before", "after"} <= held_out.keys():
        return None
    before, after = (misfit(held_out[when], truth["gyration"]) for when in ("before", "after"))
    if not (math.isfinite(before) and math.isfinite(after) and after > 0.0):
        return None
    return math.log(before / after) / math.log(oracle["before"] / oracle["after"])


DIRECT = {
    "mass_change": ("mass",),
    "swinging_load": ("mass",),
    "gripper_inertia": ("mass",),
    "com_offset": ("com_x", "com_y"),
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


def coverage(answer: Row, truth: Row) -> Iterator[tuple[str, bool]]:
    """Yield (effect, whether the 90 % interval contains the truth) for each interval with a known truth.

    Intervals of named effects are scored if the answer is correct. The mass of the object is scored if it was
    not given.
    """
    if not truth["names"] and answer["verdict"] == "consistent":
        yield from mass_interval(answer, truth, "before")
    if not is_right(answer, truth) or truth["outside"] or not truth["names"]:
        return
    yield from mass_interval(answer, truth, "after")
    for true in truth["truth"]:
        for one in answer["missing"]:
            if one["effect"] == true["effect"]:
                yield from effect_intervals(one, true)


def mass_interval(answer: Row, truth: Row, when: str) -> Iterator[tuple[str, bool]]:
    """Yield the interval of the object's mass."""
    found = ((answer.get("nominal") or {}).get(when) or {}).get("mass")
    if not truth["mass_told"] and found is not None and "swinging_load" not in truth["names"]:
        yield from check_interval("mass of the object", found.get("mean"), found.get("sd"), truth["mass"])


def effect_intervals(one: Row, true: Row) -> Iterator[tuple[str, bool]]:
    """Yield the intervals of one effect."""
    effect = one["effect"]
    for name in DIRECT.get(effect, ()):
        given = (one["parameters"] or {}).get(name) or {}
        if name in true["parameters"]:
            yield from check_interval(effect, given.get("mean"), given.get("sd"), true["parameters"][name])
    where = one["where"] or {}
    for key in PLACES.get(effect, ()):
        given, place = where.get(key) or {}, (true["where"] or {}).get(key)
        if place is not None and given.get("mean") is not None and given.get("sd") is not None:
            for mean, sd, value in zip(given["mean"], given["sd"], place, strict=True):
                yield from check_interval(effect, mean, sd, value)


def check_interval(effect: str, mean: Any, sd: Any, value: float) -> Iterator[tuple[str, bool]]:
    """Yield whether an interval contains a value, if there is an interval."""
    if mean is not None and sd is not None:
        yield effect, abs(mean - value) <= Z90 * sd
