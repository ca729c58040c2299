"""The open-loop task: the model accuracy that a plan needs to end near its goal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import _open_loop
from trundle.experiments import figure_style
from trundle.experiments.markdown import prose, table
from trundle.experiments.paper import config, objects
from trundle.experiments.paper.experiment import Options, Section
from trundle.experiments.paper.wheel_position import outlines
from trundle.experiments.results import Row
from trundle.experiments.statistics import median
from trundle.picture import closed_outline, place_outline

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FILE = "open_loop"
TITLE = "Why 0.995: an open-loop task around an obstacle"

KNOWN: dict[str, type | tuple[type, ...]] = {
    "seeds": int,
    "objects": list,
    "steps": int,
    "holds": list,
    "axes": list,
    "length": float,
    "obstacle": float,
    "clearance": float,
    "reach": list,
    "sizes": list,
    "counts": list,
    "reading": str,
    "sigma": float,
    "tested": int,
    "threshold": float,
    "starts": int,
}
BANDS = [
    (-math.inf, 0.9),
    (0.9, 0.97),
    (0.97, 0.99),
    (0.99, 0.995),
    (0.995, 0.998),
    (0.998, 0.9995),
    (0.9995, 1.1),
]
"""Bands of R²."""


def settings(options: Options) -> dict[str, Any]:
    """Return the settings of the file and its objects."""
    found = config.select_settings(config.read(options.file(FILE), KNOWN), options)
    things = {name: objects.read_object(options.objects, name) for name in found["objects"]}
    return {**found, "things": things, "file": FILE, "quick": options.quick}


def trials(settings: dict[str, Any]) -> Sequence[Row]:
    """Return every object with every seed, for each way to hold a wrench."""
    return [
        {"hold": hold, "axes": axes, "object": name, "seed": seed}
        for hold in settings["holds"]
        for axes in settings["axes"]
        for name in settings["objects"]
        for seed in range(settings["seeds"])
    ]


def perform(settings: dict[str, Any], trial: Row) -> Row:
    """Plan on models of different accuracy, and execute each plan in open loop."""
    thing = settings["things"][trial["object"]]
    plans = _open_loop(
        objects.true_model_text(thing),
        objects.fit_model_text(thing),
        make_task(settings, thing, trial),
        settings["sizes"],
        settings["counts"],
        (settings["reading"], settings["sigma"]),
        trial["seed"],
        tested=settings["tested"],
        starts=settings["starts"],
    )
    flaws = [["off", size] for size in settings["sizes"]] + [
        ["learnt", count] for count in settings["counts"]
    ]
    kept = ("r2", "error", "planned", "touched", *(("expected", "poses") if trial["seed"] == 0 else ()))
    return {"runs": [{"flaw": f, **{k: run[k] for k in kept}} for f, run in zip(flaws, plans, strict=True)]}


def make_task(settings: dict[str, Any], thing: dict[str, Any], trial: Row) -> dict[str, Any]:
    """Return the task: forward past a square, alternately to its left and right."""
    corners = np.array([corner for polygon in outlines(thing["body"]) for corner in polygon])
    around = float(np.hypot(*corners.T).max())
    side, middle = settings["obstacle"] / 2, settings["length"] / 2
    beside = (-1.0) ** trial["seed"] * (side + around + settings["clearance"])
    square = [[middle - side, -side], [middle + side, -side], [middle + side, side], [middle - side, side]]
    return {
        "length": settings["length"],
        "beside": beside,
        "obstacle": square,
        "steps": settings["steps"],
        "hold": trial["hold"],
        "axes": trial["axes"],
        "reach": settings["reach"],
    }


def arriving_plans(settings: dict[str, Any], rows: Sequence[Row]) -> list[Row]:
    """Return the plans that reach the goal on their own model, with `share`: error over radius."""
    return [run for run in all_plans(settings, rows) if run["expected_share"] < MAX_PLANNED_ERROR]


MAX_PLANNED_ERROR = 0.1
"""Largest final error of a plan on its own model, as a share of the radius."""


def all_plans(settings: dict[str, Any], rows: Sequence[Row]) -> list[Row]:
    """Return every plan, including those that miss the goal on their own model."""
    return [
        {
            **run,
            "object": row["object"],
            "r2": -math.inf if run["r2"] is None else float(run["r2"]),
            "share": float(run["error"]) / settings["things"][row["object"]]["radius"],
            "expected_share": float(run["planned"]) / settings["things"][row["object"]]["radius"],
        }
        for row in rows
        for run in row["runs"]
    ]


def variants(settings: dict[str, Any]) -> list[tuple[float, str]]:
    """Return each way to hold a wrench: duration and axes. The first is the main one."""
    return [(hold, axes) for hold in settings["holds"] for axes in settings["axes"]]


def select_variant(rows: Sequence[Row], hold: float, axes: str) -> list[Row]:
    """Return the trials of a variant."""
    return [row for row in rows if row["hold"] == hold and row["axes"] == axes]


def section(settings: dict[str, Any], rows: Sequence[Row]) -> Section:
    """Return the section."""
    main = select_variant(rows, *variants(settings)[0])
    every = arriving_plans(settings, main)
    radius = {
        name: f"{objects.title(name)} {settings['things'][name]['radius']:g} m"
        for name in settings["objects"]
    }
    exact = [run["share"] for run in arriving_plans(settings, rows) if run["flaw"] == ["off", 0.0]]
    text = prose(
        "paper",
        FILE,
        steps=settings["steps"],
        hold=settings["holds"][0],
        length=settings["length"],
        obstacle=settings["obstacle"],
        largest_change=100 * max(settings["sizes"]),
        fewest=min(settings["counts"]),
        most=max(settings["counts"]),
        radii=", ".join(radius.values()),
        table=table(HEAD, bands(every)),
        exact=f"{median(exact).middle:.2g}",
        worst=max(exact),
        threshold=settings["threshold"],
        variants=table(VARIANTS_HEAD, variants_table(settings, rows)),
        objects=table(
            ["object", *(f"{hold:g} s, {AXES[axes]}" for hold, axes in variants(settings))],
            objects_table(settings, rows),
        ),
        answer=threshold_text(settings, rows),
        left_out=len(all_plans(settings, rows)) - len(arriving_plans(settings, rows)),
        plans=len(all_plans(settings, rows)),
        arrives=MAX_PLANNED_ERROR,
        force=settings["reach"][0],
        torque=settings["reach"][1],
    )
    return Section(text, {"paper_open_loop.png": lambda path: draw(path, settings, rows)})


HEAD = ["R² of the model", "plans", "final error over radius", "within the radius", "touched the obstacle"]
LIMITS = ["half do at R² =", "80 % do at R² ="]
VARIANTS_HEAD = ["each wrench is held", "axes", "within the radius at R² ≥ 0.995", *LIMITS]


def bands(every: Sequence[Row]) -> list[list[str]]:
    """Return a row for each band of R²."""
    lines = []
    for low, high in BANDS:
        those = [run for run in every if low <= run["r2"] < high]
        if those:
            name = f"{low:g} to {high:g}" if high < 1 else f"above {low:g}"
            name = f"below {high:g}" if low == -math.inf else name
            touched = percent(sum(run["touched"] for run in those), those)
            share = median([run["share"] for run in those]).text(".2g")
            lines.append([name, str(len(those)), share, success_text(those), touched])
    return lines


def success_text(those: Sequence[Row]) -> str:
    """Return the share of plans that end within the radius."""
    return percent(sum(run["share"] < 1 for run in those), those) if those else "no plans"


def percent(count: int, those: Sequence[Row]) -> str:
    """Return a share in percent."""
    return f"{100 * count / len(those):.0f} %"


def required_accuracy(every: Sequence[Row], share: float) -> float:
    """Return the smallest R² at which `share` of the plans end within the radius; NaN if there is none.

    The share is an isotonic regression of success on R².
    """
    ordered = sorted(every, key=lambda run: float(run["r2"]))
    rising = isotonic([float(run["share"] < 1) for run in ordered])
    good = np.flatnonzero(rising >= share)
    return float(ordered[good[0]]["r2"]) if good.size else math.nan


def isotonic(values: Sequence[float]) -> NDArray[np.float64]:
    """Return the non-decreasing least-squares fit to `values` (pool adjacent violators)."""
    pools: list[tuple[float, int]] = []
    for value in values:
        total, count = value, 1
        while pools and pools[-1][0] * count >= total * pools[-1][1]:
            total, count = total + pools[-1][0], count + pools[-1][1]
            pools.pop()
        pools.append((total, count))
    return np.concatenate([np.full(count, total / count) for total, count in pools] or [np.zeros(0)])


def accuracy_cells(settings: dict[str, Any], every: Sequence[Row]) -> list[str]:
    """Return the share within the radius at the paper's threshold, and the R² for shares of 50 and 80 %."""
    above = [run for run in every if run["r2"] >= settings["threshold"]]
    return [success_text(above), *(format_accuracy(required_accuracy(every, share)) for share in (0.5, 0.8))]


