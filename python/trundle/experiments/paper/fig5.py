"""Fig. 5: predicted pushes before learning, after fits with eq. 8, and after fits with eq. 9."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

import trundle
from trundle.experiments import figure_style
from trundle.experiments.markdown import prose, table
from trundle.experiments.paper import config, objects
from trundle.experiments.paper.experiment import Options, Section
from trundle.experiments.paper.scenario import open_loop, record
from trundle.experiments.results import Row
from trundle.experiments.sampling import Floats
from trundle.experiments.statistics import median
from trundle.model import Model
from trundle.picture import closed_outline, place_outline

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
    "more": list,
    "held_out": dict,
    "gripper": dict,
    "sensor": dict,
    "tracker": dict,
}
Method = Literal["before", "steps", "final", "filter", "dry"]
METHODS: dict[Method, str] = {
    "before": "before learning",
    "steps": "eq. 8",
    "final": "eq. 9",
    "filter": "trundle's default",
    "dry": "default, with dry friction",
}
"""In the order of the columns. The last two are not in the paper."""
OUTLINE_COUNT = 5
"""Number of outlines drawn of each episode."""


def settings(options: Options) -> dict[str, Any]:
    """Return the settings of the file and its objects."""
    found = config.select_settings(config.read(options.file(FILE), KNOWN), options)
    things = {name: objects.read_object(options.objects, name) for name in found["cases"]}
    return {**found, "things": things, "file": FILE, "quick": options.quick}


def trials(settings: dict[str, Any]) -> Sequence[Row]:
    """Return every case with every seed, learnt from one push and from all."""
    return [
        {"pushes": pushes, "case": case, "seed": seed}
        for pushes in (1, 1 + len(settings["more"]))
        for case in settings["cases"]
        for seed in range(settings["seeds"])
    ]


def perform(settings: dict[str, Any], trial: Row) -> Row:
    """Simulate pushes, learn from all but the last with each method, and predict the first and last."""
    thing = settings["things"][trial["case"]]
    recording = record(scenario(settings, trial), thing["body"], trial["seed"])
    found: Row = {}
    shown = (TRAINING_EPISODE, held_out_episode(trial))
    for way in METHODS:
        model, wheel = learn(recording, thing, way, settings, trial["seed"])
        poses = {name: pair for name, pair in open_loop(recording, model).items() if name in shown}
        found[way] = {"wheel": wheel, "errors": {name: final_errors(*pair) for name, pair in poses.items()}}
        if trial["seed"] == 0 and trial["pushes"] == 1:
            found[way]["drawn"] = {name: subsample(*pair) for name, pair in poses.items()}
    return found


def scenario(settings: dict[str, Any], trial: Row) -> dict[str, Any]:
    """Return the scenario of a trial: the paper's push, further pushes, and the held-out push."""
    thing = settings["things"][trial["case"]]
    rng = np.random.default_rng([trial["seed"], settings["cases"].index(trial["case"])])
    dry = {"kind": "support_friction", "force": settings["dry"][trial["case"]]}
    if "support" not in thing["body"]:
        dry["spread"] = 1.0
    main, last = (make_push(settings[which], settings["jitter"], rng) for which in ("push", "held_out"))
    more = [make_push(push, settings["jitter"], rng) for push in settings["more"][: trial["pushes"] - 1]]
    pushes = [main, *more, last]
    shared = {name: settings[name] for name in ("gripper", "sensor", "tracker")}
    return {"name": trial["case"], "held_out": 1, "effect": [*thing["effect"], dry], "push": pushes, **shared}


def make_push(push: dict[str, Any], jitter: Sequence[float], rng: np.random.Generator) -> dict[str, Any]:
    """Return a push at constant velocity, with a random offset of its grasp and direction."""
    x, y = push["grasp"]
    y += float(rng.uniform(-1, 1)) * jitter[0]
    heading = push["heading"] + float(rng.uniform(-1, 1)) * jitter[1]
    velocity = [push["speed"] * math.cos(heading), push["speed"] * math.sin(heading), 0.0]
    knots = [[0.0, 0.0, 0.0, 0.0], [0.5, *velocity], [push["duration"], *velocity]]
    return {"grasp": [x, y, 0.0], "drive": "velocity", "knots": knots}


