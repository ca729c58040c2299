"""Tables of the document."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from trundle.experiments.blind.errors import TARGETS, parameter_errors, place_errors
from trundle.experiments.blind.push import SECONDS
from trundle.experiments.blind.score import (
    abstained,
    column,
    false_alarm,
    gain_share,
    is_right,
    said,
    wrong_name,
)
from trundle.experiments.markdown import table
from trundle.experiments.results import Row
from trundle.experiments.statistics import Share, calibration, median, share

__all__ = [
    "about",
    "by_effect",
    "by_foreign",
    "calibrated",
    "described",
    "left_out",
    "limits",
    "parameters",
    "places",
    "targets",
    "wrong_answers",
]

GAIN = 0.8
"""Of the oracle's, in logarithm."""


def clean(rows: Iterable[Row]) -> list[Row]:
    """Return the cases with nothing hidden."""
    return [row for row in rows if not row["truth"]["names"]]


def foreign(rows: Iterable[Row]) -> list[Row]:
    """Return the cases with something that the catalogue does not have."""
    return [row for row in rows if row["truth"]["foreign"]]


def known(rows: Iterable[Row], count: int) -> list[Row]:
    """Return the cases with so many effects of the catalogue."""
    return [row for row in rows if len(row["truth"]["names"]) == count and not row["truth"]["foreign"]]


def right(rows: Iterable[Row]) -> Share:
    """Return how many answers are what they should be."""
    return share(is_right(row["answer"], row["truth"]) for row in rows)


def described(settings: Row) -> dict[str, str]:
    """Say how the recordings are made."""
    episodes, size = settings["episodes"], settings.get("size", 1.0)
    ways = "all from one pose, by one grasp and without a turn" if settings.get("alike") else "3 or 4 grasps"
    smaller = f" Then {size:g} of its size is hidden, for which the targets below are not meant."
    return {
        "pushes": f"{episodes} episodes of {SECONDS:g} s, {ways}",
        "held_out": f"{min(2, episodes - 1)} held out",
        "size": smaller if size != 1.0 else "",
    }


def about(settings: Row, rows: Sequence[Row]) -> str:
    """Say how many cases there are, of which seeds, and what they took."""
    counts = (
        f"{len(known(rows, 1))} with one effect, {len(known(rows, 2))} with two, {len(clean(rows))} with none"
    )
    drawn = [row["truth"]["oracle"].get("redraws", 0) for row in rows if row["truth"]["names"]]
    given_up = Counter(" + ".join(names) for names in settings["given_up"])
    lost = ", ".join(f"{name} {count}" for name, count in sorted(given_up.items())) or "none"
    seconds = [row["seconds"] for row in rows]
    undone = f" {settings['undone']} sealed cases were not diagnosed." if settings["undone"] else ""
    spent = f"{np.median(seconds):.1f} s (median), {np.max(seconds):.1f} s at most"
    return (
        f"Range of seeds: {settings['range']}, from {settings['first']} on. {len(rows)} recordings: "
        f"{counts}, {len(foreign(rows))} with something foreign. Draws that did not matter and were drawn "
        f"again: {sum(drawn)}; cases given up after {settings['attempts']} draws: {lost}. A diagnosis took "
        f"{spent}.{undone}"
    )


def targets(rows: Sequence[Row]) -> str:
    """Return what is to be reached, and what was."""
    gains = [gain for row in rows if (gain := gain_share(row["answer"], row["truth"])) is not None]
    lines = [
        line("one effect: exactly its name, or a tie that holds it", right(known(rows, 1)), 0.95),
        line("two effects: both and no third", right(known(rows, 2)), 0.80),
        line("false alarms", share(false_alarm(row["answer"]) for row in clean(rows)), 0.02, most=True),
        line('foreign: "unexplained"', right(foreign(rows)), 0.90),
        line(
            "foreign: a wrong name with probability above 0.9",
            share(wrong_name(row["answer"], row["truth"]) for row in foreign(rows)),
            0.05,
            most=True,
        ),
        line(f"held-out gain at least {GAIN} of the oracle's", share(gain >= GAIN for gain in gains), 0.90),
    ]
    for kind, found in place_errors(rows).items():
        reached = share(within(kind, value) for _, value in found)
        lines.append(
            [f"{kind}: {' '.join(map(str, TARGETS[kind]))}", "all", reached.text(), verdict(reached, 1.0)]
        )
    return table(["what", "to reach", "reached", ""], lines)


def within(kind: str, value: float) -> bool:
    """Tell whether an error is what it should be."""
    direction, limit = TARGETS[kind]
    return value <= limit if direction == "at most" else value >= limit


def line(what: str, found: Share, target: float, *, most: bool = False) -> list[str]:
    """Return a line of the targets."""
    aim = f"{'≤' if most else '≥'} {100 * target:.0f} %"
    return [what, aim, found.text(), verdict(found, target, most=most)]


def verdict(found: Share, target: float, *, most: bool = False) -> str:
    """Say whether a target is met, and whether the interval says so too."""
    if not found.total:
        return "not tried"
    low, high = found.interval
    met = found.value <= target if most else found.value >= target
    sure = (high <= target if most else low >= target) or found.value == target == 1.0
    return "**missed**" if not met else ("met" if sure else "met, interval not")


