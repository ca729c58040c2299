"""Fig. 5: predicted pushes before learning, after fits with eq. 8, and after fits with eq. 9."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from operator import lt
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

import trundle
from trundle.experiments import figure_style
from trundle.experiments.markdown import table
from trundle.experiments.paper import experiment
from trundle.experiments.paper.experiment import TaskObject, build_model, product, title
from trundle.experiments.paper.scenario import record
from trundle.experiments.results import Row
from trundle.experiments.sampling import Floats
from trundle.experiments.statistics import median
from trundle.model import Model
from trundle.picture import outlines, place_outline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Method = Literal["before", "steps", "final", "filter", "dry"]
METHODS: dict[Method, str] = {
    "before": "before learning",
    "steps": "eq. 8",
    "final": "eq. 9",
    "filter": "trundle's default",
    "dry": "default, with dry friction",
}
"""In the order of the columns. The last two are not in the paper."""
PUSH_LABELS = {True: "learnt from", False: "held out"}
"""By whether the model was fitted to the push."""
OUTLINE_COUNT = 5
"""Number of outlines drawn of each episode."""

Errors = dict[tuple[int, str, bool, Method], tuple[list[float], list[float]]]
"""Final errors of all seeds, cm and degrees, by pushes, case, whether the push was fitted, method."""


@dataclass(frozen=True)
class Push:
    """A push at constant velocity: grasp (m, object frame), speed (m/s), heading (rad), duration (s)."""

    grasp: tuple[float, float]
    speed: float
    heading: float
    duration: float

    def scenario(self, jitter: tuple[float, float], rng: np.random.Generator) -> dict[str, Any]:
        """Return the push of a scenario, with a random offset (m, rad) of grasp and heading."""
        x, y = self.grasp
        y += float(rng.uniform(-1, 1)) * jitter[0]
        heading = self.heading + float(rng.uniform(-1, 1)) * jitter[1]
        velocity = [self.speed * math.cos(heading), self.speed * math.sin(heading), 0.0]
        knots = [[0.0, 0.0, 0.0, 0.0], [0.5, *velocity], [self.duration, *velocity]]
        return {"grasp": [x, y, 0.0], "drive": "velocity", "knots": knots}


@dataclass(frozen=True, kw_only=True)
class Settings(experiment.Settings):
    """Settings; `guess` is the damping before learning, N·s/m, and `dry` the friction of each case, N."""

    guess: float
    starts: int
    jitter: tuple[float, float]
    dry: dict[str, float]
    push: Push
    more: list[Push]
    held_out: Push
    gripper: dict[str, Any]
    sensor: dict[str, Any]
    tracker: dict[str, Any]


def trials(settings: Settings) -> Sequence[Row]:
    """Return every object with every seed, learnt from one push and from all."""
    counts = (1, 1 + len(settings.more))
    return product(pushes=counts, case=settings.objects, seed=range(settings.seeds))


def perform(settings: Settings, trial: Row) -> Row:
    """Simulate pushes, learn from all but the last with each method, and predict the first and last."""
    pushed = settings.task_objects[trial["case"]]
    recording = record(scenario(settings, trial), pushed.body, trial["seed"])
    found: Row = {}
    for method in METHODS:
        model, wheel = learn(recording, pushed, method, settings, trial["seed"])
        simulated = trundle.predict(recording, model)
        shown = {name: simulated[name] for name in episodes(trial).values()}
        poses = {name: (one.observed, one.predicted) for name, one in shown.items()}
        errors = {name: final_errors(*pair) for name, pair in poses.items()}
        found[method] = {"wheel": wheel, "errors": errors}
        if trial["seed"] == 0 and trial["pushes"] == 1:
            found[method]["drawn"] = {name: subsample(*pair) for name, pair in poses.items()}
    return found


def episodes(trial: Row) -> dict[bool, str]:
    """Return the names of the two evaluated episodes by whether the model is fitted to them."""
    return {True: "episode_00", False: f"episode_{trial['pushes']:02d}"}


def scenario(settings: Settings, trial: Row) -> dict[str, Any]:
    """Return the scenario of a trial: the paper's push, further pushes, and the held-out push."""
    case, pushed = trial["case"], settings.task_objects[trial["case"]]
    rng = np.random.default_rng([trial["seed"], settings.objects.index(case)])
    dry = {"kind": "support_friction", "force": settings.dry[case]}
    if "support" not in pushed.body:
        dry["spread"] = 1.0
    main, last, *more = (
        push.scenario(settings.jitter, rng)
        for push in (settings.push, settings.held_out, *settings.more[: trial["pushes"] - 1])
    )
    instruments = {name: getattr(settings, name) for name in ("gripper", "sensor", "tracker")}
    effects, pushes = [*pushed.effect, dry], [main, *more, last]
    return {"name": case, "held_out": 1, "effect": effects, "push": pushes, **instruments}


