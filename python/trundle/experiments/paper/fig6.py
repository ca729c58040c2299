"""Fig. 6: observations that each learner needs to predict ten objects well."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trundle._native import _learning_curves
from trundle.experiments import figure_style
from trundle.experiments.markdown import prose, table
from trundle.experiments.paper import config, objects
from trundle.experiments.paper.experiment import Options, Section
from trundle.experiments.results import Row
from trundle.experiments.statistics import first_reached, first_sustained, median, median_difference

FILE = "fig6"
TITLE = "Fig. 6: observations needed on ten objects"

KNOWN: dict[str, type | tuple[type, ...]] = {
    "seeds": int,
    "seeds_elsewhere": int,
    "objects": list,
    "learners": list,
    "counts": list,
    "tested": int,
    "threshold": float,
    "sigma": float,
    "readings": list,
    "starts": int,
}
READINGS = {
    "cm_deg": "0.5 cm, 0.5°, 0.5 cm/s, 0.5 °/s",
    "si": "0.5 m, 0.5 rad, 0.5 m/s, 0.5 rad/s",
    "of_motion": "half the standard deviation of each channel's change",
    "wrench": "0.5 N and 0.5 N·m on the wrench, the states exact",
}
"""Interpretations of σ = 0.50, whose unit the paper does not state."""


def settings(options: Options) -> dict[str, Any]:
    """Return the settings of the file and its objects."""
    found = config.select_settings(config.read(options.file(FILE), KNOWN), options)
    folder = options.objects
    things = {name: objects.read_object(folder, name) for name in found["objects"]}
    return {**found, "things": things, "file": FILE, "quick": options.quick}


def trials(settings: dict[str, Any]) -> Sequence[Row]:
    """Return every object under every interpretation with every seed."""
    return [
        {"reading": reading, "object": name, "seed": seed}
        for reading in settings["readings"]
        for name in settings["objects"]
        for seed in range(settings["seeds" if reading == settings["readings"][0] else "seeds_elsewhere"])
    ]


def perform(settings: dict[str, Any], trial: Row) -> Row:
    """Learn from increasing numbers of observations; return R² of each learner at each number."""
    thing = settings["things"][trial["object"]]
    curves, coasting = _learning_curves(
        objects.true_model_text(thing),
        objects.fit_model_text(thing),
        settings["learners"],
        settings["counts"],
        (trial["reading"], settings["sigma"]),
        trial["seed"],
        tested=settings["tested"],
        starts=settings["starts"],
    )
    return {"r2": dict(zip(settings["learners"], curves, strict=True)), "coasting": coasting}


def observations_needed(
    settings: dict[str, Any],
    rows: Sequence[Row],
    reading: str,
    name: str,
    learner: str,
    *,
    kept: bool = False,
) -> list[float]:
    """Return for each seed the observations that a learner needs; infinite if all are too few.

    With `kept`, the smallest number from which on it stays above the threshold.
    """
    count = first_sustained if kept else first_reached
    return [
        count(settings["counts"], row["r2"][learner], settings["threshold"])
        for row in rows
        if row["reading"] == reading and row["object"] == name
    ]


def section(settings: dict[str, Any], rows: Sequence[Row]) -> Section:
    """Return the section."""
    main = settings["readings"][0]
    names = [figure_style.NAMES[learner] for learner in settings["learners"]]
    text = prose(
        "paper",
        FILE,
        most=max(settings["counts"]),
        tested=settings["tested"],
        threshold=settings["threshold"],
        starts=settings["starts"],
        reading=READINGS[main],
        table=table(["object", *names], counts_table(settings, rows, main)),
        verdict=verdict(settings, rows, main),
        verdicts="\n".join(
            f"- {READINGS[r]}: {verdict(settings, rows, r)}" for r in settings["readings"][1:]
        ),
        elsewhere=settings["seeds_elsewhere"],
        readings=table(["σ = 0.50 read as", *names], readings_table(settings, rows)),
        kept=sustained_text(settings, rows, main),
    )
    return Section(text, {"paper_fig6.png": lambda path: draw(path, settings, rows, main)})


def counts_table(settings: dict[str, Any], rows: Sequence[Row], reading: str) -> list[list[str]]:
    """Return a row for each object: its median count for each learner."""
    return [
        [
            objects.title(name),
            *(
                median(observations_needed(settings, rows, reading, name, learner)).text(".3g", "–")
                for learner in settings["learners"]
            ),
        ]
        for name in settings["objects"]
    ]


def readings_table(settings: dict[str, Any], rows: Sequence[Row]) -> list[list[str]]:
    """Return a row for each interpretation of σ."""
    lines = []
    for reading in settings["readings"]:
        cells = [READINGS[reading]]
        for learner in settings["learners"]:
            each = [
                observations_needed(settings, rows, reading, name, learner) for name in settings["objects"]
            ]
            reached = sum(math.isfinite(median(one).middle) for one in each)
            every = median([count for one in each for count in one])
            cells.append(f"{every.text('.3g', '–')}; {reached} of {len(each)}")
        lines.append(cells)
    return lines


def verdict(settings: dict[str, Any], rows: Sequence[Row], reading: str) -> str:
    """Return whether PBR reaches the threshold, and whether a baseline needs fewer observations."""
    missed, more, total = {}, [], 0
    for name in settings["objects"]:
        own = observations_needed(settings, rows, reading, name, "pbr")
        total += len(own)
        if any(map(math.isinf, own)):
            missed[name] = sum(map(math.isinf, own))
        for learner in settings["learners"]:
            difference = median_difference(own, observations_needed(settings, rows, reading, name, learner))
            if learner != "pbr" and difference.low > 0:
                more.append(
                    f"{objects.title(name)} against {figure_style.NAMES[learner]}: {difference.text('+.3g')}"
                )
    reached = (
        f"PBR reaches the threshold on all {len(settings['objects'])} objects in every run."
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


def sustained_text(settings: dict[str, Any], rows: Sequence[Row], reading: str) -> str:
    """Return a sentence with the observations needed to stay above the threshold."""
    cells = []
    for learner in settings["learners"]:
        every = [
            c
            for name in settings["objects"]
            for c in observations_needed(settings, rows, reading, name, learner, kept=True)
        ]
        cells.append(f"{figure_style.NAMES[learner]} {median(every).text('.3g', '–')}")
    return (
        "A run may cross the threshold by luck and fall below again. Counted from where it stays above up "
        f"to the last count, medians over objects and seeds are, in the first reading: {', '.join(cells)}."
    )


def draw(path: Path, settings: dict[str, Any], rows: Sequence[Row], reading: str) -> None:
    """Draw the paper's bars: medians, with a dot for every seed."""
    figure, (axes,) = figure_style.sheet(1, 1, (9.0, 3.6))
    names, learners = settings["objects"], settings["learners"]
    axes.grid(visible=False, axis="x")
    width, top = 0.8 / len(learners), max(settings["counts"])
    for k, learner in enumerate(learners):
        at = np.arange(len(names)) + (k - (len(learners) - 1) / 2) * width
        each = [observations_needed(settings, rows, reading, name, learner) for name in names]
        middle = [median(one) for one in each]
        height = [m.middle if math.isfinite(m.middle) else top * 1.06 for m in middle]
        bars = axes.bar(at, height, 0.9 * width, color=figure_style.COLOURS[learner])
        axes.bar(0, 0, color=figure_style.COLOURS[learner], label=figure_style.NAMES[learner])
        for bar, m, x, one in zip(bars, middle, at, each, strict=True):
            if math.isinf(m.middle):
                bar.set(alpha=0.25, hatch="////", edgecolor="white")
            else:
                high = min(m.high, top * 1.06)
                axes.plot([x, x], [m.low, high], color="black", linewidth=1)
            dots = [min(count, top * 1.06) for count in one]
            axes.plot([x] * len(dots), dots, ".", color="black", markersize=1.5, alpha=0.4)
    axes.axhline(top, color=figure_style.GREY, linewidth=0.8, linestyle="--")
    axes.text(-0.45, top * 1.08, "not reached", fontsize=7, color=figure_style.GREY, va="bottom")
    axes.set(ylabel=f"observations until R² ≥ {settings['threshold']}", ylim=(0, top * 1.2))
    axes.set_xticks(
        range(len(names)), [objects.title(n).replace(", ", ",\n") for n in names], rotation=30, ha="right"
    )
    axes.legend(fontsize=8, frameon=False, ncols=len(learners), loc="lower center", bbox_to_anchor=(0.5, 1.0))
    figure_style.save(figure, path)
