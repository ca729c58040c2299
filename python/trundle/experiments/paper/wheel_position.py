"""The position of the estimated wheel if the data contain dry friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np

import trundle
from trundle.experiments import figure_style
from trundle.experiments.markdown import table
from trundle.experiments.paper import experiment
from trundle.experiments.paper.experiment import TaskObject, product, title
from trundle.experiments.paper.scenario import record
from trundle.experiments.results import Row
from trundle.experiments.sampling import log_uniform
from trundle.experiments.statistics import median
from trundle.picture import outlines

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMS = {
    "wheel": ["viscous_wheel"],
    "support_friction": ["viscous_wheel", "support_friction"],
    "coulomb_friction": ["viscous_wheel", "coulomb_friction"],
}
"""The fitted models: the paper's, and the paper's with dry friction in two forms."""
PLACES = {"support_friction": "under the whole body", "coulomb_friction": "at one point"}
MODELS = {"wheel": "a wheel alone", "chosen": "a wheel and dry friction"}
"""The compared models: the paper's, and that of `preferred_form`."""


@dataclass(frozen=True, kw_only=True)
class Settings(experiment.Settings):
    """Settings; `wheel` and `dry` are ranges of damping, N·s/m, and force, N; `limit` is a distance, m."""

    frictions: list[str]
    wheel: tuple[float, float]
    dry: tuple[float, float]
    episodes: int
    held_out: int
    duration: float
    speed: float
    spin: float
    starts: int
    limit: float
    sensor: dict[str, Any]
    tracker: dict[str, Any]


def trials(settings: Settings) -> Sequence[Row]:
    """Return each seed under each friction."""
    every = product(friction=settings.frictions, seed=range(settings.seeds))
    return sorted(every, key=itemgetter("seed"))


def perform(settings: Settings, trial: Row) -> Row:
    """Hide a wheel and dry friction, record pushes, and fit every model."""
    seed = trial["seed"]
    name = settings.objects[seed % len(settings.objects)]
    pushed = settings.task_objects[name]
    hidden = draw_effects(settings, pushed.body, trial)
    recording = record(scenario(settings, hidden), pushed.body, seed)
    fits = {
        form: fit_form(recording, pushed, kinds, hidden[0], settings.starts, seed)
        for form, kinds in FORMS.items()
    }
    return {"object": name, "hidden": hidden, "fits": fits}


def draw_effects(settings: Settings, body: dict[str, Any], trial: Row) -> list[dict[str, Any]]:
    """Return a hidden wheel and hidden dry friction, as tables of a scenario."""
    rng = np.random.default_rng([trial["seed"], settings.frictions.index(trial["friction"])])
    wheel = {"kind": "viscous_wheel", **draw_point(rng, body), "angle": float(rng.uniform(0, math.pi))}
    wheel |= {name: log_uniform(rng, *settings.wheel) for name in ("mu_x", "mu_y")}
    dry: dict[str, Any] = {"kind": trial["friction"], "force": log_uniform(rng, *settings.dry)}
    if trial["friction"] == "coulomb_friction":
        dry |= draw_point(rng, body)
    elif "support" not in body:
        dry["spread"] = 1.0  # uniform pressure under a flat face, which the model does not assume
    return [wheel, dry]


def draw_point(rng: np.random.Generator, body: dict[str, Any]) -> dict[str, float]:
    """Return a random place within the middle 90 % of the body's extent, m."""
    corners = np.concatenate(outlines(body))
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y = (low + high) / 2 + 0.9 * (rng.uniform(size=2) - 0.5) * (high - low)
    return {"x": float(x), "y": float(y)}


