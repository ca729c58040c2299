"""The position of the estimated wheel if the data contain dry friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import trundle
from trundle.experiments import figure_style
from trundle.experiments.markdown import prose, table
from trundle.experiments.paper import config, objects
from trundle.experiments.paper.experiment import Options, Section
from trundle.experiments.paper.scenario import record
from trundle.experiments.results import Row
from trundle.experiments.statistics import median
from trundle.model import Model

FILE = "wheel_position"
TITLE = "The wheel's position: a question that the paper left open"

KNOWN: dict[str, type | tuple[type, ...]] = {
    "seeds": int,
    "objects": list,
    "frictions": list,
    "wheel": list,
    "dry": list,
    "episodes": int,
    "held_out": int,
    "duration": float,
    "speed": float,
    "spin": float,
    "starts": int,
    "limit": float,
    "sensor": dict,
    "tracker": dict,
}
FORMS = {
    "wheel": ["viscous_wheel"],
    "support_friction": ["viscous_wheel", "support_friction"],
    "coulomb_friction": ["viscous_wheel", "coulomb_friction"],
}
"""The fitted models: the paper's, and the paper's with dry friction in two forms."""
PLACES = {"support_friction": "under the whole body", "coulomb_friction": "at one point"}


def settings(options: Options) -> dict[str, Any]:
    """Return the settings of the file and the bodies of its objects."""
    found = config.select_settings(config.read(options.file(FILE), KNOWN), options)
    folder = options.objects
    bodies = {name: objects.read_object(folder, name)["body"] for name in found["objects"]}
    return {**found, "bodies": bodies, "file": FILE, "quick": options.quick}


def trials(settings: dict[str, Any]) -> Sequence[Row]:
    """Return each seed under each friction."""
    return [
        {"friction": friction, "seed": seed}
        for seed in range(settings["seeds"])
        for friction in settings["frictions"]
    ]


def perform(settings: dict[str, Any], trial: Row) -> Row:
    """Hide a wheel and dry friction, record pushes, and fit every model."""
    seed = trial["seed"]
    name = settings["objects"][seed % len(settings["objects"])]
    body = settings["bodies"][name]
    hidden = draw_effects(settings, body, trial)
    recording = record(scenario(settings, hidden), body, seed)
    found: Row = {"object": name, "hidden": hidden, "fits": {}}
    for form, kinds in FORMS.items():
        found["fits"][form] = fit_form(recording, body, kinds, hidden[0], settings, seed)
    return found


def draw_effects(settings: dict[str, Any], body: dict[str, Any], trial: Row) -> list[dict[str, Any]]:
    """Return a hidden wheel and hidden dry friction, as tables of a scenario."""
    rng = np.random.default_rng([trial["seed"], settings["frictions"].index(trial["friction"])])
    wheel = {"kind": "viscous_wheel", **draw_point(rng, body), "angle": float(rng.uniform(0, math.pi))}
    wheel |= {name: draw_log_uniform(rng, settings["wheel"]) for name in ("mu_x", "mu_y")}
    dry: dict[str, Any] = {"kind": trial["friction"], "force": draw_log_uniform(rng, settings["dry"])}
    if trial["friction"] == "coulomb_friction":
        dry |= draw_point(rng, body)
    elif "support" not in body:
        dry["spread"] = 1.0  # uniform pressure under a flat face, which the model does not assume
    return [wheel, dry]


def draw_point(rng: np.random.Generator, body: dict[str, Any]) -> dict[str, float]:
    """Return a random place within the middle 90 % of the body's extent, m."""
    corners = np.array([corner for polygon in outlines(body) for corner in polygon])
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y = (low + high) / 2 + 0.9 * (rng.uniform(size=2) - 0.5) * (high - low)
    return {"x": float(x), "y": float(y)}


def outlines(body: dict[str, Any]) -> list[list[list[float]]]:
    """Return the corners of a body's parts; for a disc, of the square around it."""
    if "footprint" in body:
        return [body["footprint"]]
    pieces = []
    for fixture in body["fixture"]:
        if "polygon" in fixture:
            pieces.append(fixture["polygon"])
        else:
            x, y, r = fixture["disc"]
            pieces.append([[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]])
    return pieces