def learn(
    recording: trundle.Recording, thing: dict[str, Any], way: Method, settings: dict[str, Any], seed: int
) -> tuple[Model, Row]:
    """Return the model of a method, and its wheel."""
    if way == "before":
        guess = settings["guess"]
        wheel = {"x": 0.0, "y": 0.0, "angle": 0.0, "mu_x": guess, "mu_y": guess}
        return Model.from_toml(config.model_text(thing["body"], [{"kind": "viscous_wheel", **wheel}])), wheel
    free = Model.from_toml(objects.fit_model_text(thing, ["support_friction"] if way == "dry" else []))
    likelihood = "filter" if way == "dry" else way
    fit = trundle.fit(recording, free, likelihood=likelihood, starts=settings["starts"], seed=seed)
    values = {p["name"].removeprefix("viscous_wheel."): p["value"] for p in fit.model.parameters}
    return fit.model, {name: values[name] for name in ("x", "y", "angle", "mu_x", "mu_y")}


def final_errors(observed: Floats, predicted: Floats) -> list[float]:
    """Return the error of the final pose (m, rad) and the distance travelled (m)."""
    dx, dy, turn = observed[-1] - predicted[-1]
    way = observed[-1] - observed[0]
    return [math.hypot(dx, dy), abs(math.remainder(turn, math.tau)), math.hypot(way[0], way[1])]


def subsample(observed: Floats, predicted: Floats) -> dict[str, list[list[float]]]:
    """Return the poses to draw."""
    kept = np.unique(np.linspace(0, len(observed) - 1, 41).astype(int))
    return {"observed": observed[kept].tolist(), "predicted": predicted[kept].tolist()}


TRAINING_EPISODE = "episode_00"


def held_out_episode(trial: Row) -> str:
    """Return the name of the held-out push."""
    return f"episode_{trial['pushes']:02d}"


PUSH_LABELS = {True: "learnt from", False: "held out"}
"""By whether the model was fitted to the push."""


def errors(rows: Sequence[Row], case: str, pushes: int, way: Method, known: bool, which: int) -> list[float]:
    """Return each seed's final error: 0 position, m; 1 heading, rad."""
    return [
        float(row[way]["errors"][TRAINING_EPISODE if known else held_out_episode(row)][which])
        for row in rows
        if row["case"] == case and row["pushes"] == pushes
    ]


def section(settings: dict[str, Any], rows: Sequence[Row]) -> Section:
    """Return the section."""
    all_pushes = 1 + len(settings["more"])
    head = ["object", "push", *METHODS.values()]
    text = prose(
        "paper",
        FILE,
        speed=settings["push"]["speed"],
        duration=settings["push"]["duration"],
        aside=math.degrees(settings["held_out"]["heading"]),
        force=settings["sensor"]["force_noise"],
        dry=", ".join(f"{objects.title(case)} {settings['dry'][case]:g} N" for case in settings["cases"]),
        seeds=settings["seeds"],
        table=table(head, errors_table(settings, rows, 1)),
        all_pushes=all_pushes,
        all_table=table(head, errors_table(settings, rows, all_pushes)),
        verdict=" ".join(verdict(settings, rows, 1, known) for known in PUSH_LABELS),
        all_verdict=verdict(settings, rows, all_pushes, False),
        steps_end=error_range(settings, rows, 1, ["steps"], True),
        final_end=error_range(settings, rows, 1, ["final"], True),
        final_end_all=error_range(settings, rows, all_pushes, ["final"], True),
        without=error_range(settings, rows, 1, ["steps", "final", "filter"], False),
        without_all=error_range(settings, rows, all_pushes, ["steps", "final", "filter"], False),
        with_dry=error_range(settings, rows, 1, ["dry"], False),
        with_dry_all=error_range(settings, rows, all_pushes, ["dry"], False),
    )
    return Section(text, {"paper_fig5.png": lambda path: draw(path, settings, rows)})


def errors_table(settings: dict[str, Any], rows: Sequence[Row], pushes: int) -> list[list[str]]:
    """Return two rows for each object."""
    return [
        [
            objects.title(case),
            name,
            *(
                error_cell(errors(rows, case, pushes, w, known, 0), errors(rows, case, pushes, w, known, 1))
                for w in METHODS
            ),
        ]
        for case in settings["cases"]
        for known, name in PUSH_LABELS.items()
    ]


def error_cell(position: Sequence[float], heading: Sequence[float]) -> str:
    """Return medians of position and heading errors with their intervals."""
    cm, degrees = median([100 * e for e in position]), median([math.degrees(e) for e in heading])
    one = [found.text(".0f" if found.middle >= 10 else ".2g") for found in (cm, degrees)]
    return f"{one[0]} cm, {one[1]}°"