def format_accuracy(value: float) -> str:
    """Return a smallest R² as text."""
    if math.isnan(value):
        return "never"
    return "any" if value < 0 else f"{value:.5f}" if value > 0.995 else f"{value:.3f}"


def variants_table(settings: dict[str, Any], rows: Sequence[Row]) -> list[list[str]]:
    """Return a row for each way to hold a wrench."""
    return [
        [
            f"{hold:g} s",
            AXES[axes],
            *accuracy_cells(settings, arriving_plans(settings, select_variant(rows, hold, axes))),
        ]
        for hold, axes in variants(settings)
    ]


AXES = {"object": "turns with the object", "world": "keeps its direction in the world"}


def objects_table(settings: dict[str, Any], rows: Sequence[Row]) -> list[list[str]]:
    """Return for each object the share within the radius at the paper's threshold, by variant."""
    lines = []
    for name in settings["objects"]:
        own = [row for row in rows if row["object"] == name]
        each = [arriving_plans(settings, select_variant(own, *variant)) for variant in variants(settings)]
        lines.append([objects.title(name), *(accuracy_cells(settings, every)[0] for every in each)])
    return lines


def threshold_text(settings: dict[str, Any], rows: Sequence[Row]) -> str:
    """Return a sentence that compares the paper's threshold with the R² for shares of 50 and 80 %."""
    threshold = settings["threshold"]
    said = []
    for hold, axes in variants(settings):
        every = arriving_plans(settings, select_variant(rows, hold, axes))
        half, most = (required_accuracy(every, share) for share in (0.5, 0.8))
        position = (
            "above both" if threshold >= most else "between the two" if threshold >= half else "below both"
        )
        said.append(f"{position} for a wrench that {AXES[axes]} and is held for {hold:g} s")
    return f"{threshold} lies {'; '.join(said)}."


