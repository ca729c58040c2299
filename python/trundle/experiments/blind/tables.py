"""Tables of a blind benchmark's page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from trundle.experiments.blind.errors import PLACE_TARGETS, meets_target, place_errors
from trundle.experiments.blind.score import (
    CERTAIN_PROBABILITY,
    GROUPS,
    candidates,
    case_group,
    has_wrong_name,
    hidden_label,
    is_at_right_place,
    is_right,
    named_probabilities,
    names_of,
    relative_gain,
)
from trundle.experiments.markdown import table
from trundle.experiments.results import Row
from trundle.experiments.statistics import Share, median, share

__all__ = [
    "accuracy",
    "costs",
    "detection_limits",
    "engines_of",
    "explained_misfits",
    "instruments",
    "leave_one_out",
    "rejections",
    "single_effects",
    "tie_text",
    "wrong_answers",
]

MIN_RELATIVE_GAIN = 0.8
"""Target of the held-out gain relative to the oracle's, in logarithm."""
FALSE_ALARMS = "false alarms"
WRONG_NAME = "a wrong name above 0.9, of all recordings"
WRONG_NAME_OUTSIDE = "a wrong name above 0.9, out of catalogue"
GAIN = "gain at least 0.8 of the oracle's"
JOINT = "joint or body right, of rightly named effects"
AT_MOST = (FALSE_ALARMS, WRONG_NAME, WRONG_NAME_OUTSIDE)
"""Figures with an upper limit."""
TARGETS: dict[str, dict[str, float | None]] = {
    "furniture": {
        "one effect": 0.95,
        "two effects": 0.80,
        FALSE_ALARMS: 0.02,
        "out of catalogue": 0.90,
        WRONG_NAME_OUTSIDE: 0.05,
        GAIN: 0.90,
        **{f"{kind}: {direction} {limit}": 1.0 for kind, (direction, limit) in PLACE_TARGETS.items()},
    },
    "wide": {
        "one effect": 0.95,
        "two effects": 0.85,
        "three effects": 0.7,
        "four effects": None,
        "clean": 0.99,
        "out of catalogue": 0.9,
        WRONG_NAME: 0.01,
        GAIN: 0.90,
    },
    "mechanism": {
        "one effect": 0.9,
        "two effects": 0.75,
        "three effects": None,
        FALSE_ALARMS: 0.02,
        "out of catalogue": 0.85,
        WRONG_NAME: 0.01,
        JOINT: 0.97,
        GAIN: 0.85,
    },
}
"""Figures of each benchmark with their targets."""


def right_share(rows: Iterable[Row]) -> Share:
    """Return the share of correct answers."""
    return share(is_right(row["answer"], row["truth"]) for row in rows)


def wrong_share(rows: Iterable[Row]) -> Share:
    """Return the share of answers with a certain name that is not in the recording."""
    return share(has_wrong_name(row["answer"], row["truth"]) for row in rows)


def of_group(rows: Iterable[Row], *names: str) -> list[Row]:
    """Return the rows of groups."""
    return [row for row in rows if case_group(row["truth"]) in names]


def gains(rows: Iterable[Row]) -> list[float]:
    """Return the relative gains of the answers that have one."""
    found = (relative_gain(row["answer"], row["truth"]) for row in rows)
    return [gain for gain in found if gain is not None]


def figure(name: str, rows: Sequence[Row]) -> Share:
    """Return a figure of the table of targets."""
    if name in GROUPS:
        return right_share(of_group(rows, name))
    if name == FALSE_ALARMS:
        clean = of_group(rows, "clean")
        return share(row["answer"]["verdict"] in ("explained", "unexplained") for row in clean)
    if name in (WRONG_NAME, WRONG_NAME_OUTSIDE):
        return wrong_share(rows if name == WRONG_NAME else of_group(rows, "out of catalogue"))
    if name == JOINT:
        return share(right for row in rows for right in is_at_right_place(row["answer"], row["truth"]))
    if name == GAIN:
        return share(gain >= MIN_RELATIVE_GAIN for gain in gains(rows))
    kind = name.partition(":")[0]
    return share(meets_target(kind, value) for _, value in place_errors(rows)[kind])


def accuracy(generator: str, rows: Sequence[Row]) -> str:
    """Return the targets and results, also by engine if there are several."""
    engines = engines_of(rows)
    lines = []
    for name, target in TARGETS[generator].items():
        parts = [[row for row in rows if row["truth"].get("engine") == engine] for engine in engines]
        most = name in AT_MOST
        aim = (
            "–"
            if target is None
            else "all"
            if target == 1.0
            else f"{'≤' if most else '≥'} {100 * target:.0f} %"
        )
        found = figure(name, rows)
        verdict = "" if target is None else target_verdict(found, target, most=most)
        lines.append([name, aim, found.text(), verdict, *(figure(name, part).text() for part in parts)])
    return table(["figure", "target", "result", "", *engines], lines)