def error_range(
    settings: dict[str, Any], rows: Sequence[Row], pushes: int, ways: Sequence[Method], known: bool
) -> str:
    """Return the range over objects and methods of the median final position error."""
    found = [
        median([100 * e for e in errors(rows, case, pushes, way, known, 0)]).middle
        for case in settings["cases"]
        for way in ways
    ]
    low, high = (format(value, ".0f" if value >= 10 else ".2g") for value in (min(found), max(found)))
    return f"{low} to {high} cm"


def verdict(settings: dict[str, Any], rows: Sequence[Row], pushes: int, known: bool) -> str:
    """Return a sentence that compares eq. 9 with eq. 8 and with no learning."""
    counts = []
    for case in settings["cases"]:
        ways: tuple[Method, ...] = ("final", "steps", "before")
        final, steps, before = (errors(rows, case, pushes, way, known, 0) for way in ways)
        better = sum(f < s for f, s in zip(final, steps, strict=True))
        learnt_ = sum(f < b for f, b in zip(final, before, strict=True))
        counts.append(f"{objects.title(case)} {better} and {learnt_}")
    return (
        f"On the push that was {PUSH_LABELS[known]}, the number of {settings['seeds']} seeds in which eq. 9 "
        f"is more accurate than eq. 8, and than no learning, is: {'; '.join(counts)}."
    )


def draw(path: Path, settings: dict[str, Any], rows: Sequence[Row]) -> None:
    """Draw the overlays after one push: two rows for each object, the fitted and the held-out push."""
    first = {row["case"]: row for row in rows if row["seed"] == 0 and row["pushes"] == 1}
    lines = [(case, known) for case in settings["cases"] for known in PUSH_LABELS]
    figure, axes = figure_style.sheet(len(lines), len(METHODS), (10.5, 1.75 * len(lines) + 0.3))
    for k, (case, known) in enumerate(lines):
        panels = axes[k * len(METHODS) : (k + 1) * len(METHODS)]
        for one, way in zip(panels, METHODS, strict=True):
            episode = TRAINING_EPISODE if known else held_out_episode(first[case])
            draw_overlay(one, settings["things"][case], first[case][way], episode)
            if k == 0:
                one.set_title(METHODS[way], fontsize=9)
        panels[0].set_ylabel(f"{objects.title(case)}\n{PUSH_LABELS[known]}", fontsize=8)
        share_limits(panels)
    figure_style.save(figure, path)


def draw_overlay(axes: Axes, thing: dict[str, Any], found: Row, episode: str) -> None:
    """Draw observed and predicted outlines and paths."""
    body, poses = thing["body"], found["drawn"][episode]
    shapes = [closed_outline(f) for f in body.get("fixture") or [{"polygon": body["footprint"]}]]
    for which, colour in (("observed", figure_style.OBSERVED), ("predicted", figure_style.PREDICTED)):
        way = np.asarray(poses[which], dtype=float)
        axes.plot(way[:, 0], way[:, 1], color=colour, linewidth=1.4)
        for share, k in enumerate(np.linspace(0, len(way) - 1, OUTLINE_COUNT).astype(int)):
            for shape in shapes:
                outline = place_outline(shape, way[k])
                axes.plot(
                    *outline.T, color=colour, linewidth=0.9, alpha=0.25 + 0.75 * share / (OUTLINE_COUNT - 1)
                )
    end = np.asarray(poses["predicted"][-1], dtype=float)
    axes.plot(
        *place_outline(np.array([[found["wheel"]["x"], found["wheel"]["y"]]]), end)[0], ".", color="black"
    )
    for effect in thing["effect"]:
        if effect["mu_x"] != effect["mu_y"]:
            seen = np.asarray(poses["observed"][-1], dtype=float)
            axes.plot(
                *place_outline(np.array([[effect["x"], effect["y"]]]), seen)[0],
                "x",
                color=figure_style.OBSERVED,
            )
    axes.tick_params(labelsize=6)


def share_limits(axes: Sequence[Axes]) -> None:
    """Give panels of one object the same limits, with equal scales of both axes."""
    x = [limit for one in axes for limit in one.get_xlim()]
    y = [limit for one in axes for limit in one.get_ylim()]
    for one in axes:
        one.set(xlim=(min(x), max(x)), ylim=(min(y), max(y)), aspect="equal")
