"""Tables of the answers after one more push."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from trundle.experiments.blind.follow_up import (
    DESIGNED,
    RANDOM_SIMILAR,
    RANDOM_UNRESTRICTED,
    requested_experiment,
)
from trundle.experiments.blind.score import hidden_label, is_right, is_unambiguous, named_probabilities
from trundle.experiments.markdown import table
from trundle.experiments.results import Row
from trundle.experiments.statistics import share

__all__ = [
    "ANY_CONTROL",
    "Case",
    "all_cases",
    "by_effect",
    "case_counts",
    "cases_of",
    "efforts",
    "initially_tied",
    "is_sure",
    "pairs",
    "rates",
]

SURE_PROBABILITY = 0.95
BEFORE = "none"
ANY_CONTROL = (
    ". Because those have low excitation, a second control has a random grasp, position and heading and "
    "rotates the object. It ignores the limits on motion that the design takes from the recording"
)
"""Sentence about the second control."""

Case = Mapping[str, Row]
"""Rows of one recording by the added push; `BEFORE` is the original recording."""


def cases_of(first: Sequence[Row], rows: Sequence[Row]) -> list[Case]:
    """Return the cases for which every kind of push was diagnosed."""
    kinds = {row["push"] for row in rows}
    found: dict[str, dict[str, Row]] = {}
    for row in rows:
        found.setdefault(row["case"], {})[row["push"]] = row
    before = {row["case"]: row for row in first}
    return [{BEFORE: before[case], **of} for case, of in found.items() if of.keys() == kinds]


def kinds_of(cases: Sequence[Case]) -> list[str]:
    """Return the kinds of pushes, in order."""
    return [kind for kind in (DESIGNED, RANDOM_SIMILAR, RANDOM_UNRESTRICTED) if cases and kind in cases[0]]


def case_counts(first: Sequence[Row], cases: Sequence[Case]) -> str:
    """Return a sentence with the numbers of ambiguous answers and of requested pushes."""
    answers = [row["answer"] for row in first if row["answer"]["verdict"] == "explained"]
    tied = [answer for answer in answers if answer["tied"]]
    silent = sum(requested_experiment(answer) is None for answer in tied)
    asked = [(answer, found) for answer in answers if (found := requested_experiment(answer))]
    counts = Counter(found["pushes"][0]["profile"] for _, found in asked)
    courses = ", ".join(f"`{name}` {count}" for name, count in counts.most_common()) or "none"
    return (
        f"{len(first)} recordings, {len(answers)} explained, {len(tied)} of these with a tie. For {silent} "
        "of the ties no discriminating push within the motion of the recording was found. "
        f"{len(asked)} answers request a push, {sum(bool(answer['tied']) for answer, _ in asked)} of them "
        f"with a tie ({courses}). All kinds of pushes were simulated and diagnosed for {len(cases)} of them."
        f"{expected_success(asked)}"
    )


def expected_success(asked: Sequence[tuple[Row, Row]]) -> str:
    """Return a sentence with the probability of a decision that the designs predict."""
    if not asked:
        return ""
    chance = np.mean([found["sure"] for _, found in asked])
    return f" The designs predict a decision in {100 * chance:.0f} %, if one of their two models is true."


def initially_tied(cases: Sequence[Case]) -> list[Case]:
    """Return the cases that were tied before the push."""
    return [case for case in cases if case[BEFORE]["answer"]["tied"]]


def rates(cases: Sequence[Case]) -> str:
    """Return by push how often the correct name is alone, alone with high probability, tied, or missing."""
    lines = [[kind, *rate_cells([case[kind] for case in cases])] for kind in (BEFORE, *kinds_of(cases))]
    alone = ["correct name alone", f"with probability ≥ {SURE_PROBABILITY}", "in a tie", "other answer"]
    head = ["push added", *alone, "tied names"]
    return table(head, lines)


def rate_cells(rows: Sequence[Row]) -> list[str]:
    """Return the columns of `rates`."""
    right = [
        (is_unambiguous(row["answer"], row["truth"]), is_right(row["answer"], row["truth"])) for row in rows
    ]
    return [
        share(alone for alone, _ in right).text(),
        share(is_sure(row) for row in rows).text(),
        share(there and not alone for alone, there in right).text(),
        share(not there for _, there in right).text(),
        f"{np.mean([remaining_names(row['answer']) for row in rows]):.2f}" if rows else "–",
    ]


def remaining_names(answer: Row) -> int:
    """Return the largest number of tied names of one effect; zero if nothing is named."""
    return max((len(tie_of(one["effect"], answer)) for one in answer["missing"]), default=0)


def is_sure(row: Row) -> bool:
    """Return whether the correct name is alone with high probability.

    The probability includes that of its indistinguishable twin.
    """
    answer = row["answer"]
    tied = {name for tie in answer["tied"] for name in tie}
    twins = sum(one["probability"] for one in answer["alternatives"] if one["effect"] in tied)
    probabilities = [p + twins for p, _ in named_probabilities(answer, row["truth"])]
    return is_unambiguous(answer, row["truth"]) and min(probabilities, default=0.0) >= SURE_PROBABILITY


def pairs(cases: Sequence[Case]) -> str:
    """Return on how many recordings only one of two pushes decides."""
    lines = []
    counted: dict[str, Callable[[Row], bool]] = {
        "correct name alone": lambda row: is_unambiguous(row["answer"], row["truth"]),
        f"with probability ≥ {SURE_PROBABILITY}": is_sure,
    }
    for what, reached in counted.items():
        for other in (BEFORE, *kinds_of(cases)[1:]):
            both = [(reached(case[DESIGNED]), reached(case[other])) for case in cases]
            differ = [mine for mine, its in both if mine != its]
            lines.append(
                [what, other, str(sum(differ)), str(len(differ) - sum(differ)), share(differ).text()]
            )
    head = ["figure", "other push", "only the designed", "only the other", "designed, where they differ"]
    return table(head, lines)


def efforts(cases: Sequence[Case]) -> str:
    """Return the effort of the pushes by kind."""
    names = {"force": "largest force, N", "distance": "distance, m", "turn": "rotation, rad"}
    lines = []
    for kind in kinds_of(cases):
        took = [case[kind]["answer"]["effort"] for case in cases]
        lines.append([kind, *(f"{np.median([one[name] for one in took]):.2g}" for name in names)])
    return table(["push", *names.values()], lines)


def by_effect(cases: Sequence[Case]) -> str:
    """Return how often the correct name is alone, by hidden effect."""
    lines = []
    for hidden in sorted({hidden_label(case[BEFORE]["truth"]) for case in cases}):
        mine = [case for case in cases if hidden_label(case[BEFORE]["truth"]) == hidden]
        counts = [
            sum(is_unambiguous(case[kind]["answer"], case[kind]["truth"]) for case in mine)
            for kind in (BEFORE, *kinds_of(cases))
        ]
        lines.append([hidden, str(len(mine)), *map(str, counts)])
    return table(["hidden effect", "recordings", "alone before", *kinds_of(cases)], lines)


def all_cases(cases: Sequence[Case]) -> str:
    """Return every case: hidden effects, request, and all answers."""
    lines = []
    for case in cases:
        experiment = requested_experiment(case[BEFORE]["answer"]) or {
            "models": [],
            "pushes": [{"profile": "–"}],
        }
        push = f"{' or '.join(experiment['models'])}: `{experiment['pushes'][0]['profile']}`"
        answers = [answer_label(case[kind]["answer"]) for kind in (BEFORE, *kinds_of(cases))]
        lines.append([case[BEFORE]["case"], hidden_label(case[BEFORE]["truth"]), push, *answers])
    return table(["case", "hidden effect", "request", "before", *kinds_of(cases)], lines)


def answer_label(answer: Row) -> str:
    """Return an answer as names with probabilities, with all names of a tie."""
    if answer["verdict"] != "explained":
        return str(answer["verdict"])
    named = [(" = ".join(tie_of(one["effect"], answer)), one["probability"]) for one in answer["missing"]]
    return ", ".join(f"{names} {probability:.3f}" for names, probability in named)


def tie_of(name: str, answer: Row) -> list[str]:
    """Return a name, and the names tied with it."""
    return [name, *(other for tie in answer["tied"] if name in tie for other in tie if other != name)]