def by_effect(settings: Row, rows: Sequence[Row]) -> str:
    """Return for each effect: names, wrong ones, gain, draws."""
    lines = []
    for name in settings["effects"]:
        mine = [row for row in known(rows, 1) if row["truth"]["names"] == [name]]
        if not mine:
            continue
        gains = [gain for row in mine if (gain := gain_share(row["answer"], row["truth"])) is not None]
        factor = [row["truth"]["oracle"]["before"] / reached(row) for row in mine]
        lines.append(
            [
                f"`{name}`",
                right(mine).text(),
                others(mine, name),
                median(gains).text(".2f") if gains else "no oracle",
                f"{np.median(factor):.1f}",
                f"{np.mean([row['truth']['oracle']['redraws'] for row in mine]):.1f}",
            ]
        )
    head = ["effect", "named", "else", "gain over the oracle's", "what it matters", "redraws"]
    return table(head, lines)


def reached(row: Row) -> float:
    """Return the misfit of the oracle, or without the effect where it has no law."""
    oracle = row["truth"]["oracle"]
    return float(oracle["floor"] if oracle["after"] is None else oracle["after"])


def others(rows: Sequence[Row], name: str) -> str:
    """Return what was answered instead."""
    counts = Counter(column(row["answer"], row["truth"]) for row in rows)
    counts.pop(name, None)
    return ", ".join(f"{answer} {count}" for answer, count in counts.most_common()) or "–"


def by_foreign(rows: Sequence[Row]) -> str:
    """Return for each foreign family: abstention, and the names that were given."""
    lines = []
    for name in sorted({row["truth"]["names"][0] for row in foreign(rows)}):
        mine = [row for row in foreign(rows) if row["truth"]["names"][0] == name]
        sure = share(wrong_name(row["answer"], row["truth"]) for row in mine)
        found = share(abstained(row["answer"]) for row in mine)
        lines.append([f"`{name}`", found.text(), others(mine, "unexplained"), str(sure.hits)])
    return table(["family", '"unexplained"', "else", "wrong name above 0.9"], lines)


def places(rows: Sequence[Row]) -> str:
    """Return errors of places and moments by effect."""
    lines = []
    for kind, found in place_errors(rows).items():
        for effect in sorted({effect for effect, _ in found}):
            values = [value for name, value in found if name == effect]
            reached = share(within(kind, value) for value in values)
            lines.append([kind, f"`{effect}`", median(values).text(".2g", "not given"), reached.text()])
    return table(["place", "effect", "median", "within"], lines)


def parameters(rows: Sequence[Row]) -> str:
    """Return relative errors of values, and how often two standard deviations held them."""
    lines = []
    for name, errors in sorted(parameter_errors(rows).items()):
        sizes = [size for size, _ in errors if math.isfinite(size)]
        held = share(z <= 2.0 for _, z in errors if math.isfinite(z))
        lines.append([f"`{name}`", f"{median(sizes).text('.2g')}" if sizes else "–", held.text()])
    return table(["value", "relative error, median", "within 2 sd"], lines)


def calibrated(rows: Sequence[Row]) -> str:
    """Return the calibration of the probabilities of all names that were given."""
    answers = [one for row in rows for one in said(row["answer"], row["truth"])]
    return table(["said", "right"], [[f"{p:.3f}", found.text()] for p, found in calibration(answers)])


def wrong_answers(rows: Sequence[Row]) -> str:
    """List every answer that is not what it should be."""
    lines = []
    for row in rows:
        if not is_right(row["answer"], row["truth"]):
            names = " + ".join(row["truth"]["names"]) or "nothing"
            given = ", ".join(f"{one['effect']} {one['probability']:.2f}" for one in row["answer"]["missing"])
            lines.append([row["case"], names, row["answer"]["verdict"], given or "–"])
    return table(["case", "hidden", "verdict", "names"], lines) if lines else "None."


def left_out(rows: Sequence[Row]) -> str:
    """Return what is answered where the true effect is not among the candidates."""
    lines = []
    for name in sorted({row["without"] for row in rows}):
        mine = [row for row in rows if row["without"] == name]
        found = share(abstained(row["answer"]) for row in mine)
        sure = share(any(one["probability"] > 0.9 for one in row["answer"]["missing"]) for row in mine)
        lines.append([f"`{name}`", found.text(), others(mine, "unexplained"), sure.text()])
    return table(["left out", '"unexplained"', "else", "a name above 0.9"], lines)


def limits(settings: Row, rows: Sequence[Row]) -> str:
    """Return for each effect how often it is named at each size, and the smallest size named in 95 %."""
    sizes = sorted(settings["sizes"], reverse=True)
    lines = []
    for name in settings["effects"]:
        mine = [row for row in rows if row["truth"]["names"] == [name]]
        if not mine:
            continue
        rates = [right(row for row in mine if row["truth"]["size"] == size) for size in sizes]
        lines.append(
            [f"`{name}`", *(f"{rate.hits}/{rate.total}" for rate in rates), limit(sizes, rates, mine)]
        )
    return table(["effect", *(f"{size:g}" for size in sizes), "smallest size named in 95 %"], lines)


def limit(sizes: Sequence[float], rates: Sequence[Share], rows: Sequence[Row]) -> str:
    """Return the least size from which on upwards 95 % are named, with the values that it stands for."""
    kept = None
    for size, rate in zip(sizes, rates, strict=True):
        if not rate.total or rate.value < 0.95:
            break
        kept = size
    if kept is None:
        return "not reached"
    return f"{kept:g}: {amounts([row for row in rows if row['truth']['size'] == kept])}"


def amounts(rows: Sequence[Row]) -> str:
    """Return median sizes of the values at a size."""
    values: dict[str, list[float]] = {}
    for row in rows:
        for name, value in row["truth"]["truth"][0]["parameters"].items():
            values.setdefault(name, []).append(float(np.linalg.norm(value)))
    middle: Callable[[list[float]], float] = lambda found: float(np.median(found))  # noqa: E731
    return ", ".join(f"{name} {middle(found):.3g}" for name, found in values.items())
