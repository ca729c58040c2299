"""Fig. 8: accuracy against noise for the shopping cart."""

from __future__ import annotations

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
from trundle.experiments.statistics import Interval, median, median_difference

FILE = "fig8"
TITLE = "Fig. 8: accuracy against noise"

MAX_ROUNDING_ERROR = 1e-14
"""Values of 1 − R² below this are rounding errors."""

KNOWN: dict[str, type | tuple[type, ...]] = {
    "seeds": int,
    "object": str,
    "learners": list,
    "trained": int,
    "tested": int,
    "reading": str,
    "sigmas": list,
    "starts": int,
}


def settings(options: Options) -> dict[str, Any]:
    """Return the settings of the file and its object."""
    found = config.select_settings(config.read(options.file(FILE), KNOWN), options)
    thing = objects.read_object(options.objects, found["object"])
    return {**found, "thing": thing, "file": FILE, "quick": options.quick}


def trials(settings: dict[str, Any]) -> Sequence[Row]:
    """Return every noise level with every seed."""
    return [
        {"sigma": sigma, "seed": seed} for sigma in settings["sigmas"] for seed in range(settings["seeds"])
    ]


def perform(settings: dict[str, Any], trial: Row) -> Row:
    """Learn from all observations; return 1 − R² of each learner, which is precise near a perfect fit."""
    curves, _ = _learning_curves(
        objects.true_model_text(settings["thing"]),
        objects.fit_model_text(settings["thing"]),
        settings["learners"],
        [settings["trained"]],
        (settings["reading"], trial["sigma"]),
        trial["seed"],
        tested=settings["tested"],
        starts=settings["starts"],
    )
    return {"missing": {name: 1 - curve[0] for name, curve in zip(settings["learners"], curves, strict=True)}}


def one_minus_r2(rows: Sequence[Row], sigma: float, learner: str) -> list[float]:
    """Return 1 − R² of each seed."""
    return [
        float("inf") if row["missing"][learner] is None else float(row["missing"][learner])
        for row in rows
        if row["sigma"] == sigma
    ]


def section(settings: dict[str, Any], rows: Sequence[Row]) -> Section:
    """Return the section."""
    names = [figure_style.NAMES[learner] for learner in settings["learners"]]
    lines = [
        [
            f"{sigma:g}",
            *(r2_text(median(one_minus_r2(rows, sigma, learner))) for learner in settings["learners"]),
        ]
        for sigma in settings["sigmas"]
    ]
    text = prose(
        "paper",
        FILE,
        trained=settings["trained"],
        tested=settings["tested"],
        seeds=settings["seeds"],
        table=table(["σ", *names], lines),
        verdict=verdict(settings, rows),
    )
    return Section(text, {"paper_fig8.png": lambda path: draw(path, settings, rows)})


def r2_text(found: Interval) -> str:
    """Return R² from 1 − R², with enough digits for its distance from one."""
    if found.high < 1e-3:
        return f"1 − {found.middle:.1e}" if found.high > MAX_ROUNDING_ERROR else "1"
    return f"{1 - found.middle:.4f} [{1 - found.high:.4f}, {1 - found.low:.4f}]"


def format_small(value: float) -> str:
    """Return a small number, or "0" below rounding errors."""
    return f"{value:.1e}" if value > MAX_ROUNDING_ERROR else "0"


def verdict(settings: dict[str, Any], rows: Sequence[Row]) -> str:
    """Return sentences on the noise from which on PBR is better, and on the noiseless case."""
    others = [learner for learner in settings["learners"] if learner != "pbr"]
    noisy = [sigma for sigma in settings["sigmas"] if sigma > 0]
    worse = [
        f"{figure_style.NAMES[learner]} at σ = {sigma:g}"
        for sigma in noisy
        for learner in others
        if median_difference(one_minus_r2(rows, sigma, "pbr"), one_minus_r2(rows, sigma, learner)).high >= 0
    ]
    robust = (
        "With noise PBR is more accurate than every baseline at every σ (paired by seed, the interval of the "
        "median difference does not reach zero)."
        if not worse
        else f"With noise PBR is more accurate than the baselines, except that the interval does not exclude "
        f"{', '.join(worse)}."
    )
    if 0.0 not in settings["sigmas"]:
        return robust
    without = ", ".join(
        f"{figure_style.NAMES[learner]} {format_small(median(one_minus_r2(rows, 0.0, learner)).middle)}"
        for learner in settings["learners"]
    )
    return f"{robust} Without noise (inset) 1 − R² is: {without}."


def draw(path: Path, settings: dict[str, Any], rows: Sequence[Row]) -> None:
    """Draw medians with bands of the middle 80 % of seeds, and the noiseless case as an inset."""
    figure, (axes,) = figure_style.sheet(1, 1, (7.2, 4.0))
    noisy = [sigma for sigma in settings["sigmas"] if sigma > 0]
    for learner in settings["learners"]:
        found = np.array([one_minus_r2(rows, sigma, learner) for sigma in noisy])
        low, middle, high = (1 - np.quantile(found, q, axis=1) for q in (0.9, 0.5, 0.1))
        colour = figure_style.COLOURS[learner]
        axes.fill_between(noisy, low, high, color=colour, alpha=0.15, linewidth=0)
        axes.plot(
            noisy,
            middle,
            color=colour,
            marker=figure_style.MARKERS[learner],
            markersize=4,
            label=figure_style.NAMES[learner],
        )
    axes.set(
        xscale="log",
        xlabel="σ, share of each channel's motion",
        ylabel="R² on noise-free pushes",
        ylim=(0.5, 1.01),
    )
    axes.legend(fontsize=8, frameon=False, loc="lower left")
    if 0.0 in settings["sigmas"]:
        draw_inset(axes.inset_axes((0.36, 0.12, 0.36, 0.4)), settings, rows)
    figure_style.save(figure, path)


def draw_inset(axes: Any, settings: dict[str, Any], rows: Sequence[Row]) -> None:
    """Draw 1 − R² without noise."""
    figure_style.plain(axes)
    for k, learner in enumerate(settings["learners"]):
        values = np.maximum(one_minus_r2(rows, 0.0, learner), 1e-16)
        axes.bar(k, np.median(values), 0.7, color=figure_style.COLOURS[learner])
        axes.plot([k] * len(values), values, ".", color="black", markersize=2, alpha=0.5)
    axes.set(yscale="log", title="without noise: 1 − R²")
    axes.set_xticks(range(len(settings["learners"])), [""] * len(settings["learners"]))
    axes.title.set_fontsize(8)
    axes.tick_params(labelsize=7)
