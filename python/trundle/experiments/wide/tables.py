"""Tables of the wide benchmark's page."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from trundle.experiments.markdown import table
from trundle.experiments.statistics import Share, calibration, share
from trundle.experiments.wide import reliability
from trundle.experiments.wide.score import (
    GROUPS,
    Row,
    candidates,
    case_group,
    coverage,
    has_wrong_name,
    is_right,
    named_probabilities,
    relative_gain,
)

__all__ = [
    "accuracy",
    "costs",
    "effects",
    "instruments",
    "intervals",
    "probabilities",
    "rejections",
    "wrong_answers",
]

TARGETS = {
    "one effect": 0.95,
    "two effects": 0.85,
    "three effects": 0.7,
    "out of catalogue": 0.9,
    "clean": 0.99,
}
ENGINES = ("mujoco", "ode")
CLASSES: dict[str, Callable[[Row], str]] = {
    "rate of poses": lambda i: str(i["rate_class"]),
    "pose noise": lambda i: str(i["noise_class"]),
    "axes of the reading": lambda i: str(i["frame"]),
    "contact": lambda i: str(i["contact"]),
}


def right_share(rows: Sequence[Row]) -> Share:
    """Return the share of correct answers."""
    return share(is_right(row["answer"], row["truth"]) for row in rows)


def of_group(rows: Sequence[Row], name: str) -> list[Row]:
    """Return the rows of a group."""
    return [row for row in rows if case_group(row["truth"]) == name]


def accuracy(rows: Sequence[Row]) -> str:
    """Return the targets and results, also by engine."""
    lines = []
    for name in GROUPS:
        mine = of_group(rows, name)
        engines = [
            right_share([row for row in mine if row["truth"]["engine"] == one]).text() for one in ENGINES
        ]
        target = f"≥ {TARGETS[name]:.0%}" if name in TARGETS else "–"
        lines.append([name, target, right_share(mine).text(), *engines])
    wrong = share(has_wrong_name(row["answer"], row["truth"]) for row in rows)
    lines.append(["a wrong name above 0.9, of all recordings", "≤ 1%", wrong.text(), "", ""])
    gains = [one for row in rows if (one := relative_gain(row["answer"], row["truth"])) is not None]
    lines.append(
        ["gain at least 0.8 of the oracle's", "≥ 90%", share(one >= 0.8 for one in gains).text(), "", ""]
    )
    sizes = [
        len(candidates(row["answer"]))
        for row in rows
        if row["truth"]["names"] and not row["truth"]["outside"] and is_right(row["answer"], row["truth"])
    ]
    text = f"Mean number of tied sets in correct answers: {np.mean(sizes):.2f} (1: no tie)." if sizes else ""
    return table(["figure", "target", "result", *ENGINES], lines) + "\n\n" + text


def instruments(rows: Sequence[Row]) -> str:
    """Return correct answers by class of instrument."""
    lines = []
    kinds = {"clean": ("clean",), "effects": GROUPS[:4], "out of catalogue": ("out of catalogue",)}
    for label, of in CLASSES.items():
        for value in sorted({of(row["truth"]["instrument"]) for row in rows}):
            mine = [row for row in rows if of(row["truth"]["instrument"]) == value]
            shares = [
                right_share([row for row in mine if case_group(row["truth"]) in names]).text()
                for names in kinds.values()
            ]
            wrong = share(has_wrong_name(row["answer"], row["truth"]) for row in mine)
            lines.append([label, value, *shares, wrong.text()])
    return table(["class", "value", *kinds, "wrong name above 0.9"], lines)


def effects(rows: Sequence[Row]) -> str:
    """Return the answers by single hidden effect."""
    lines = []
    for name in ("one effect", "out of catalogue"):
        mine = of_group(rows, name)
        for effect in sorted({row["truth"]["names"][0] for row in mine}):
            some = [row for row in mine if row["truth"]["names"] == [effect]]
            other = Counter(
                answer_label(row["answer"]) for row in some if not is_right(row["answer"], row["truth"])
            )
            text = ", ".join(f"{what} {count}" for what, count in sorted(other.items())) or "–"
            lines.append([f"`{effect}`", right_share(some).text(), text])
    return table(["hidden effect", "correct", "other answers"], lines)


def answer_label(answer: Row) -> str:
    """Return an answer as a short label."""
    if answer["verdict"] != "explained":
        return str(answer["verdict"])
    return " + ".join(sorted(one["effect"] for one in answer["missing"]))


def wrong_answers(rows: Sequence[Row]) -> str:
    """Return all wrong answers of clean recordings and of recordings with several effects."""
    lines = []
    for row in rows:
        truth, answer = row["truth"], row["answer"]
        if is_right(answer, truth) or case_group(truth) in ("one effect", "out of catalogue"):
            continue
        instrument = truth["instrument"]
        how = ", ".join(
            [truth["engine"], *(str(instrument[key]) for key in ("contact", "frame", "rate_class"))]
        )
        names = ", ".join(f"{one['effect']} {one['probability']:.2f}" for one in answer.get("missing", []))
        lines.append(
            [
                row["case"],
                " + ".join(truth["names"]) or "nothing",
                how,
                f"{answer['verdict']} {names}".strip(),
            ]
        )
    return table(["case", "hidden effects", "recording", "answer"], lines) if lines else "None."


def rejections(truths: Sequence[Row]) -> str:
    """Return the share of draws that were not material, by class of instrument."""
    tried = [
        one for truth in truths if truth["names"] for one in truth["attempts"] if one["reason"] != "no place"
    ]
    lines = []
    for key in ("rate", "noise", "frame", "contact"):
        for value in sorted({one[key] for one in tried}):
            mine = [one for one in tried if one[key] == value]
            why = Counter(one["reason"] for one in mine if one["reason"] is not None)
            text = ", ".join(f"{what} {count}" for what, count in sorted(why.items())) or "–"
            lines.append([key, value, share(one["reason"] is not None for one in mine).text(), text])
    return table(["class", "value", "rejected draws", "why"], lines)


def intervals(rows: Sequence[Row]) -> str:
    """Return the coverage of 90 % intervals, pooled and by effect."""
    found = [
        (effect, held, row["truth"]["engine"])
        for row in rows
        for effect, held in coverage(row["answer"], row["truth"])
    ]
    lines = [["all", *coverage_cells(found)]]
    for effect in sorted({effect for effect, _, _ in found}):
        lines.append([effect, *coverage_cells([one for one in found if one[0] == effect])])
    return table(["effect", "all", *ENGINES], lines)


def coverage_cells(found: Sequence[tuple[str, bool, str]]) -> list[str]:
    """Return the coverage of intervals, pooled and by engine."""
    pooled = [share(held for _, held, _ in found)]
    return [
        one.text()
        for one in pooled + [share(held for _, held, engine in found if engine == name) for name in ENGINES]
    ]


def probabilities(rows: Sequence[Row]) -> str:
    """Return the calibration of `probability` by bins, and Brier and log score against the base rate."""
    found = [one for row in rows for one in named_probabilities(row["answer"], row["truth"])]
    if not found:
        return "No effect was named."
    lines = [[f"{mean:.3f}", held.text()] for mean, held in calibration(found)]
    base = sum(held for _, held in found) / len(found)
    scores = [
        probability_scores([(p, held) for p, held in found]),
        probability_scores([(base, held) for _, held in found]),
    ]
    text = "Brier score {0[0]:.4f} (base rate {1[0]:.4f}), log score {0[1]:.4f} (base rate {1[1]:.4f})."
    return (
        table(["mean probability", "correct"], lines)
        + "\n\n"
        + text.format(*scores)
        + "\n\n"
        + platt_text(rows)
    )


def platt_text(rows: Sequence[Row]) -> str:
    """Return the parameters of Platt's method fitted to these answers."""
    used = reliability.current_platt()
    found = reliability.fit_platt(rows, used)
    if found is None:
        return "No effect was named."
    text = (
        "Platt's method, each kind of recording at its prevalence, gives offset {0.offset:.3f}, slope "
        "{0.slope:.3f} and bound {0.most:.2f}; in use are {1.offset:.3f}, {1.slope:.3f} and {1.most:.2f}. "
        "The highest probability is then {2:.3f}, in use {3:.3f}."
    )
    return text.format(found, used, found.probability(found.most), used.probability(used.most))


def probability_scores(found: Sequence[tuple[float, bool]]) -> tuple[float, float]:
    """Return Brier score and mean negative log probability, with probabilities of at least 10⁻⁶."""
    brier = sum((p - held) ** 2 for p, held in found) / len(found)
    logs = [-math.log(min(max(p if held else 1.0 - p, 1e-6), 1.0)) for p, held in found]
    return brier, sum(logs) / len(logs)


def costs(rows: Sequence[Row]) -> str:
    """Return the distribution of wall time, processor time and memory of a diagnosis."""
    labels: list[tuple[str, str]] = [
        ("seconds", "wall time, s"),
        ("cpu", "processor time, s"),
        ("memory", "memory, MiB"),
    ]
    lines = []
    for key, label in labels:
        values: Any = np.array([row["cost"][key] for row in rows])
        quantiles = np.quantile(values, [0.5, 0.9, 0.99, 1.0])
        lines.append([label, *(f"{value:.1f}" for value in quantiles)])
    return table(["of one diagnosis", "median", "90 %", "99 %", "maximum"], lines)
