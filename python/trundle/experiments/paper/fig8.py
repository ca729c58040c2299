"""Fig. 8: accuracy against noise for the shopping cart."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trundle._native import _learning_curves
from trundle.experiments import figure_style
from trundle.experiments.figure_style import COLOURS, MARKERS, NAMES
from trundle.experiments.markdown import table
from trundle.experiments.paper import experiment
from trundle.experiments.paper.experiment import product
from trundle.experiments.results import Row
from trundle.experiments.statistics import Interval, median, median_difference

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAX_ROUNDING_ERROR = 1e-14
"""Values of 1 − R² below this are rounding errors."""

Errors = dict[tuple[float, str], list[float]]
"""1 − R² of each seed by σ and learner."""


@dataclass(frozen=True, kw_only=True)
class Settings(experiment.Settings):
    """Settings; the first object is pushed, and the noise `sigmas` is interpreted as `reading` says."""

    learners: list[str]
    trained: int
    tested: int
    reading: str
    sigmas: list[float]
    starts: int


def trials(settings: Settings) -> Sequence[Row]:
    """Return every noise level with every seed."""
    return product(sigma=settings.sigmas, seed=range(settings.seeds))


def perform(settings: Settings, trial: Row) -> Row:
    """Learn from all observations; return 1 − R² of each learner, which is precise near a perfect fit."""
    pushed = settings.task_objects[settings.objects[0]]
    curves, _ = _learning_curves(
        pushed.true_model(),
        pushed.free_model(),
        settings.learners,
        [settings.trained],
        (settings.reading, trial["sigma"]),
        trial["seed"],
        tested=settings.tested,
        starts=settings.starts,
    )
    return {"missing": {name: 1 - curve[0] for name, curve in zip(settings.learners, curves, strict=True)}}


def values(settings: Settings, rows: Sequence[Row]) -> dict[str, object]:
    """Return the values of the text."""
    errors = collect_errors(rows)
    lines = [
        [f"{sigma:g}", *(r2_text(median(errors[sigma, learner])) for learner in settings.learners)]
        for sigma in settings.sigmas
    ]
    return {
        "table": table(["σ", *(NAMES[learner] for learner in settings.learners)], lines),
        "verdict": verdict(settings, errors),
    }


def collect_errors(rows: Sequence[Row]) -> Errors:
    """Return 1 − R² of all trials; infinite where R² is missing."""
    found: Errors = defaultdict(list)
    for row in rows:
        for learner, value in row["missing"].items():
            found[row["sigma"], learner].append(math.inf if value is None else value)
    return found


def r2_text(found: Interval) -> str:
    """Return R² from 1 − R², with enough digits for its distance from one."""
    if found.high < 1e-3:
        return f"1 − {found.middle:.1e}" if found.high > MAX_ROUNDING_ERROR else "1"
    return f"{1 - found.middle:.4f} [{1 - found.high:.4f}, {1 - found.low:.4f}]"


def verdict(settings: Settings, errors: Errors) -> str:
    """Return sentences on the noise from which on PBR is better, and on the noiseless case."""
    worse = [
        f"{NAMES[learner]} at σ = {sigma:g}"
        for sigma, learner in errors
        if sigma > 0 and learner != "pbr"
        if median_difference(errors[sigma, "pbr"], errors[sigma, learner]).high >= 0
    ]
    robust = (
        "With noise PBR is more accurate than every baseline at every σ (paired by seed, the interval of the "
        "median difference does not reach zero)."
        if not worse
        else f"With noise PBR is more accurate than the baselines, except that the interval does not exclude "
        f"{', '.join(worse)}."
    )
    middles = {learner: median(errors[0.0, learner]).middle for sigma, learner in errors if sigma == 0}
    without = ", ".join(
        f"{NAMES[learner]} {f'{middle:.1e}' if middle > MAX_ROUNDING_ERROR else '0'}"
        for learner, middle in middles.items()
    )
    return f"{robust} Without noise (inset) 1 − R² is: {without}." if without else robust


def draw(settings: Settings, rows: Sequence[Row]) -> Figure:
    """Draw medians with bands of the middle 80 % of seeds, and the noiseless case as an inset."""
    errors = collect_errors(rows)
    figure, (axes,) = figure_style.sheet(1, 1, (7.2, 4.0))
    noisy = [sigma for sigma in settings.sigmas if sigma > 0]
    for learner in settings.learners:
        found = np.array([errors[sigma, learner] for sigma in noisy])
        low, middle, high = (1 - np.quantile(found, q, axis=1) for q in (0.9, 0.5, 0.1))
        axes.fill_between(noisy, low, high, color=COLOURS[learner], alpha=0.15, linewidth=0)
        line = axes.plot(noisy, middle, color=COLOURS[learner], label=NAMES[learner])[0]
        line.set(marker=MARKERS[learner], markersize=4)
    axes.set(xscale="log", xlabel="σ, share of each channel's motion", ylim=(0.5, 1.01))
    axes.set(ylabel="R² on noise-free pushes")
    figure_style.legend(axes, loc="lower left")
    if 0.0 in settings.sigmas:
        draw_inset(axes.inset_axes((0.36, 0.12, 0.36, 0.4)), settings, errors)
    return figure


def draw_inset(axes: Axes, settings: Settings, errors: Errors) -> None:
    """Draw 1 − R² without noise."""
    figure_style.plain(axes)
    for k, learner in enumerate(settings.learners):
        shown = np.maximum(errors[0.0, learner], 1e-16)
        axes.bar(k, np.median(shown), 0.7, color=COLOURS[learner])
        axes.plot([k] * len(shown), shown, ".", color="black", markersize=2, alpha=0.5)
    axes.set(yscale="log", title="without noise: 1 − R²")
    axes.set_xticks(range(len(settings.learners)), [""] * len(settings.learners))
    axes.title.set_fontsize(8)
    axes.tick_params(labelsize=7)
