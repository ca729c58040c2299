"""Tables of a blind benchmark's document."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from trundle.experiments.blind.errors import TARGETS, parameter_errors, place_errors
from trundle.experiments.blind.push import EPISODE_DURATION_S
from trundle.experiments.blind.score import (
    confusion_label,
    has_wrong_name,
    is_false_alarm,
    is_right,
    is_unexplained,
    named_probabilities,
    relative_gain,
)
from trundle.experiments.markdown import table
from trundle.experiments.results import Row
from trundle.experiments.statistics import Share, calibration, median, share

__all__ = [
    "by_effect",
    "by_out_of_catalogue",
    "calibration_table",
    "case_counts",
    "detection_limits",
    "leave_one_out",
    "parameters",
    "places",
    "setup_text",
    "targets",
    "wrong_answers",
]

MIN_RELATIVE_GAIN = 0.8
"""Target of the held-out gain relative to the oracle's, in logarithm."""


def clean(rows: Iterable[Row]) -> list[Row]:
    """Return the cases without a hidden effect."""
    return [row for row in rows if not row["truth"]["names"]]


def out_of_catalogue(rows: Iterable[Row]) -> list[Row]:
    """Return the cases with an out-of-catalogue effect."""
    return [row for row in rows if row["truth"]["foreign"]]


def catalogue_cases(rows: Iterable[Row], count: int) -> list[Row]:
    """Return the cases with `count` effects of the catalogue."""
    return [row for row in rows if len(row["truth"]["names"]) == count and not row["truth"]["foreign"]]


def right_share(rows: Iterable[Row]) -> Share:
    """Return the share of correct answers."""
    return share(is_right(row["answer"], row["truth"]) for row in rows)


def setup_text(settings: Row) -> dict[str, str]:
    """Return text fragments that describe the recordings."""
    episodes, size = settings["episodes"], settings.get("size", 1.0)
    same = "all with one initial pose and one grasp, without rotation"
    ways = same if settings.get("alike") else "3 or 4 grasps"
    smaller = f" The hidden effect then has {size:g} of that size. The targets below do not apply to it."
    return {
        "pushes": f"{episodes} episodes of {EPISODE_DURATION_S:g} s, {ways}",
        "held_out": f"{min(2, episodes - 1)} held out",
        "size": smaller if size != 1.0 else "",
    }


def case_counts(settings: Row, rows: Sequence[Row]) -> str:
    """Return a sentence with the numbers of cases, the seeds, and the duration of the diagnoses."""
    one, two = (len(catalogue_cases(rows, count)) for count in (1, 2))
    counts = f"{one} with one effect, {two} with two, {len(clean(rows))} with none"
    drawn = [row["truth"]["oracle"].get("redraws", 0) for row in rows if row["truth"]["names"]]
    given_up = Counter(" + ".join(names) for names in settings["given_up"])
    lost = ", ".join(f"{name} {count}" for name, count in sorted(given_up.items())) or "none"
    seconds = [row["seconds"] for row in rows]
    undone = f" {settings['undone']} sealed cases were not diagnosed." if settings["undone"] else ""
    spent = f"{np.median(seconds):.1f} s (median), {np.max(seconds):.1f} s at most"
    return (
        f"Range of seeds: {settings['range']}, first seed {settings['first']}. {len(rows)} recordings: "
        f"{counts}, {len(out_of_catalogue(rows))} out of catalogue. Immaterial draws that were drawn again: "
        f"{sum(drawn)}; cases dropped after {settings['attempts']} draws: {lost}. Duration of a diagnosis: "
        f"{spent}.{undone}"
    )


