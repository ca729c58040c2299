"""Fig. 5: what a robot expects of a push before learning, with eq. 8, and with eq. 9."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

import trundle
from trundle.model import Model
from trundle.paper import config, objects, style
from trundle.paper.document import table
from trundle.paper.experiment import Options, Section, Show
from trundle.paper.results import Row
from trundle.paper.scenario import open_loop, record
from trundle.paper.sentences import fill
from trundle.paper.statistics import median
from trundle.picture import closed, place

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FILE = "fig5"
TITLE = "Fig. 5: a table with a locked wheel, a table with none, a utility cart"

KNOWN: dict[str, type | tuple[type, ...]] = {
    "seeds": int,
    "cases": list,
    "guess": float,
    "starts": int,
    "jitter": list,
    "dry": dict,
    "push": dict,
    "held_out": dict,
    "gripper": dict,
    "sensor": dict,
    "tracker": dict,
}
Way = Literal["before", "steps", "final", "filter"]
WAYS: dict[Way, str] = {
    "before": "before learning",
    "steps": "eq. 8",
    "final": "eq. 9",
    "filter": "trundle's default",
}
"""In the order of the columns; the last is not the paper's."""
OUTLINES = 5
"""Poses drawn of each episode."""


def settings(options: Options) -> dict[str, Any]:
    """Return the file's settings and its objects."""
    found = config.chosen(config.read(options.file(FILE), KNOWN), options)
    things = {name: objects.described(options.objects, name) for name in found["cases"]}
    return {**found, "things": things, "file": FILE, "quick": options.quick}


def trials(settings: dict[str, Any]) -> Sequence[Row]:
    """Return every case with every seed."""
    return [{"case": case, "seed": seed} for case in settings["cases"] for seed in range(settings["seeds"])]


def perform(settings: dict[str, Any], trial: Row, show: Show) -> Row:
    """Push twice; learn from the first push in each way, and predict both."""
    thing = settings["things"][trial["case"]]
    recording = record(scenario(settings, trial), thing["body"], trial["seed"])
    found: Row = {}
    for way in WAYS:
        show(WAYS[way])
        model, wheel = learnt(recording, thing, way, settings, trial["seed"])
        poses = open_loop(recording, model)
        found[way] = {"wheel": wheel, "errors": {name: miss(*pair) for name, pair in poses.items()}}
        if trial["seed"] == 0:
            found[way]["drawn"] = {name: thinned(*pair) for name, pair in poses.items()}
    return found


def scenario(settings: dict[str, Any], trial: Row) -> dict[str, Any]:
    """Return the scenario of a trial: the training push first, then the one that is held out."""
    thing = settings["things"][trial["case"]]
    rng = np.random.default_rng([trial["seed"], settings["cases"].index(trial["case"])])
    dry = {"kind": "support_friction", "force": settings["dry"][trial["case"]]}
    if "support" not in thing["body"]:
        dry["spread"] = 1.0
    pushes = [pushed(settings[which], settings["jitter"], rng) for which in ("push", "held_out")]
    shared = {name: settings[name] for name in ("gripper", "sensor", "tracker")}
    return {"name": trial["case"], "held_out": 1, "effect": [*thing["effect"], dry], "push": pushes, **shared}


def pushed(push: dict[str, Any], jitter: Sequence[float], rng: np.random.Generator) -> dict[str, Any]:
    """Return a push at constant velocity, its grasp and direction a little off."""
    x, y = push["grasp"]
    y += float(rng.uniform(-1, 1)) * jitter[0]
    heading = push["heading"] + float(rng.uniform(-1, 1)) * jitter[1]
    velocity = [push["speed"] * math.cos(heading), push["speed"] * math.sin(heading), 0.0]
    knots = [[0.0, 0.0, 0.0, 0.0], [0.5, *velocity], [push["duration"], *velocity]]
    return {"grasp": [x, y, 0.0], "drive": "velocity", "knots": knots}


def learnt(
    recording: trundle.Recording, thing: dict[str, Any], way: Way, settings: dict[str, Any], seed: int
) -> tuple[Model, Row]:
    """Return the model of a way, and its wheel."""
    if way == "before":
        guess = settings["guess"]
        wheel = {"x": 0.0, "y": 0.0, "angle": 0.0, "mu_x": guess, "mu_y": guess}
        return Model.from_toml(config.model_text(thing["body"], [{"kind": "viscous_wheel", **wheel}])), wheel
    free = Model.from_toml(objects.form(thing))
    fit = trundle.fit(recording, free, likelihood=way, starts=settings["starts"], seed=seed)
    values = {p["name"].removeprefix("viscous_wheel."): p["value"] for p in fit.model.parameters}
    return fit.model, {name: values[name] for name in ("x", "y", "angle", "mu_x", "mu_y")}


Floats = NDArray[np.float64]


def miss(observed: Floats, predicted: Floats) -> list[float]:
    """Return how far off the last pose is: m, rad, and m that the object went."""
    dx, dy, turn = observed[-1] - predicted[-1]
    way = observed[-1] - observed[0]
    return [math.hypot(dx, dy), abs(math.remainder(turn, math.tau)), math.hypot(way[0], way[1])]


def thinned(observed: Floats, predicted: Floats) -> dict[str, list[list[float]]]:
    """Return the poses that are drawn."""
    kept = np.unique(np.linspace(0, len(observed) - 1, 41).astype(int))
    return {"observed": observed[kept].tolist(), "predicted": predicted[kept].tolist()}


