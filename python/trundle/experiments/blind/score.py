"""Answers against truth: names, abstention, probabilities, and what a fit gained."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import permutations
from typing import Any

from trundle.experiments.blind.oracle import misfit
from trundle.experiments.results import Row

__all__ = [
    "INDISTINGUISHABLE_PAIR",
    "confusion_label",
    "has_wrong_name",
    "is_false_alarm",
    "is_right",
    "is_unambiguous",
    "is_unexplained",
    "match_names",
    "matches",
    "named_probabilities",
    "relative_gain",
]


INDISTINGUISHABLE_PAIR = frozenset({"com_offset", "tracker_offset"})
"""One motion of one rigid body: as a rule no push tells them apart (docs/diagnosis.md)."""


def matches(named: str, true: str, tied: Sequence[Sequence[str]]) -> bool:
    """Tell whether a name is the true one, or is said to be one that the data cannot tell from it."""
    return named == true or any(named in group and true in group for group in tied)


def match_names(answer: Row, names: Sequence[str]) -> list[Row] | None:
    """Return for each true name the part of the answer that names it; None unless all are, and no other."""
    missing, tied = answer["missing"], answer["tied"]
    if answer["verdict"] != "explained" or len(missing) != len(names):
        return None
    for order in permutations(missing):
        if all(matches(one["effect"], name, tied) for one, name in zip(order, names, strict=True)):
            return list(order)
    return None


def is_right(answer: Row, truth: Row) -> bool:
    """Tell whether an answer is what it should be: the names, "consistent", or "unexplained"."""
    if not truth["names"]:
        return bool(answer["verdict"] == "consistent")
    if truth["foreign"]:
        return is_unexplained(answer)
    return match_names(answer, truth["names"]) is not None


def is_unambiguous(answer: Row, truth: Row) -> bool:
    """Tell whether an answer is what it should be, and leaves no tie but that of the twins."""
    return is_right(answer, truth) and all(
        INDISTINGUISHABLE_PAIR.issuperset(group) for group in answer["tied"]
    )


def is_false_alarm(answer: Row) -> bool:
    """Tell whether something is said to be missing."""
    return answer["verdict"] in ("explained", "unexplained")


def is_unexplained(answer: Row) -> bool:
    """Tell whether something is said to be missing that has no name."""
    return bool(answer["verdict"] == "unexplained")


def has_wrong_name(answer: Row, truth: Row, above: float = 0.9) -> bool:
    """Tell whether a name is given that is not in the recording, with a probability above `above`."""
    return any(probability > above and not right for probability, right in named_probabilities(answer, truth))


def named_probabilities(answer: Row, truth: Row) -> list[tuple[float, bool]]:
    """Return for each name given its probability, and whether it is in the recording."""
    if answer["verdict"] != "explained":
        return []
    return [
        (
            float(one["probability"]),
            any(matches(one["effect"], name, answer["tied"]) for name in truth["names"]),
        )
        for one in answer["missing"]
    ]


def confusion_label(answer: Row, truth: Row) -> str:
    """Return an answer in a word for the confusion matrix; a tie that holds the true name counts as it."""
    if answer["verdict"] != "explained":
        return str(answer["verdict"])
    if len(answer["missing"]) > 1:
        return "several"
    (name,) = (one["effect"] for one in answer["missing"])
    return next((true for true in truth["names"] if matches(name, true, answer["tied"])), str(name))


def relative_gain(answer: Row, truth: Row) -> float | None:
    """Return what the answer's model gained one second ahead on held-out episodes over the oracle's.

    Both in logarithm; the oracle knows the law and fits it. None where there is no oracle.
    """
    oracle, held_out = truth["oracle"], answer.get("held_out")
    if not truth["names"] or truth["foreign"] or not held_out or oracle.get("after") is None:
        return None
    before, after = (misfit(held_out[when], truth["gyration"]) for when in ("before", "after"))
    if not (math.isfinite(before) and math.isfinite(after)):
        return None
    return math.log(before / after) / math.log(oracle["before"] / oracle["after"])


def correct_effects(rows: Sequence[Row], name: str | None = None) -> list[tuple[Row, Row]]:
    """Return (part of the answer, truth of the effect) of every effect that was named rightly."""
    pairs: list[tuple[Row, Row]] = []
    for row in rows:
        truth, answer = row["truth"], row["answer"]
        if not truth["names"] or truth["foreign"]:
            continue
        given = match_names(answer, truth["names"])
        both: list[tuple[Any, Any]] = list(zip(given or [], truth["truth"], strict=False))
        exact = [(one, true) for one, true in both if one["effect"] == true["effect"]]
        pairs += [({**one, "_truth": truth}, true) for one, true in exact if name in (None, true["effect"])]
    return pairs