def learn(
    recording: trundle.Recording, pushed: TaskObject, method: Method, settings: Settings, seed: int
) -> tuple[Model, Row]:
    """Return the model of a method, and its wheel."""
    if method == "before":
        wheel = {"x": 0.0, "y": 0.0, "angle": 0.0, "mu_x": settings.guess, "mu_y": settings.guess}
        return build_model(pushed.body, [{"kind": "viscous_wheel", **wheel}]), wheel
    kinds = ["viscous_wheel", *(["support_friction"] if method == "dry" else [])]
    likelihood = "filter" if method == "dry" else method
    free = pushed.free_model(*kinds)
    fit = trundle.fit(recording, free, likelihood=likelihood, starts=settings.starts, seed=seed)
    values = {p["name"].removeprefix("viscous_wheel."): p["value"] for p in fit.model.parameters}
    return fit.model, {name: values[name] for name in ("x", "y", "angle", "mu_x", "mu_y")}


def final_errors(observed: Floats, predicted: Floats) -> list[float]:
    """Return the error of the final pose (m, rad) and the distance travelled (m)."""
    dx, dy, turn = observed[-1] - predicted[-1]
    x, y, _ = observed[-1] - observed[0]
    return [math.hypot(dx, dy), abs(math.remainder(turn, math.tau)), math.hypot(x, y)]


def subsample(observed: Floats, predicted: Floats) -> dict[str, list[list[float]]]:
    """Return the poses to draw."""
    shown = np.unique(np.linspace(0, len(observed) - 1, 41).astype(int))
    return {"observed": observed[shown].tolist(), "predicted": predicted[shown].tolist()}


def values(settings: Settings, rows: Sequence[Row]) -> dict[str, object]:
    """Return the values of the text."""
    errors, every = collect_errors(rows), 1 + len(settings.more)
    wrong: tuple[Method, ...] = ("steps", "final", "filter")
    return {
        "aside": math.degrees(settings.held_out.heading),
        "dry": ", ".join(f"{title(case)} {settings.dry[case]:g} N" for case in settings.objects),
        "table": errors_table(settings, errors, 1),
        "all_pushes": every,
        "all_table": errors_table(settings, errors, every),
        "verdict": " ".join(verdict(settings, errors, 1, fitted) for fitted in PUSH_LABELS),
        "all_verdict": verdict(settings, errors, every, False),
        "steps_end": error_range(settings, errors, 1, True, "steps"),
        "final_end": error_range(settings, errors, 1, True, "final"),
        "final_end_all": error_range(settings, errors, every, True, "final"),
        "without": error_range(settings, errors, 1, False, *wrong),
        "without_all": error_range(settings, errors, every, False, *wrong),
        "with_dry": error_range(settings, errors, 1, False, "dry"),
        "with_dry_all": error_range(settings, errors, every, False, "dry"),
    }


def collect_errors(rows: Sequence[Row]) -> Errors:
    """Return the final errors of all trials."""
    found: Errors = defaultdict(lambda: ([], []))
    for row in rows:
        for method in METHODS:
            for fitted, episode in episodes(row).items():
                position, heading, _ = row[method]["errors"][episode]
                cm, degrees = found[row["pushes"], row["case"], fitted, method]
                cm.append(100 * position)
                degrees.append(math.degrees(heading))
    return found