TRAINING, HELD_OUT = "episode_00", "episode_01"


def errors(rows: Sequence[Row], case: str, way: Way, episode: str, which: int) -> list[float]:
    """Return each seed's final error: 0 position, m; 1 heading, rad."""
    return [
        math.inf if (e := row[way]["errors"][episode][which]) is None else float(e)
        for row in rows
        if row["case"] == case
    ]


def section(settings: dict[str, Any], rows: Sequence[Row]) -> Section:
    """Return the section."""
    dry = ", ".join(f"{objects.title(case)} {settings['dry'][case]:g} N" for case in settings["cases"])
    push, other = settings["push"], settings["held_out"]
    text = fill(
        FILE,
        speed=push["speed"],
        duration=push["duration"],
        aside=math.degrees(other["heading"]),
        force=settings["sensor"]["force_noise"],
        dry=dry,
        seeds=settings["seeds"],
        table=table(["object", "push", *WAYS.values()], errors_table(settings, rows)),
        verdict=verdict(settings, rows),
    )
    return Section(text, {"paper_fig5.png": lambda path: draw(path, settings, rows)})


def errors_table(settings: dict[str, Any], rows: Sequence[Row]) -> list[list[str]]:
    """Return two lines for each object."""
    lines = []
    for case in settings["cases"]:
        for episode, name in ((TRAINING, "learnt from"), (HELD_OUT, "held out")):
            cells = []
            for way in WAYS:
                cm = median([100 * e for e in errors(rows, case, way, episode, 0)])
                degrees = median([math.degrees(e) for e in errors(rows, case, way, episode, 1)])
                cells.append(f"{cm.text('.2g')} cm, {degrees.text('.2g')}°")
            lines.append([objects.title(case), name, *cells])
    return lines


def verdict(settings: dict[str, Any], rows: Sequence[Row]) -> str:
    """Say how eq. 9 compares with eq. 8 and with no learning."""
    said = []
    for episode, name in ((TRAINING, "On the push that was learnt from"), (HELD_OUT, "On the held-out push")):
        counts = []
        for case in settings["cases"]:
            final, steps, before = (
                errors(rows, case, way, episode, 0) for way in ("final", "steps", "before")
            )
            better = sum(f < s for f, s in zip(final, steps, strict=True))
            learnt_ = sum(f < b for f, b in zip(final, before, strict=True))
            counts.append(f"{objects.title(case)} {better} and {learnt_}")
        said.append(
            f"{name} eq. 9 ends nearer than eq. 8, and nearer than no learning, in so many of "
            f"{settings['seeds']} seeds: {'; '.join(counts)}."
        )
    return " ".join(said)


def draw(path: Path, settings: dict[str, Any], rows: Sequence[Row]) -> None:
    """Draw the overlays: a row an object, first the training push for each way, then the held-out one."""
    first = {row["case"]: row for row in rows if row["seed"] == 0}
    cases, columns = settings["cases"], [(way, e) for e in (TRAINING, HELD_OUT) for way in WAYS]
    figure, axes = style.sheet(len(cases), len(columns), (13.0, 2.1 * len(cases) + 0.6))
    for k, case in enumerate(cases):
        for j, (way, episode) in enumerate(columns):
            one = axes[k * len(columns) + j]
            overlay(one, settings["things"][case], first[case][way], episode)
            if k == 0:
                one.set_title(
                    ("learnt from: " if episode == TRAINING else "held out: ") + WAYS[way], fontsize=8
                )
            if j == 0:
                one.set_ylabel(objects.title(case))
        same_limits(axes[k * len(columns) : (k + 1) * len(columns)])
    style.save(figure, path)


def overlay(axes: Axes, thing: dict[str, Any], found: Row, episode: str) -> None:
    """Draw observed and predicted outlines and ways."""
    body, poses = thing["body"], found["drawn"][episode]
    shapes = [closed(f) for f in body.get("fixture") or [{"polygon": body["footprint"]}]]
    for which, colour in (("observed", style.OBSERVED), ("predicted", style.PREDICTED)):
        way = np.asarray(poses[which], dtype=float)
        axes.plot(way[:, 0], way[:, 1], color=colour, linewidth=1.4)
        for share, k in enumerate(np.linspace(0, len(way) - 1, OUTLINES).astype(int)):
            for shape in shapes:
                outline = place(shape, way[k])
                axes.plot(*outline.T, color=colour, linewidth=0.9, alpha=0.25 + 0.75 * share / (OUTLINES - 1))
    end = np.asarray(poses["predicted"][-1], dtype=float)
    axes.plot(*place(np.array([[found["wheel"]["x"], found["wheel"]["y"]]]), end)[0], ".", color="black")
    for effect in thing["effect"]:
        if effect["mu_x"] != effect["mu_y"]:
            seen = np.asarray(poses["observed"][-1], dtype=float)
            axes.plot(*place(np.array([[effect["x"], effect["y"]]]), seen)[0], "x", color=style.OBSERVED)
    axes.tick_params(labelsize=6)


def same_limits(axes: Sequence[Axes]) -> None:
    """Give panels of one object the same scale, a metre the same length along both axes."""
    x = [limit for one in axes for limit in one.get_xlim()]
    y = [limit for one in axes for limit in one.get_ylim()]
    for one in axes:
        one.set(xlim=(min(x), max(x)), ylim=(min(y), max(y)), aspect="equal")
