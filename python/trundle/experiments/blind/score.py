"""Score answers against the truth: names, abstention, probabilities, and gain."""

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
"""Effects that in general no push distinguishes (docs/diagnosis.md): one motion of one rigid body."""


def matches(named: str, true: str, tied: Sequence[Sequence[str]]) -> bool:
    """Return whether a name is the true one or tied with it."""
    return named == true or any(named in group and true in group for group in tied)


def match_names(answer: Row, names: Sequence[str]) -> list[Row] | None:
    """Return the part of the answer for each true name; None unless the answer names exactly these."""
    missing, tied = answer["missing"], answer["tied"]
    if answer["verdict"] != "explained" or len(missing) != len(names):
        return None
    for order in permutations(missing):
        if all(matches(one["effect"], name, tied) for one, name in zip(order, names, strict=True)):
            return list(order)
    return None


def is_right(answer: Row, truth: Row) -> bool:
    """Return whether an answer is correct: the names, "consistent", or "unexplained"."""
    if not truth["names"]:
        return bool(answer["verdict"] == "consistent")
    if truth["foreign"]:
        return is_unexplained(answer)
    return match_names(answer, truth["names"]) is not None


def is_unambiguous(answer: Row, truth: Row) -> bool:
    """Return whether an answer is correct and has no tie except the indistinguishable pair."""
    return is_right(answer, truth) and all(
        INDISTINGUISHABLE_PAIR.issuperset(group) for group in answer["tied"]
    )


def is_false_alarm(answer: Row) -> bool:
    """Return whether an answer reports a missing effect."""
    return answer["verdict"] in ("explained", "unexplained")


def is_unexplained(answer: Row) -> bool:
    """Return whether an answer reports a missing effect without a name."""
    return bool(answer["verdict"] == "unexplained")


def has_wrong_name(answer: Row, truth: Row, above: float = 0.9) -> bool:
    """Return whether a name with a probability above `above` is not in the recording."""
    return any(probability > above and not right for probability, right in named_probabilities(answer, truth))


def named_probabilities(answer: Row, truth: Row) -> list[tuple[float, bool]]:
    """Return for each name its probability, and whether it is in the recording."""
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
    """Return an answer as a label of the confusion matrix; a tie with the true name counts as that name."""
    if answer["verdict"] != "explained":
        return str(answer["verdict"])
    if len(answer["missing"]) > 1:
        return "several"
    (name,) = (one["effect"] for one in answer["missing"])
    return next((true for true in truth["names"] if matches(name, true, answer["tied"])), str(name))


def relative_gain(answer: Row, truth: Row) -> float | None:
    """Return the held-out gain of the answer's model one second ahead relative to the oracle's.

    Both are logarithms of ratios of misfits. None without an oracle.
    """
    oracle, held_out = truth["oracle"], answer.get("held_out")
    if not truth["names"] or truth["foreign"] or not held_out or oracle.get("after") is None:
        return None
    before, after = (misfit(held_out[when], truth["gyration"]) for when in ("before", "after"))
    if not (math.isfinite(before) and math.isfinite(after)):
        return None
    return math.log(before / after) / math.log(oracle["before"] / oracle["after"])


def correct_effects(rows: Sequence[Row], name: str | None = None) -> list[tuple[Row, Row]]:
    """Return (part of the answer, truth of the effect) of every correctly named effect."""
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