def draw(path: Path, settings: dict[str, Any], rows: Sequence[Row]) -> None:
    """Draw errors against accuracy, the share of successful plans, and the paths of one object."""
    figure, (scatter, share, ways) = figure_style.sheet(1, 3, (13.0, 3.9))
    main = select_variant(rows, *variants(settings)[0])
    every = arriving_plans(settings, main)
    for name, colour in zip(settings["objects"], PALETTE, strict=False):
        for flaw, marker in (("off", "o"), ("learnt", "^")):
            those = [r for r in every if r["object"] == name and r["flaw"][0] == flaw]
            x, y = [plotted_one_minus_r2(r) for r in those], [max(r["share"], 1e-3) for r in those]
            scatter.plot(x, y, marker, color=colour, markersize=3.5, alpha=0.55, markeredgewidth=0)
        scatter.plot([], [], "o", color=colour, label=objects.title(name))
    for (hold, axes), colour in zip(variants(settings), PALETTE, strict=False):
        label = f"{hold:g} s, {AXES[axes]}"
        share.plot(
            *success_curve(arriving_plans(settings, select_variant(rows, hold, axes))),
            color=colour,
            linewidth=1.5,
            label=label,
        )
    for one in (scatter, share):
        one.axvline(1 - settings["threshold"], color=figure_style.GREY, linestyle="--", linewidth=0.8)
        one.set(xscale="log", xlabel="1 − R² of the model (dashed: 0.005)", xlim=(1, 1e-7))
    scatter.axhline(1.0, color=figure_style.GREY, linewidth=0.8)
    scatter.set(yscale="log", ylabel="final error over radius")
    scatter.legend(fontsize=7, frameon=False, loc="lower left")
    share.set(ylabel="plans that end within the radius", ylim=(0, 1.35))
    share.legend(fontsize=7, frameon=False, loc="upper left")
    draw_paths(ways, settings, main)
    figure_style.save(figure, path)


