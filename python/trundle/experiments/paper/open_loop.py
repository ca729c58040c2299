"""The open-loop task: the model accuracy that a plan needs to end near its goal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import isotonic_regression

from trundle._native import _open_loop
from trundle.experiments import figure_style
from trundle.experiments.figure_style import GREY
from trundle.experiments.markdown import table
from trundle.experiments.paper import experiment
from trundle.experiments.paper.experiment import product, title
from trundle.experiments.results import Row
from trundle.experiments.statistics import median
from trundle.picture import outlines, place_outline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

R2_BANDS = (-math.inf, 0.9, 0.97, 0.99, 0.995, 0.998, 0.9995, 1.1)
"""Limits of bands of R²."""
MAX_PLANNED_ERROR = 0.1
"""Largest final error of a plan on its own model, as a share of the radius."""
AXES = {"object": "turns with the object", "world": "keeps its direction in the world"}
"""Axes of a held wrench."""
PALETTE = ["#0059a8", "#c04a00", "#b0186f", "#2e8b57", "#5a6470"]

Variant = tuple[float, str]
"""A way to hold a wrench: duration, s, and axes."""


@dataclass(frozen=True, kw_only=True)
class Settings(experiment.Settings):
    """Settings; the models have true values changed by `sizes`, or are learnt from `counts` observations."""

    steps: int
    holds: list[float]
    axes: list[str]
    length: float
    obstacle: float
    clearance: float
    reach: tuple[float, float]
    sizes: list[float]
    counts: list[int]
    reading: str
    sigma: float
    tested: int
    threshold: float
    starts: int

    @property
    def variants(self) -> list[Variant]:
        """Each way to hold a wrench. The first is the main one."""
        return [(hold, axes) for hold in self.holds for axes in self.axes]


def trials(settings: Settings) -> Sequence[Row]:
    """Return every object with every seed, for each way to hold a wrench."""
    seeds = range(settings.seeds)
    return product(hold=settings.holds, axes=settings.axes, object=settings.objects, seed=seeds)


def perform(settings: Settings, trial: Row) -> Row:
    """Plan on models of different accuracy, and execute each plan in open loop."""
    pushed = settings.task_objects[trial["object"]]
    plans = _open_loop(
        pushed.true_model(),
        pushed.free_model(),
        make_task(settings, trial),
        settings.sizes,
        settings.counts,
        (settings.reading, settings.sigma),
        trial["seed"],
        tested=settings.tested,
        starts=settings.starts,
    )
    flaws = [["off", size] for size in settings.sizes] + [["learnt", count] for count in settings.counts]
    kept = ("r2", "error", "planned", "touched", *(("expected", "poses") if trial["seed"] == 0 else ()))
    return {"runs": [{"flaw": f, **{k: run[k] for k in kept}} for f, run in zip(flaws, plans, strict=True)]}


def make_task(settings: Settings, trial: Row) -> dict[str, Any]:
    """Return the task: forward past a square, alternately to its left and right."""
    corners = np.concatenate(outlines(settings.task_objects[trial["object"]].body))
    around = float(np.hypot(*corners.T).max())
    side, middle = settings.obstacle / 2, settings.length / 2
    return {
        "length": settings.length,
        "offset": (-1.0) ** trial["seed"] * (side + around + settings.clearance),
        "obstacle": [[middle + x * side, y * side] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))],
        "steps": settings.steps,
        "hold": trial["hold"],
        "axes": trial["axes"],
        "max_wrench": settings.reach,
    }


def collect_plans(settings: Settings, rows: Sequence[Row]) -> list[Row]:
    """Return the plans that reach the goal on their own model.

    `share` is the final error over the radius; `lack` is 1 − R², limited to the range of the figure.
    """
    found = []
    for row in rows:
        radius, variant = settings.task_objects[row["object"]].radius, (row["hold"], row["axes"])
        for run in row["runs"]:
            r2 = -math.inf if run["r2"] is None else run["r2"]
            more = {"r2": r2, "lack": min(max(1 - r2, 1.2e-7), 0.98), "share": run["error"] / radius}
            if run["planned"] / radius < MAX_PLANNED_ERROR:
                found.append({**row, **run, **more, "variant": variant})
    return found


def select(plans: Sequence[Row], **wanted: Any) -> list[Row]:
    """Return the plans that have the wanted values."""
    return [plan for plan in plans if all(plan[key] == value for key, value in wanted.items())]


def values(settings: Settings, rows: Sequence[Row]) -> dict[str, object]:
    """Return the values of the text."""
    plans = collect_plans(settings, rows)
    radii = [f"{title(name)} {one.radius:g} m" for name, one in settings.task_objects.items()]
    exact = [plan["share"] for plan in select(plans, flaw=["off", 0.0])]
    count = sum(len(row["runs"]) for row in rows)
    by_variant, by_object, answer = accuracy_texts(settings, plans)
    return {
        "largest_change": 100 * max(settings.sizes),
        "fewest": min(settings.counts),
        "most": max(settings.counts),
        "radii": ", ".join(radii),
        "table": bands_table(select(plans, variant=settings.variants[0])),
        "exact": f"{median(exact).middle:.2g}",
        "worst": max(exact),
        "variants": by_variant,
        "objects": by_object,
        "answer": answer,
        "left_out": count - len(plans),
        "plans": count,
        "arrives": MAX_PLANNED_ERROR,
    }


def bands_table(plans: Sequence[Row]) -> str:
    """Return a table with a row for each band of R²."""
    lines = []
    for low, high in pairwise(R2_BANDS):
        band = [plan for plan in plans if low <= plan["r2"] < high]
        if band:
            name = f"{low:g} to {high:g}" if high < 1 else f"above {low:g}"
            name = f"below {high:g}" if low == -math.inf else name
            share = median([plan["share"] for plan in band]).text(".2g")
            touched = f"{100 * np.mean([plan['touched'] for plan in band]):.0f} %"
            lines.append([name, str(len(band)), share, success_text(band), touched])
    head = ["R² of the model", "plans", "final error over radius", "within the radius"]
    return table([*head, "touched the obstacle"], lines)


def success_text(plans: Sequence[Row]) -> str:
    """Return the share of plans that end within the radius."""
    return f"{100 * np.mean([plan['share'] < 1 for plan in plans]):.0f} %" if plans else "no plans"


def required_accuracy(plans: Sequence[Row], share: float) -> float:
    """Return the smallest R² at which `share` of the plans end within the radius; NaN if there is none.

    The share is an isotonic regression of success on R².
    """
    ordered = sorted(plans, key=lambda plan: float(plan["r2"]))
    if not ordered:
        return math.nan
    rising = isotonic_regression([float(plan["share"] < 1) for plan in ordered]).x
    good = np.flatnonzero(rising >= share)
    return float(ordered[good[0]]["r2"]) if good.size else math.nan


def accuracy_text(value: float) -> str:
    """Return a required R² as text."""
    if math.isnan(value):
        return "never"
    return "any" if value < 0 else f"{value:.5f}" if value > 0.995 else f"{value:.3f}"


def accuracy_texts(settings: Settings, plans: Sequence[Row]) -> tuple[str, str, str]:
    """Return tables of the success and required R² by variant and of the success by object, and a sentence.

    The success is that at the paper's threshold. The sentence compares the threshold with the required R².
    """
    threshold, lines, parts = settings.threshold, [], []
    accurate = [plan for plan in plans if plan["r2"] >= threshold]
    for hold, axes in settings.variants:
        those = select(plans, variant=(hold, axes))
        half, most = (required_accuracy(those, share) for share in (0.5, 0.8))
        success = success_text(select(accurate, variant=(hold, axes)))
        lines.append([f"{hold:g} s", AXES[axes], success, accuracy_text(half), accuracy_text(most)])
        place = (
            "above both" if threshold >= most else "between the two" if threshold >= half else "below both"
        )
        parts.append(f"{place} for a wrench that {AXES[axes]} and is held for {hold:g} s")
    head = ["each wrench is held", "axes", "within the radius at R² ≥ 0.995"]
    by_variant = table([*head, "half do at R² =", "80 % do at R² ="], lines)
    head = ["object", *(f"{hold:g} s, {AXES[axes]}" for hold, axes in settings.variants)]
    lines = [
        [
            title(name),
            *(success_text(select(accurate, object=name, variant=one)) for one in settings.variants),
        ]
        for name in settings.objects
    ]
    return by_variant, table(head, lines), f"{threshold} lies {'; '.join(parts)}."


def draw(settings: Settings, rows: Sequence[Row]) -> Figure:
    """Draw errors against accuracy, the share of successful plans, and the paths of one object."""
    figure, (scatter, share, paths) = figure_style.sheet(1, 3, (13.0, 3.9))
    plans = collect_plans(settings, rows)
    for name, colour in zip(settings.objects, PALETTE, strict=False):
        for flaw, marker in (("off", "o"), ("learnt", "^")):
            main = select(plans, object=name, variant=settings.variants[0])
            those = [plan for plan in main if plan["flaw"][0] == flaw]
            y = [max(plan["share"], 1e-3) for plan in those]
            x = [plan["lack"] for plan in those]
            scatter.plot(x, y, marker, color=colour, markersize=3.5, alpha=0.55, markeredgewidth=0)
        scatter.plot([], [], "o", color=colour, label=title(name))
    for (hold, axes), colour in zip(settings.variants, PALETTE, strict=False):
        curve = success_curve(select(plans, variant=(hold, axes)))
        share.plot(*curve, color=colour, linewidth=1.5, label=f"{hold:g} s, {AXES[axes]}")
    for one in (scatter, share):
        one.axvline(1 - settings.threshold, color=GREY, linestyle="--", linewidth=0.8)
        one.set(xscale="log", xlabel="1 − R² of the model (dashed: 0.005)", xlim=(1, 1e-7))
    scatter.axhline(1.0, color=GREY, linewidth=0.8)
    scatter.set(yscale="log", ylabel="final error over radius")
    figure_style.legend(scatter, fontsize=7, loc="lower left")
    share.set(ylabel="plans that end within the radius", ylim=(0, 1.35))
    figure_style.legend(share, fontsize=7, loc="upper left")
    draw_paths(paths, settings, next(row for row in rows if row["seed"] == 0))
    return figure


def success_curve(plans: Sequence[Row]) -> tuple[list[float], list[float]]:
    """Return 1 − R² and the share of plans within the radius, over moving windows of accuracy."""
    ordered = sorted(plans, key=lambda plan: -plan["r2"])
    window = max(len(ordered) // 8, 5)
    groups = [ordered[k : k + window] for k in range(0, len(ordered) - window + 1, max(window // 4, 1))]
    x = [float(np.exp(np.mean(np.log([plan["lack"] for plan in group])))) for group in groups]
    return x, [float(np.mean([plan["share"] < 1 for plan in group])) for group in groups]


def draw_paths(axes: Axes, settings: Settings, row: Row) -> None:
    """Draw an object's paths under three models."""
    pushed = settings.task_objects[row["object"]]
    axes.fill(*np.array(make_task(settings, row)["obstacle"]).T, color="#c9ced4")
    exact, *others = [run for run in row["runs"] if run["flaw"][0] == "off"]
    nearest = [
        min([exact, *others], key=lambda run: abs((run["r2"] or 0) - wanted)) for wanted in (0.995, 0.9)
    ]
    for run, colour in zip([exact, *nearest], ("#2e8b57", "#0059a8", "#c04a00"), strict=True):
        expected, poses = (np.asarray(run[key], dtype=float) for key in ("expected", "poses"))
        axes.plot(expected[:, 0], expected[:, 1], "--", color=colour, linewidth=0.8)
        axes.plot(poses[:, 0], poses[:, 1], color=colour, linewidth=1.4, label=f"R² = {run['r2']:.4f}")
        for outline in outlines(pushed.body):
            axes.plot(*place_outline(outline, poses[-1]).T, color=colour, linewidth=0.9)
    angle, radius = np.linspace(0, math.tau, 60), pushed.radius or math.nan
    axes.plot(settings.length + radius * np.cos(angle), radius * np.sin(angle), color="black", linewidth=0.8)
    axes.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    axes.set_title(title(row["object"]), fontsize=9)
    figure_style.legend(axes, fontsize=7)