def targets(rows: Sequence[Row]) -> str:
    """Return the table of targets and results."""
    gains = [gain for row in rows if (gain := relative_gain(row["answer"], row["truth"])) is not None]
    lines = [
        target_row(
            "one effect: exactly its name, or a tie with it",
            right_share(catalogue_cases(rows, 1)),
            0.95,
        ),
        target_row("two effects: exactly both names", right_share(catalogue_cases(rows, 2)), 0.80),
        target_row(
            "false alarms", share(is_false_alarm(row["answer"]) for row in clean(rows)), 0.02, most=True
        ),
        target_row('out of catalogue: "unexplained"', right_share(out_of_catalogue(rows)), 0.90),
        target_row(
            "out of catalogue: a wrong name with probability above 0.9",
            share(has_wrong_name(row["answer"], row["truth"]) for row in out_of_catalogue(rows)),
            0.05,
            most=True,
        ),
        target_row(
            f"held-out gain at least {MIN_RELATIVE_GAIN} of the oracle's",
            share(gain >= MIN_RELATIVE_GAIN for gain in gains),
            0.90,
        ),
    ]
    for kind, found in place_errors(rows).items():
        reached = share(meets_limit(kind, value) for _, value in found)
        lines.append(
            [
                f"{kind}: {' '.join(map(str, TARGETS[kind]))}",
                "all",
                reached.text(),
                target_verdict(reached, 1.0),
            ]
        )
    return table(["figure", "target", "result", ""], lines)


def meets_limit(kind: str, value: float) -> bool:
    """Return whether an error meets its target."""
    direction, limit = TARGETS[kind]
    return value <= limit if direction == "at most" else value >= limit


def target_row(what: str, found: Share, target: float, *, most: bool = False) -> list[str]:
    """Return a row of the table of targets."""
    aim = f"{'≤' if most else '≥'} {100 * target:.0f} %"
    return [what, aim, found.text(), target_verdict(found, target, most=most)]


def target_verdict(found: Share, target: float, *, most: bool = False) -> str:
    """Return whether a target is met, and whether its interval confirms that."""
    if not found.total:
        return "no case"
    low, high = found.interval
    met = found.value <= target if most else found.value >= target
    sure = (high <= target if most else low >= target) or found.value == target == 1.0
    return "**missed**" if not met else ("met" if sure else "met, interval reaches beyond")


def by_effect(settings: Row, rows: Sequence[Row]) -> str:
    """Return a row for each effect: correct names, other answers, gain, draws."""
    lines = []
    for name in settings["effects"]:
        mine = [row for row in catalogue_cases(rows, 1) if row["truth"]["names"] == [name]]
        if not mine:
            continue
        gains = [gain for row in mine if (gain := relative_gain(row["answer"], row["truth"])) is not None]
        factor = [row["truth"]["oracle"]["before"] / oracle_floor(row) for row in mine]
        lines.append(
            [
                f"`{name}`",
                right_share(mine).text(),
                other_answers(mine, name),
                median(gains).text(".2f") if gains else "no oracle",
                f"{np.median(factor):.1f}",
                f"{np.mean([row['truth']['oracle']['redraws'] for row in mine]):.1f}",
            ]
        )
    head = ["effect", "correct", "other answers", "gain relative to the oracle", "oracle's factor", "redraws"]
    return table(head, lines)


def oracle_floor(row: Row) -> float:
    """Return the misfit of the oracle, or without the effect if the catalogue has no law for it."""
    oracle = row["truth"]["oracle"]
    return float(oracle["floor"] if oracle["after"] is None else oracle["after"])


def other_answers(rows: Sequence[Row], name: str) -> str:
    """Return the other answers with their counts."""
    counts = Counter(confusion_label(row["answer"], row["truth"]) for row in rows)
    counts.pop(name, None)
    return ", ".join(f"{answer} {count}" for answer, count in counts.most_common()) or "–"


def by_out_of_catalogue(rows: Sequence[Row]) -> str:
    """Return a row for each out-of-catalogue family: abstentions and names."""
    lines = []
    for name in sorted({row["truth"]["names"][0] for row in out_of_catalogue(rows)}):
        mine = [row for row in out_of_catalogue(rows) if row["truth"]["names"][0] == name]
        sure = share(has_wrong_name(row["answer"], row["truth"]) for row in mine)
        found = share(is_unexplained(row["answer"]) for row in mine)
        lines.append([f"`{name}`", found.text(), other_answers(mine, "unexplained"), str(sure.hits)])
    return table(["family", '"unexplained"', "other answers", "wrong name above 0.9"], lines)


