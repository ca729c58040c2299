"""Score answers against the truth: names, ties, wrong names, probabilities and gain."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain, product

from trundle.experiments.blind.families import INDISTINGUISHABLE_PAIRS
from trundle.experiments.blind.oracle import misfit
from trundle.experiments.results import Row

__all__ = [
    "CERTAIN_PROBABILITY",
    "GROUPS",
    "candidates",
    "case_group",
    "has_wrong_name",
    "hidden_label",
    "is_at_right_place",
    "is_right",
    "is_unambiguous",
    "named_effects",
    "named_probabilities",
    "names_of",
    "relative_gain",
]

MAX_TIE = 3
"""Largest number of tied sets in a correct answer."""
CERTAIN_PROBABILITY = 0.9
"""Probability above which a name counts as certain."""
GROUPS = ("one effect", "two effects", "three effects", "four effects", "clean", "out of catalogue")


def case_group(truth: Row) -> str:
    """Return the member of `GROUPS` of a case."""
    if truth["outside"]:
        return "out of catalogue"
    return ("clean", "one effect", "two effects", "three effects", "four effects")[len(truth["names"])]


def names_of(answer: Row) -> list[str]:
    """Return the named effects."""
    return [str(one["effect"]) for one in answer.get("missing", [])]


def hidden_label(truth: Row) -> str:
    """Return the hidden effects as one label."""
    return " + ".join(truth["names"]) or "nothing"


def max_tie(truth: Row) -> float:
    """Return the largest number of tied sets in a correct answer to a case."""
    most = truth.get("max_tie", MAX_TIE)
    return math.inf if most is None else float(most)


def candidates(answer: Row) -> set[frozenset[str]]:
    """Return the sets of effects of an answer: the named set, and the sets tied with it."""
    if answer["verdict"] != "explained":
        return set()
    names = names_of(answer)
    choices = [{name, *chain(*(tie for tie in answer["tied"] if name in tie))} for name in names]
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
        # Given masses of a mechanism may be off: then refitting them is the correct answer.
        correct = ("consistent", "reparameterised") if "robot" in truth else ("consistent",)
        return answer["verdict"] in correct
    found = candidates(answer)
    return len(found) <= max_tie(truth) and frozenset(truth["names"]) in found


def is_unambiguous(answer: Row, truth: Row) -> bool:
    """Return whether an answer is correct and has no tie except the indistinguishable pair."""
    return is_right(answer, truth) and all(
        INDISTINGUISHABLE_PAIRS[0].issuperset(tie) for tie in answer["tied"]
    )


def named_probabilities(answer: Row, truth: Row) -> list[tuple[float, bool]]:
    """Return for each name its probability, and whether it or a tied effect is present."""
    if answer["verdict"] != "explained":
        return []
    true = set() if truth["outside"] else set(truth["names"])
    found = []
    for one in answer["missing"]:
        ties = [tie for tie in answer["tied"] if one["effect"] in tie and len(tie) <= max_tie(truth)]
        found.append((float(one["probability"]), bool({one["effect"], *chain(*ties)} & true)))
    return found


def has_wrong_name(answer: Row, truth: Row) -> bool:
    """Return whether a certain name is not in the recording."""
    found = named_probabilities(answer, truth)
    return any(probability > CERTAIN_PROBABILITY and not right for probability, right in found)


def named_effects(rows: Sequence[Row]) -> Iterator[tuple[Row, Row, Row]]:
    """Yield (part of the answer, truth of the effect, truth of the case) for names of correct answers."""
    for row in rows:
        truth, answer = row["truth"], row["answer"]
        if truth["names"] and not truth["outside"] and is_right(answer, truth):
            for true in truth["truth"]:
                parts = [one for one in answer["missing"] if one["effect"] == true["effect"]]
                yield from ((one, true, truth) for one in parts)


def relative_gain(answer: Row, truth: Row) -> float | None:
    """Return the logarithmic held-out gain one second ahead, relative to the oracle's if there is one."""
    oracle, held_out = truth["oracle"], answer.get("held_out") or {}
    if "robot" in truth:
        return relative_effort_gain(held_out, truth)
    has_oracle = truth["names"] and not truth["outside"] and oracle.get("after") is not None
    if not has_oracle or not {"before", "after"} <= held_out.keys():
        return None
    before, after = (misfit(held_out[when], truth["gyration"]) for when in ("before", "after"))
    if not (math.isfinite(before) and math.isfinite(after) and after > 0.0):
        return None
    return math.log(before / after) / math.log(oracle["before"] / oracle["after"])


def relative_effort_gain(held_out: Row, truth: Row) -> float | None:
    """Return the logarithmic held-out gain in effort of a mechanism, relative to the oracle's."""
    figures = [
        float((held_out.get(when) or {}).get("relative_effort_rmse") or 0.0) for when in ("before", "after")
    ]
    if not truth["names"] or truth["outside"] or not all(figures):
        return None
    oracle = truth["oracle"]
    return math.log(figures[0] / figures[1]) / math.log(oracle["before"] / oracle["after"])


def is_at_right_place(answer: Row, truth: Row) -> list[bool]:
    """Return for each rightly named effect of a mechanism whether its joint or body is the true one."""
    if answer["verdict"] != "explained" or truth["outside"]:
        return []
    true = {one["effect"]: one["where"] for one in truth["truth"]}
    named = [one for one in answer["missing"] if true.get(one["effect"])]
    return [one["where"] == true[one["effect"]] for one in named]