def errors_table(settings: Settings, errors: Errors, pushes: int) -> str:
    """Return a table with two rows for each object: medians of position and heading errors."""
    lines = []
    for case in settings.objects:
        for fitted, label in PUSH_LABELS.items():
            every = [[median(one) for one in errors[pushes, case, fitted, method]] for method in METHODS]
            texts = [[one.text(precision(one.middle)) for one in both] for both in every]
            lines.append([title(case), label, *(f"{cm} cm, {degrees}°" for cm, degrees in texts)])
    return table(["object", "push", *METHODS.values()], lines)


def precision(value: float) -> str:
    """Return the format of an error."""
    return ".0f" if value >= 10 else ".2g"


def error_range(settings: Settings, errors: Errors, pushes: int, fitted: bool, *methods: Method) -> str:
    """Return the range over objects and methods of the median final position error."""
    keys = [(pushes, case, fitted, method) for case in settings.objects for method in methods]
    found = [median(errors[key][0]).middle for key in keys]
    low, high = (format(value, precision(value)) for value in (min(found), max(found)))
    return f"{low} to {high} cm"


def verdict(settings: Settings, errors: Errors, pushes: int, fitted: bool) -> str:
    """Return a sentence that compares eq. 9 with eq. 8 and with no learning."""
    counts = []
    for case in settings.objects:
        final = errors[pushes, case, fitted, "final"][0]
        steps, before = errors[pushes, case, fitted, "steps"][0], errors[pushes, case, fitted, "before"][0]
        counts.append(f"{title(case)} {sum(map(lt, final, steps))} and {sum(map(lt, final, before))}")
    return (
        f"On the push that was {PUSH_LABELS[fitted]}, the number of {settings.seeds} seeds in which eq. 9 "
        f"is more accurate than eq. 8, and than no learning, is: {'; '.join(counts)}."
    )


def draw(settings: Settings, rows: Sequence[Row]) -> Figure:
    """Draw the overlays after one push: two rows for each object, the fitted and the held-out push."""
    first = {row["case"]: row for row in rows if row["seed"] == 0 and row["pushes"] == 1}
    lines = [(case, fitted) for case in settings.objects for fitted in PUSH_LABELS]
    figure, axes = figure_style.sheet(len(lines), len(METHODS), (10.5, 1.75 * len(lines) + 0.3))
    for one, method in zip(axes, METHODS, strict=False):
        one.set_title(METHODS[method], fontsize=9)
    for k, (case, fitted) in enumerate(lines):
        panels = axes[k * len(METHODS) : (k + 1) * len(METHODS)]
        for one, method in zip(panels, METHODS, strict=True):
            draw_overlay(one, settings.task_objects[case], first[case][method], episodes(first[case])[fitted])
        panels[0].set_ylabel(f"{title(case)}\n{PUSH_LABELS[fitted]}", fontsize=8)
        figure_style.share_limits(panels)
    return figure


def draw_overlay(axes: Axes, pushed: TaskObject, found: Row, episode: str) -> None:
    """Draw observed and predicted outlines and paths, and the true and the estimated wheel."""
    colours = {"observed": figure_style.OBSERVED, "predicted": figure_style.PREDICTED}
    poses = {which: np.asarray(found["drawn"][episode][which], dtype=float) for which in colours}
    for which, colour in colours.items():
        path = poses[which]
        axes.plot(path[:, 0], path[:, 1], color=colour, linewidth=1.4)
        for share, k in enumerate(np.linspace(0, len(path) - 1, OUTLINE_COUNT).astype(int)):
            opacity = 0.25 + 0.75 * share / (OUTLINE_COUNT - 1)
            for shape in outlines(pushed.body):
                axes.plot(*place_outline(shape, path[k]).T, color=colour, linewidth=0.9, alpha=opacity)
    estimated = np.array([found["wheel"]["x"], found["wheel"]["y"]])
    axes.plot(*place_outline(estimated, poses["predicted"][-1]), ".", color="black")
    for effect in pushed.effect:
        if effect["mu_x"] != effect["mu_y"]:
            true = np.array([effect["x"], effect["y"]])
            axes.plot(*place_outline(true, poses["observed"][-1]), "x", color=figure_style.OBSERVED)
    axes.tick_params(labelsize=6)