def scenario(settings: Settings, hidden: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the scenario of a trial."""
    pushes = {name: getattr(settings, name) for name in ("duration", "speed", "spin")}
    shared = {name: getattr(settings, name) for name in ("held_out", "sensor", "tracker")}
    random = {"count": settings.episodes, **pushes}
    return {"name": "a hidden wheel", "effect": hidden, "random": random, **shared}


def fit_form(
    recording: trundle.Recording, pushed: TaskObject, kinds: list[str], wheel: Row, starts: int, seed: int
) -> Row:
    """Fit one model and compare its wheel with the hidden one."""
    fit = trundle.fit(recording, pushed.free_model(*kinds), starts=starts, seed=seed)
    by_name = {p["name"]: p for p in fit.summary["parameters"]}
    x, y = (by_name[f"viscous_wheel.{axis}"] for axis in "xy")
    known = x["identifiable"] and y["identifiable"]
    return {
        "error": math.hypot(x["mean"] - wheel["x"], y["mean"] - wheel["y"]) if known else None,
        "evidence": fit.summary["log_evidence"],
        "converged": fit.summary["converged"],
        "mass": by_name["body.mass"]["mean"],
        "one_second": fit.summary["held_out"]["window_position_rmse"],
        "final": fit.summary["held_out"]["final_position_error"],
    }


def preferred_form(row: Row) -> str:
    """Return the model with dry friction of greater evidence."""
    return max(PLACES, key=lambda form: float(row["fits"][form]["evidence"]))


def fit_of(row: Row, model: str) -> Row:
    """Return the fit of a model of `MODELS`."""
    found: Row = row["fits"][preferred_form(row) if model == "chosen" else model]
    return found


def errors_cm(rows: Sequence[Row], model: str) -> list[float]:
    """Return the wheel's errors of a model, cm; infinite if the position is not identifiable."""
    errors = [fit_of(row, model)["error"] for row in rows]
    return [math.inf if error is None else 100 * error for error in errors]


def values(settings: Settings, rows: Sequence[Row]) -> dict[str, object]:
    """Return the values of the text."""
    limit, lines = 100 * settings.limit, []
    for friction in settings.frictions:
        those = [row for row in rows if row["friction"] == friction]
        for model, name in MODELS.items():
            errors = errors_cm(those, model)
            within = f"{sum(error <= limit for error in errors)} of {len(errors)}"
            ahead = median([1000 * fit_of(row, model)["one_second"] for row in those]).text(".2g")
            middle = median(errors).text(".2g", "not identifiable")
            lines.append([PLACES[friction], name, middle, error_text(max(errors)), within, ahead])
    head = ["dry friction in the data", "model", "wheel off by, cm", "largest, cm", f"within {limit:g} cm"]
    return {
        "object_titles": ", ".join(map(title, settings.objects)),
        "fitted": settings.episodes - settings.held_out,
        "right": sum(preferred_form(row) == row["friction"] for row in rows),
        "trials": len(rows),
        "table": table([*head, "1 s ahead, held out, mm"], lines),
        "verdict": verdict(settings, rows),
        "limit_cm": limit,
    }


def error_text(error: float, unit: str = "") -> str:
    """Return an error in cm."""
    return f"{error:.2g}{unit}" if math.isfinite(error) else "not identifiable"


def verdict(settings: Settings, rows: Sequence[Row]) -> str:
    """Return a sentence on the wheels that are farther off than the limit."""
    limit = 100 * settings.limit
    far = [(row, error) for row, error in zip(rows, errors_cm(rows, "chosen"), strict=True) if error > limit]
    if not far:
        alone = sum(error > limit for error in errors_cm(rows, "wheel"))
        return (
            f"With dry friction in the model every wheel is within {limit:g} cm; without it "
            f"{alone} of {len(rows)} are not."
        )
    parts = [
        f"seed {row['seed']}, {row['object']}, {PLACES[row['friction']]}: {error_text(error, ' cm')}"
        + ("" if preferred_form(row) == row["friction"] else ", the wrong form chosen")
        for row, error in far
    ]
    return f"Not within {limit:g} cm with dry friction in the model: {'; '.join(parts)}."


def draw(settings: Settings, rows: Sequence[Row]) -> Figure:
    """Draw every wheel's error, without and with dry friction in the model."""
    from matplotlib.ticker import MaxNLocator

    figure, axes = figure_style.sheet(1, len(settings.frictions), (7.2, 3.0))
    styles = [("s", figure_style.COLOURS["lr"]), ("o", figure_style.COLOURS["pbr"])]
    for one, friction in zip(axes, settings.frictions, strict=True):
        those = [row for row in rows if row["friction"] == friction]
        errors = np.array([errors_cm(those, model) for model in MODELS])
        errors[np.isinf(errors)] = np.nan
        for k, pair in enumerate(errors.T):
            one.plot([k, k], pair, color="#c9ced4", linewidth=1, zorder=1)
            for error, (marker, colour) in zip(pair, styles, strict=True):
                one.plot(k, error, marker=marker, color=colour, linestyle="none")
        for (marker, colour), label in zip(styles, ("a wheel alone", "and dry friction"), strict=True):
            one.plot([], [], marker=marker, color=colour, linestyle="none", label=label)
        one.axhline(100 * settings.limit, color=figure_style.GREY, linewidth=0.8, linestyle="--")
        one.set(yscale="log", ylim=(1e-3, 60), xlabel="seed", ylabel="wheel off by (cm)")
        one.set_title(f"dry friction {PLACES[friction]}", fontsize=9)
        one.xaxis.set_major_locator(MaxNLocator(integer=True))
    figure_style.legend(axes[0], loc="lower left")
    return figure
