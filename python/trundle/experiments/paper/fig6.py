"""Fig. 6: observations that each learner needs to predict ten objects well."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trundle._native import _learning_curves
from trundle.experiments import figure_style
from trundle.experiments.figure_style import COLOURS, GREY, NAMES
from trundle.experiments.markdown import table
from trundle.experiments.paper import experiment
from trundle.experiments.paper.experiment import product, title
from trundle.experiments.results import Row
from trundle.experiments.statistics import first_reached, first_sustained, median, median_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

READINGS = {
    "cm_deg": "0.5 cm, 0.5°, 0.5 cm/s, 0.5 °/s",
    "si": "0.5 m, 0.5 rad, 0.5 m/s, 0.5 rad/s",
    "of_motion": "half the standard deviation of each channel's change",
    "wrench": "0.5 N and 0.5 N·m on the wrench, the states exact",
}
"""Interpretations of σ = 0.50, whose unit the paper does not state."""

Counts = dict[tuple[str, str, str], list[float]]
"""Observations that each seed needs, infinite if all are too few, by interpretation, object and learner."""


@dataclass(frozen=True, kw_only=True)
class Settings(experiment.Settings):
    """Settings; the first of `readings` is the main one, the others have `seeds_elsewhere`."""

    seeds_elsewhere: int
    learners: list[str]
    counts: list[int]
    tested: int
    threshold: float
    sigma: float
    readings: list[str]
    starts: int


def trials(settings: Settings) -> Sequence[Row]:
    """Return every object under every interpretation with every seed."""
    main, *others = settings.readings
    return [
        *product(reading=[main], object=settings.objects, seed=range(settings.seeds)),
        *product(reading=others, object=settings.objects, seed=range(settings.seeds_elsewhere)),
    ]


def perform(settings: Settings, trial: Row) -> Row:
    """Learn from increasing numbers of observations; return R² of each learner at each number."""
    pushed = settings.task_objects[trial["object"]]
    curves, coasting = _learning_curves(
        pushed.true_model(),
        pushed.free_model(),
        settings.learners,
        settings.counts,
        (trial["reading"], settings.sigma),
        trial["seed"],
        tested=settings.tested,
        starts=settings.starts,
    )
    return {"r2": dict(zip(settings.learners, curves, strict=True)), "coasting": coasting}


def collect_counts(
    settings: Settings, rows: Sequence[Row], count: Callable[..., float] = first_reached
) -> Counts:
    """Return the observations that are needed in all trials."""
    found: Counts = defaultdict(list)
    for row in rows:
        for learner, r2 in row["r2"].items():
            needed = count(settings.counts, r2, settings.threshold)
            found[row["reading"], row["object"], learner].append(needed)
    return found


def values(settings: Settings, rows: Sequence[Row]) -> dict[str, object]:
    """Return the values of the text."""
    counts, (main, *others) = collect_counts(settings, rows), settings.readings
    head = [NAMES[learner] for learner in settings.learners]
    lines = [
        [
            title(name),
            *(median(counts[main, name, learner]).text(".3g", "–") for learner in settings.learners),
        ]
        for name in settings.objects
    ]
    return {
        "most": max(settings.counts),
        "reading": READINGS[main],
        "table": table(["object", *head], lines),
        "verdict": verdict(settings, counts, main),
        "verdicts": "\n".join(f"- {READINGS[one]}: {verdict(settings, counts, one)}" for one in others),
        "readings": table(["σ = 0.50 read as", *head], readings_table(settings, counts)),
        "sustained": sustained_text(settings, collect_counts(settings, rows, first_sustained)),
    }


def readings_table(settings: Settings, counts: Counts) -> list[list[str]]:
    """Return a row for each interpretation of σ."""
    lines = []
    for reading in settings.readings:
        cells = [READINGS[reading]]
        for learner in settings.learners:
            each = [counts[reading, name, learner] for name in settings.objects]
            reached = sum(math.isfinite(median(one).middle) for one in each)
            cells.append(f"{median(np.concatenate(each)).text('.3g', '–')}; {reached} of {len(each)}")
        lines.append(cells)
    return lines


def verdict(settings: Settings, counts: Counts, reading: str) -> str:
    """Return whether PBR reaches the threshold, and whether a baseline needs fewer observations."""
    own = {name: counts[reading, name, "pbr"] for name in settings.objects}
    total = sum(map(len, own.values()))
    missed = {name: lost for name, each in own.items() if (lost := sum(map(math.isinf, each)))}
    more = [
        f"{title(name)} against {NAMES[learner]}: {difference.text('+.3g')}"
        for name in settings.objects
        for learner in settings.learners
        if learner != "pbr"
        if (difference := median_difference(own[name], counts[reading, name, learner])).low > 0
    ]
    reached = (
        f"PBR reaches the threshold on all {len(settings.objects)} objects in every run."
        if not missed
        else f"PBR does not reach the threshold in {sum(missed.values())} of {total} runs "
        f"(on {len(missed)} of the objects)."
    )
    fewest = (
        "There is no object on which a baseline needs fewer observations."
        if not more
        else f"It needs more observations on {'; '.join(more)}."
    )
    return f"{reached} {fewest}"


def sustained_text(settings: Settings, counts: Counts) -> str:
    """Return a sentence with the observations needed to stay above the threshold."""
    cells = []
    for learner in settings.learners:
        every = [count for name in settings.objects for count in counts[settings.readings[0], name, learner]]
        cells.append(f"{NAMES[learner]} {median(every).text('.3g', '–')}")
    return (
        "A run may cross the threshold by luck and fall below again. Counted from where it stays above up "
        f"to the last count, medians over objects and seeds are, in the first reading: {', '.join(cells)}."
    )


def draw(settings: Settings, rows: Sequence[Row]) -> Figure:
    """Draw the paper's bars: medians, with a dot for every seed."""
    figure, (axes,) = figure_style.sheet(1, 1, (9.0, 3.6))
    counts, names, learners = collect_counts(settings, rows), settings.objects, settings.learners
    axes.grid(visible=False, axis="x")
    width, top = 0.8 / len(learners), max(settings.counts)
    for k, learner in enumerate(learners):
        at = np.arange(len(names)) + (k - (len(learners) - 1) / 2) * width
        each = [counts[settings.readings[0], name, learner] for name in names]
        middle = [median(one) for one in each]
        height = [min(one.middle, top * 1.06) for one in middle]
        bars = axes.bar(at, height, 0.9 * width, color=COLOURS[learner])
        axes.bar(0, 0, color=COLOURS[learner], label=NAMES[learner])
        for bar, found, x, dots in zip(bars, middle, at, each, strict=True):
            if math.isinf(found.middle):
                bar.set(alpha=0.25, hatch="////", edgecolor="white")
            else:
                axes.plot([x, x], [found.low, min(found.high, top * 1.06)], color="black", linewidth=1)
            shown = np.minimum(dots, top * 1.06)
            axes.plot([x] * len(dots), shown, ".", color="black", markersize=1.5, alpha=0.4)
    axes.axhline(top, color=GREY, linewidth=0.8, linestyle="--")
    axes.text(-0.45, top * 1.08, "not reached", fontsize=7, color=GREY, va="bottom")
    axes.set(ylabel=f"observations until R² ≥ {settings.threshold}", ylim=(0, top * 1.2))
    labels = [title(name).replace(", ", ",\n") for name in names]
    axes.set_xticks(range(len(names)), labels, rotation=30, ha="right")
    figure_style.legend(axes, ncols=len(learners), loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return figure