def engines_of(rows: Iterable[Row]) -> list[str]:
    """Return the engines of a benchmark; none if there is only one."""
    engines = sorted({row["truth"]["engine"] for row in rows if "engine" in row["truth"]})
    return engines if len(engines) > 1 else []


def target_verdict(found: Share, target: float, *, most: bool = False) -> str:
    """Return whether a target is met, and whether its interval confirms that."""
    if not found.total:
        return "no case"
    low, high = found.interval
    met = found.value <= target if most else found.value >= target
    sure = (high <= target if most else low >= target) or found.value == target == 1.0
    return "**missed**" if not met else ("met" if sure else "met, interval reaches beyond")


def tie_text(rows: Sequence[Row]) -> str:
    """Return a sentence about the number of tied sets."""
    right = [row["answer"] for row in of_group(rows, *GROUPS[:4]) if is_right(row["answer"], row["truth"])]
    if not right:
        return ""
    mean = np.mean([len(candidates(answer)) for answer in right])
    return f"Mean number of tied sets in correct answers: {mean:.2f} (1: no tie)."


CLASSES = {
    "rate_class": "rate of poses",
    "noise_class": "pose noise",
    "frame": "axes of the reading",
    "contact": "contact",
}
MECHANISM_CLASSES = {
    "robot": "robot",
    "source": "effort",
    "rate_class": "rate",
    "side": "side of the encoder",
}


def instruments(rows: Sequence[Row], classes: dict[str, str] = CLASSES) -> str:
    """Return correct answers by class of instrument."""
    kinds = {"clean": ("clean",), "effects": GROUPS[:4], "out of catalogue": ("out of catalogue",)}
    lines = []
    for key, label in classes.items():
        for value in sorted({row["truth"]["instrument"][key] for row in rows}):
            mine = [row for row in rows if row["truth"]["instrument"][key] == value]
            shares = [right_share(of_group(mine, *names)).text() for names in kinds.values()]
            lines.append([label, value, *shares, wrong_share(mine).text()])
    return table(["class", "value", *kinds, "wrong name above 0.9"], lines)


def single_effects(rows: Sequence[Row]) -> str:
    """Return a row for each single hidden effect: answers, gain, and how it was drawn."""
    lines = []
    for group in ("one effect", "out of catalogue"):
        for effect in sorted({row["truth"]["names"][0] for row in of_group(rows, group)}):
            mine = [row for row in of_group(rows, group) if row["truth"]["names"] == [effect]]
            found = gains(mine)
            factors = [row["truth"]["oracle"]["before"] / reference(row["truth"]["oracle"]) for row in mine]
            redraws = [len(row["truth"]["attempts"]) - 1 for row in mine]
            lines.append(
                [
                    f"`{effect}`",
                    right_share(mine).text(),
                    other_answers(row for row in mine if not is_right(row["answer"], row["truth"])),
                    median(found).text(".2f") if found else "–",
                    f"{np.median(factors):.1f}",
                    f"{np.mean(redraws):.1f}",
                    str(wrong_share(mine).hits),
                ]
            )
    drawn = ["gain relative to the oracle", "oracle's factor", "redraws"]
    return table(["hidden effect", "correct", "other answers", *drawn, "wrong name above 0.9"], lines)


def reference(oracle: Row) -> float:
    """Return the misfit of the oracle, or without the effect if the catalogue has no law for it."""
    return float(oracle["floor"] if oracle.get("after") is None else oracle["after"])


def other_answers(rows: Iterable[Row]) -> str:
    """Return answers with their counts."""
    counts = Counter(answer_label(row["answer"]) for row in rows)
    return ", ".join(f"{what} {count}" for what, count in sorted(counts.items())) or "–"


def answer_label(answer: Row) -> str:
    """Return an answer as a short label."""
    return (
        " + ".join(sorted(names_of(answer))) if answer["verdict"] == "explained" else str(answer["verdict"])
    )


def wrong_answers(rows: Sequence[Row]) -> str:
    """Return all wrong answers."""
    lines = []
    for row in sorted(rows, key=lambda row: str(row["case"])):
        truth, answer = row["truth"], row["answer"]
        if is_right(answer, truth):
            continue
        instrument = truth.get("instrument") or {}
        keys = ("robot", "source", "rate_class") if "robot" in truth else ("contact", "frame", "rate_class")
        how = ", ".join([truth["engine"], *(instrument[key] for key in keys)] if instrument else [])
        names = ", ".join(f"{one['effect']} {one['probability']:.2f}" for one in answer.get("missing", []))
        lines.append([row["case"], hidden_label(truth), how or "–", f"{answer['verdict']} {names}".strip()])
    return table(["case", "hidden effects", "recording", "answer"], lines) if lines else "None."