PALETTE = ["#0059a8", "#c04a00", "#b0186f", "#2e8b57", "#5a6470"]


def plotted_one_minus_r2(run: Row) -> float:
    """Return 1 − R², limited to the range of the figure."""
    return float(min(max(1 - run["r2"], 1.2e-7), 0.98))


def success_curve(every: Sequence[Row]) -> tuple[list[float], list[float]]:
    """Return 1 − R² and the share of plans within the radius, over moving windows of accuracy."""
    ordered = sorted(every, key=lambda run: -run["r2"])
    window = max(len(ordered) // 8, 5)
    groups = [ordered[k : k + window] for k in range(0, len(ordered) - window + 1, max(window // 4, 1))]
    x = [float(np.exp(np.mean(np.log([plotted_one_minus_r2(r) for r in group])))) for group in groups]
    return x, [float(np.mean([r["share"] < 1 for r in group])) for group in groups]


def draw_paths(axes: Axes, settings: dict[str, Any], rows: Sequence[Row]) -> None:
    """Draw an object's paths under three models."""
    row = next(row for row in rows if row["seed"] == 0)
    thing = settings["things"][row["object"]]
    task = make_task(settings, thing, row)
    axes.fill(*np.array(task["obstacle"]).T, color="#c9ced4")
    shown = [run for run in row["runs"] if run["flaw"][0] == "off"]
    picked = [
        shown[0],
        min(shown, key=lambda r: abs((r["r2"] or 0) - 0.995)),
        min(shown, key=lambda r: abs((r["r2"] or 0) - 0.9)),
    ]
    for run, colour in zip(picked, ("#2e8b57", "#0059a8", "#c04a00"), strict=True):
        expected, poses = (np.asarray(run[key], dtype=float) for key in ("expected", "poses"))
        axes.plot(expected[:, 0], expected[:, 1], "--", color=colour, linewidth=0.8)
        axes.plot(poses[:, 0], poses[:, 1], color=colour, linewidth=1.4, label=f"R² = {run['r2']:.4f}")
        for fixture in thing["body"].get("fixture") or [{"polygon": thing["body"]["footprint"]}]:
            axes.plot(*place_outline(closed_outline(fixture), poses[-1]).T, color=colour, linewidth=0.9)
    angle = np.linspace(0, math.tau, 60)
    length, radius = settings["length"], thing["radius"]
    axes.plot(length + radius * np.cos(angle), radius * np.sin(angle), color="black", linewidth=0.8)
    axes.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    axes.set_title(objects.title(row["object"]), fontsize=9)
    axes.legend(fontsize=7, frameon=False)
