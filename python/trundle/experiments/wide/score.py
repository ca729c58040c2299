"""Answers against truth: names, ties, wrong names, intervals and gain."""

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
"""Sets of effects that a tie may hold to count as right."""
CERTAIN_PROBABILITY = 0.9
"""Above which probability a name must be right."""
Z90 = 1.644854
"""Of a two-sided interval of 90 %."""
GROUPS = ("one effect", "two effects", "three effects", "four effects", "clean", "out of catalogue")


def case_group(truth: Row) -> str:
    """Return which of `GROUPS` a case is in."""
    if truth["outside"]:
        return "out of catalogue"
    return ("clean", "one effect", "two effects", "three effects", "four effects")[len(truth["names"])]


def candidates(answer: Row) -> set[frozenset[str]]:
    """Return the sets of effects that an answer gives: the one it names, and those tied with it."""
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
    """Tell whether an answer is the exact set or a small tie that holds it, or the right verdict."""
    if truth["outside"]:
        return bool(answer["verdict"] == "unexplained")
    if not truth["names"]:
        return bool(answer["verdict"] == "consistent")
    found = candidates(answer)
    return len(found) <= MAX_TIE and frozenset(truth["names"]) in found


def named_probabilities(answer: Row, truth: Row) -> list[tuple[float, bool]]:
    """Return for each name given its probability, and whether it is in the recording or tied with what is."""
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
    """Tell whether a name is given that is not in the recording, with a probability above `CERTAIN_PROBABILITY`."""
    return any(
        probability > CERTAIN_PROBABILITY and not right
        for probability, right in named_probabilities(answer, truth)
    )


def relative_gain(answer: Row, truth: Row) -> float | None:
    """Return what the answer gained one second ahead on held-out episodes over the oracle's, in logarithm."""
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
    """Yield (effect, whether the 90 % interval holds the truth) for each interval that can be judged.

    Of effects that are named and in the recording, where no name is wrong or missing; and of the mass
    of the object where it was not given, which counts under "mass of the object".
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
    """Yield whether an interval holds a value, if there is an interval."""
    if mean is not None and sd is not None:
        yield effect, abs(mean - value) <= Z90 * sd