EXPLAINED_LIMITS: tuple[float, ...] = (0.0, 0.15, 0.25, 0.375, 0.5, 0.75, 1.0)


def explained_misfits(rows: Sequence[Row]) -> str:
    """Return how many names at joints are right, by the explained part of their joint's misfit."""
    found: list[tuple[float, bool]] = []
    for row in rows:
        answer, truth = row["answer"], row["truth"]
        named = zip(answer.get("missing", []), named_probabilities(answer, truth), strict=False)
        for one, (_, right) in named:
            joint = (one["where"] or {}).get("joint")
            if joint in answer.get("explained", {}):
                found.append((answer["explained"][joint], right))
    lines = []
    for low, high in pairwise(EXPLAINED_LIMITS):
        mine = [right for value, right in found if low <= value < high or value == high == 1.0]
        lines.append([f"{low:g} to {high:g}", str(sum(mine)), str(len(mine) - sum(mine))])
    return table(["explained", "right names", "wrong names"], lines)


def rejections(truths: Sequence[Row], keys: Sequence[str] = ("rate", "noise", "frame", "contact")) -> str:
    """Return the share of draws that were not material, by class of instrument."""
    attempts = [one for truth in truths if truth["names"] for one in truth["attempts"]]
    tried = [one for one in attempts if one["reason"] != "no place"]
    lines = []
    for key in keys:
        for value in sorted({one[key] for one in tried}):
            mine = [one for one in tried if one[key] == value]
            why = Counter(one["reason"] for one in mine if one["reason"] is not None)
            text = ", ".join(f"{what} {count}" for what, count in sorted(why.items())) or "–"
            lines.append([key, value, share(one["reason"] is not None for one in mine).text(), text])
    return table(["class", "value", "rejected draws", "why"], lines)


def costs(rows: Sequence[Row]) -> str:
    """Return the distribution of wall time, processor time and memory of a diagnosis."""
    labels = {"seconds": "wall time, s", "cpu": "processor time, s", "memory": "memory, MiB"}
    lines = []
    for key in (key for key in labels if all(key in row["cost"] for row in rows)):
        quantiles = np.quantile([row["cost"][key] for row in rows], [0.5, 0.9, 0.99, 1.0])
        lines.append([labels[key], *(f"{value:.1f}" for value in quantiles)])
    return table(["of one diagnosis", "median", "90 %", "99 %", "maximum"], lines)


def leave_one_out(rows: Sequence[Row]) -> str:
    """Return the answers of the diagnoses without the true effect."""
    lines = []
    for name in sorted({row["without"] for row in rows}):
        mine = [row for row in rows if row["without"] == name]
        abstained = [row["answer"]["verdict"] == "unexplained" for row in mine]
        others = other_answers(row for row, right in zip(mine, abstained, strict=True) if not right)
        parts = [row["answer"].get("missing", []) for row in mine]
        sure = share(any(one["probability"] > CERTAIN_PROBABILITY for one in part) for part in parts)
        lines.append([f"`{name}`", share(abstained).text(), others, sure.text()])
    return table(["excluded effect", '"unexplained"', "other answers", "a name above 0.9"], lines)


def detection_limits(settings: Row, rows: Sequence[Row]) -> str:
    """Return how often each effect is named at each size, and the smallest size named in 95 %."""
    sizes = sorted(settings["sizes"], reverse=True)
    lines = []
    for name in settings["effects"]:
        mine = [row for row in rows if row["truth"]["names"] == [name]]
        rates = [right_share(row for row in mine if row["truth"]["size"] == size) for size in sizes]
        counts = [f"{rate.hits}/{rate.total}" for rate in rates]
        if mine:
            lines.append([f"`{name}`", *counts, smallest_size(sizes, rates, mine)])
    return table(["effect", *(f"{size:g}" for size in sizes), "smallest size named in 95 %"], lines)


def smallest_size(sizes: Sequence[float], rates: Sequence[Share], rows: Sequence[Row]) -> str:
    """Return the smallest size from which on 95 % are named, with the median norms of its values."""
    kept = None
    for size, rate in zip(sizes, rates, strict=True):
        if not rate.total or rate.value < 0.95:
            break
        kept = size
    if kept is None:
        return "not reached"
    values: dict[str, list[float]] = {}
    for row in (row for row in rows if row["truth"]["size"] == kept):
        for name, value in row["truth"]["truth"][0]["parameters"].items():
            values.setdefault(name, []).append(float(np.linalg.norm(value)))
    return f"{kept:g}: " + ", ".join(f"{name} {np.median(found):.3g}" for name, found in values.items())