def draw_log_uniform(rng: np.random.Generator, limits: Sequence[float]) -> float:
    """Return a draw between two limits that is uniform in its logarithm."""
    low, high = limits
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def scenario(settings: dict[str, Any], hidden: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the scenario of a trial."""
    return {
        "name": "a hidden wheel",
        "held_out": settings["held_out"],
        "effect": hidden,
        "sensor": settings["sensor"],
        "tracker": settings["tracker"],
        "random": {
            "count": settings["episodes"],
            "duration": settings["duration"],
            "speed": settings["speed"],
            "spin": settings["spin"],
        },
    }


def fit_form(
    recording: trundle.Recording,
    body: dict[str, Any],
    kinds: list[str],
    wheel: dict[str, Any],
    settings: dict[str, Any],
    seed: int,
) -> Row:
    """Fit one model and compare its wheel with the hidden one."""
    unweighed = {key: value for key, value in body.items() if key != "mass"}
    model = Model.from_toml(config.model_text(unweighed, [{"kind": kind} for kind in kinds]))
    fit = trundle.fit(recording, model, starts=settings["starts"], seed=seed)
    by_name = {p["name"]: p for p in fit.summary["parameters"]}
    place = [by_name[f"viscous_wheel.{axis}"] for axis in "xy"]
    held = all(p["identifiable"] for p in place)
    error = math.hypot(place[0]["mean"] - wheel["x"], place[1]["mean"] - wheel["y"]) if held else None
    return {
        "error": error,
        "evidence": fit.summary["log_evidence"],
        "converged": fit.summary["converged"],
        "mass": by_name["body.mass"]["mean"],
        "one_second": fit.summary["held_out"]["window_position_rmse"],
        "final": fit.summary["held_out"]["final_position_error"],
    }


def preferred_form(row: Row) -> str:
    """Return the model with dry friction of greater evidence."""
    return max((f for f in FORMS if f != "wheel"), key=lambda f: float(row["fits"][f]["evidence"]))


def errors(rows: Sequence[Row], form: str) -> list[float]:
    """Return the wheel's errors of a model, m; infinite if the position is not identifiable."""
    picked = [row["fits"][preferred_form(row) if form == "chosen" else form]["error"] for row in rows]
    return [math.inf if error is None else float(error) for error in picked]


def section(settings: dict[str, Any], rows: Sequence[Row]) -> Section:
    """Return the section."""
    limit = settings["limit"]
    lines = []
    for friction in settings["frictions"]:
        those = [row for row in rows if row["friction"] == friction]
        for form, name in (("wheel", "a wheel alone"), ("chosen", "a wheel and dry friction")):
            found = errors(those, form)
            lines.append([PLACES[friction], name, *error_cells(found, limit), prediction_cell(those, form)])
    head = [
        "dry friction in the data",
        "model",
        "wheel off by, cm",
        "largest, cm",
        f"within {100 * limit:g} cm",
    ]
    right = sum(preferred_form(row) == row["friction"] for row in rows)
    text = prose(
        "paper",
        FILE,
        objects=", ".join(map(objects.title, settings["objects"])),
        least_mu=settings["wheel"][0],
        most_mu=settings["wheel"][1],
        least_dry=settings["dry"][0],
        most_dry=settings["dry"][1],
        fitted=settings["episodes"] - settings["held_out"],
        duration=settings["duration"],
        held_out=settings["held_out"],
        force=settings["sensor"]["force_noise"],
        right=right,
        trials=len(rows),
        table=table([*head, "1 s ahead, held out, mm"], lines),
        verdict=verdict(rows, settings),
        limit_cm=100 * settings["limit"],
    )
    return Section(text, {"paper_wheel_position.png": lambda path: draw_errors(path, rows, settings)})


def error_cells(found: Sequence[float], limit: float) -> list[str]:
    """Return median with interval, maximum, and the number within the limit."""
    within = sum(error <= limit for error in found)
    none = "not identifiable"
    worst = max(found)
    largest = f"{100 * worst:.2g}" if math.isfinite(worst) else none
    return [median([100 * e for e in found]).text(".2g", none), largest, f"{within} of {len(found)}"]


def prediction_cell(rows: Sequence[Row], form: str) -> str:
    """Return the held-out error one second ahead, mm."""
    picked = [row["fits"][preferred_form(row) if form == "chosen" else form]["one_second"] for row in rows]
    return median([1000 * float(value) for value in picked]).text(".2g")


def verdict(rows: Sequence[Row], settings: dict[str, Any]) -> str:
    """Say what the numbers say of the limit."""
    limit = settings["limit"]
    far = [(row, e) for row, e in zip(rows, errors(rows, "chosen"), strict=True) if e > limit]
    if not far:
        return (
            f"With dry friction in the model every wheel is within {100 * limit:g} cm; without it "
            f"{sum(e > limit for e in errors(rows, 'wheel'))} of {len(rows)} are not."
        )
    told = "; ".join(
        f"seed {row['seed']}, {row['object']}, {PLACES[row['friction']]}: "
        + ("not identifiable" if math.isinf(e) else f"{100 * e:.2g} cm")
        + ("" if preferred_form(row) == row["friction"] else ", the wrong form chosen")
        for row, e in far
    )
    return f"Not within {100 * limit:g} cm with dry friction in the model: {told}."


def draw_errors(path: Path, rows: Sequence[Row], settings: dict[str, Any]) -> None:
    """Draw every wheel's error, without and with dry friction in the model."""
    from matplotlib.ticker import MaxNLocator

    figure, axes = figure_style.sheet(1, len(settings["frictions"]), (7.2, 3.0))
    for one, friction in zip(axes, settings["frictions"], strict=True):
        those = [row for row in rows if row["friction"] == friction]
        before, after = (errors(those, form) for form in ("wheel", "chosen"))
        for k, pair in enumerate(zip(before, after, strict=True)):
            shown = [100 * e if math.isfinite(e) else np.nan for e in pair]
            one.plot([k, k], shown, color="#c9ced4", linewidth=1, zorder=1)
            one.plot(k, shown[0], marker="s", color=figure_style.COLOURS["lr"], linestyle="none")
            one.plot(k, shown[1], marker="o", color=figure_style.COLOURS["pbr"], linestyle="none")
        one.plot(
            [], [], marker="s", color=figure_style.COLOURS["lr"], linestyle="none", label="a wheel alone"
        )
        one.plot(
            [], [], marker="o", color=figure_style.COLOURS["pbr"], linestyle="none", label="and dry friction"
        )
        one.axhline(100 * settings["limit"], color=figure_style.GREY, linewidth=0.8, linestyle="--")
        one.set(yscale="log", ylim=(1e-3, 60), xlabel="seed", ylabel="wheel off by (cm)")
        one.set_title(f"dry friction {PLACES[friction]}", fontsize=9)
        one.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes[0].legend(fontsize=8, frameon=False, loc="lower left")
    figure_style.save(figure, path)
