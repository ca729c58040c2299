"""Refits of the nominal model and of the true model, which decide whether hidden effects are material.

The fits see the recording in one convention, the sensor's axes and origin, so that the published convention
does not decide whether a case is material.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import tomli_w

import trundle
from trundle.experiments.blind.family import HiddenEffect, Values
from trundle.experiments.blind.scene import Scene

__all__ = ["build_model", "misfit", "oracle_misfits", "rejection_reason"]

Record = Callable[[Scene, Sequence[HiddenEffect]], trundle.Recording]
"""Returns the recording of a simulated case, with hidden effects or without any."""


def misfit(figures: Mapping[str, Any], gyration: float) -> float:
    """Return the RMS error one second ahead in m: position, and heading times `gyration`."""
    position, heading = figures["window_position_rmse"], figures["window_heading_rmse"]
    if position is None or heading is None:
        return math.inf
    return math.hypot(position, gyration * heading)


def oracle_misfits(record: Record, scene: Scene, hidden: Sequence[HiddenEffect], matters: float) -> Values:
    """Return held-out misfits: of the nominal model, of the true model, and without one law at a time.

    If an effect has no law in the catalogue, there is no true model. The reference ("floor") is then the
    nominal misfit on the same scene without the effects.
    """
    scene = in_sensor_convention(scene)
    made = record(scene, hidden)
    before = fit_misfit(made, scene, [])
    after = true_misfit(made, scene, hidden)
    if after is None:
        return {"before": before, "floor": fit_misfit(record(scene, []), scene, [])}
    found: Values = {"before": before, "after": after}
    if len(hidden) > 1 and before >= matters * after:
        rest = [[other for other in hidden if other is not one] for one in hidden]
        found["without"] = [true_misfit(made, scene, others) for others in rest]
    return found


def rejection_reason(oracle: Values, matters: float, each_matters: float) -> str | None:
    """Return the reason why a case is not material, or None."""
    before: float = oracle["before"]
    after: float = oracle["after"] if "after" in oracle else oracle["floor"]
    if not math.isfinite(before) or not math.isfinite(after):
        return "no fit"
    if before < matters * after:
        return "too small"
    if any(one is None or one < each_matters * after for one in oracle.get("without", [])):
        return "one too small"
    return None


def in_sensor_convention(scene: Scene) -> Scene:
    """Return the scene with the same instrument, published in the sensor's axes about its origin."""
    published = replace(scene.instrument, frame="sensor", reference="sensor", sign="on_object")
    return replace(scene, instrument=published)


def true_misfit(made: trundle.Recording, scene: Scene, hidden: Sequence[HiddenEffect]) -> float | None:
    """Return the held-out misfit of the true model, refitted from the truth; None if an effect has no law."""
    laws = [one.laws(scene) for one in hidden]
    if any(not found or any(law["kind"] not in default_parameters() for law in found) for found in laws):
        return None
    for one in hidden:
        if one.family.merge_wheel is not None:
            scene = replace(scene, wheel=one.family.merge_wheel(scene.wheel, one.values))
    return fit_misfit(made, scene, [law for found in laws for law in found])


def fit_misfit(recording: trundle.Recording, scene: Scene, laws: Sequence[Values]) -> float:
    """Return the held-out misfit of one wheel and these laws; infinite if the fit fails.

    The oracle starts at the true values. Without the laws the optimum lies elsewhere, so the nominal fit uses
    one more start.
    """
    model, start = build_model(scene, laws)
    try:
        found = trundle.fit(recording, model, start=start, starts=0 if laws else 1)
    except trundle.TrundleError:
        return math.inf  # such a case is drawn again
    return misfit(found.summary["held_out"], scene.shape.gyration)


def build_model(scene: Scene, laws: Sequence[Values]) -> tuple[trundle.Model, dict[str, float]]:
    """Return the model with free values, and their true values by name."""
    body: dict[str, Any] = scene.shape.described(with_feet=scene.feet_given)
    start = {f"viscous_wheel.{name}": value for name, value in vars(scene.wheel).items()}
    if scene.mass_given:
        body["mass"] = scene.mass
    else:
        start["body.mass"] = scene.mass
    effects: list[Values] = [{"kind": "viscous_wheel"}]
    for law in laws:
        # Fixed is what has a default in a model file, such as an event's episode, a drift or a radius.
        fixed = default_parameters()[law["kind"]] | {"kind", "spread"}
        effects.append({name: value for name, value in law.items() if name in fixed})
        free = {name: value for name, value in law.items() if name not in fixed}
        start |= {f"{law['kind']}.{name}": float(value) for name, value in free.items()}
    text = tomli_w.dumps({"format": "trundle-model/1", "body": body, "effect": effects})
    return trundle.Model.from_toml(text), start


@cache
def default_parameters() -> dict[str, frozenset[str]]:
    """Return by kind of effect in the catalogue the parameters that have a default in a model file."""
    return {
        effect["kind"]: frozenset(p["name"] for p in effect["parameters"] if p["default"] is not None)
        for effect in trundle.effects()
    }