def places(rows: Sequence[Row]) -> str:
    """Return the errors of places and times by effect."""
    lines = []
    for kind, found in place_errors(rows).items():
        for effect in sorted({effect for effect, _ in found}):
            values = [value for name, value in found if name == effect]
            reached = share(meets_limit(kind, value) for value in values)
            lines.append([kind, f"`{effect}`", median(values).text(".2g", "not given"), reached.text()])
    return table(["place", "effect", "median", "within"], lines)


def parameters(rows: Sequence[Row]) -> str:
    """Return relative errors of values, and the coverage of intervals of two standard deviations."""
    lines = []
    for name, errors in sorted(parameter_errors(rows).items()):
        sizes = [size for size, _ in errors if math.isfinite(size)]
        held = share(z <= 2.0 for _, z in errors if math.isfinite(z))
        lines.append([f"`{name}`", f"{median(sizes).text('.2g')}" if sizes else "–", held.text()])
    return table(["value", "relative error, median", "within 2 sd"], lines)


def calibration_table(rows: Sequence[Row]) -> str:
    """Return the calibration of the probabilities of all names."""
    answers = [one for row in rows for one in named_probabilities(row["answer"], row["truth"])]
    lines = [[f"{p:.3f}", found.text()] for p, found in calibration(answers)]
    return table(["mean probability", "correct"], lines)


def wrong_answers(rows: Sequence[Row]) -> str:
    """Return all wrong answers."""
    lines = []
    for row in rows:
        if not is_right(row["answer"], row["truth"]):
            names = " + ".join(row["truth"]["names"]) or "nothing"
            given = ", ".join(f"{one['effect']} {one['probability']:.2f}" for one in row["answer"]["missing"])
            lines.append([row["case"], names, row["answer"]["verdict"], given or "–"])
    return table(["case", "hidden", "verdict", "names"], lines) if lines else "None."


def leave_one_out(rows: Sequence[Row]) -> str:
    """Return the answers of the diagnoses without the true effect."""
    lines = []
    for name in sorted({row["without"] for row in rows}):
        mine = [row for row in rows if row["without"] == name]
        found = share(is_unexplained(row["answer"]) for row in mine)
        sure = share(any(one["probability"] > 0.9 for one in row["answer"]["missing"]) for row in mine)
        lines.append([f"`{name}`", found.text(), other_answers(mine, "unexplained"), sure.text()])
    return table(["excluded effect", '"unexplained"', "other answers", "a name above 0.9"], lines)


def detection_limits(settings: Row, rows: Sequence[Row]) -> str:
    """Return how often each effect is named at each size, and the smallest size named in 95 %."""
    sizes = sorted(settings["sizes"], reverse=True)
    lines = []
    for name in settings["effects"]:
        mine = [row for row in rows if row["truth"]["names"] == [name]]
        if not mine:
            continue
        rates = [right_share(row for row in mine if row["truth"]["size"] == size) for size in sizes]
        lines.append(
            [f"`{name}`", *(f"{rate.hits}/{rate.total}" for rate in rates), smallest_size(sizes, rates, mine)]
        )
    return table(["effect", *(f"{size:g}" for size in sizes), "smallest size named in 95 %"], lines)


def smallest_size(sizes: Sequence[float], rates: Sequence[Share], rows: Sequence[Row]) -> str:
    """Return the smallest size from which on 95 % are named, with the median values at that size."""
    kept = None
    for size, rate in zip(sizes, rates, strict=True):
        if not rate.total or rate.value < 0.95:
            break
        kept = size
    if kept is None:
        return "not reached"
    return f"{kept:g}: {median_sizes([row for row in rows if row['truth']['size'] == kept])}"


def median_sizes(rows: Sequence[Row]) -> str:
    """Return the median norms of the values of the effect."""
    values: dict[str, list[float]] = {}
    for row in rows:
        for name, value in row["truth"]["truth"][0]["parameters"].items():
            values.setdefault(name, []).append(float(np.linalg.norm(value)))
    middle: Callable[[list[float]], float] = lambda found: float(np.median(found))  # noqa: E731
    return ", ".join(f"{name} {middle(found):.3g}" for name, found in values.items())
