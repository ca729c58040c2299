"""Refits of the nominal model and of the true model, which decide whether an effect is material."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import tomli_w

import trundle
from trundle.experiments.blind.family import HiddenEffect, Values
from trundle.experiments.blind.scene import Scene

__all__ = ["known_laws", "misfit", "nominal_misfit", "oracle_misfit", "true_laws"]


def misfit(figures: Mapping[str, Any], gyration: float) -> float:
    """Return the RMS error one second ahead in m: position, and heading times `gyration`."""
    position, heading = figures["window_position_rmse"], figures["window_heading_rmse"]
    if position is None or heading is None:
        return math.inf
    return math.hypot(position, gyration * heading)


@cache
def known_laws() -> frozenset[str]:
    """Return the kinds of effects in the catalogue."""
    return frozenset(str(effect["kind"]) for effect in trundle.effects())


def nominal_misfit(recording: trundle.Recording, scene: Scene) -> float:
    """Return the held-out misfit of the refitted nominal model."""
    return fit_misfit(recording, scene, [])


def oracle_misfit(recording: trundle.Recording, scene: Scene, hidden: Sequence[HiddenEffect]) -> float | None:
    """Return the held-out misfit of the true model, refitted; None if an effect has no law."""
    laws = true_laws(scene, hidden)
    return None if laws is None else fit_misfit(recording, scene, laws)


def true_laws(scene: Scene, hidden: Sequence[HiddenEffect]) -> list[Values] | None:
    """Return the `[[effect]]` tables of the true model; None if an effect has no law in the catalogue."""
    laws = [one.family.laws(scene, one.values) for one in hidden]
    if any(not found or any(law["kind"] not in known_laws() for law in found) for found in laws):
        return None
    return [law for found in laws for law in found]


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
    body = scene.shape.described(with_feet=scene.feet_given)
    start = {f"viscous_wheel.{name}": value for name, value in vars(scene.wheel).items()}
    if scene.mass_given:
        body["mass"] = scene.mass
    else:
        start["body.mass"] = scene.mass
    effects: list[Values] = [{"kind": "viscous_wheel"}]
    for law in laws:
        kept, free = split_parameters(law)
        effects.append({"kind": law["kind"], **kept})
        start |= {f"{law['kind']}.{name}": float(value) for name, value in free.items()}
    text = tomli_w.dumps({"format": "trundle-model/1", "body": body, "effect": effects})
    return trundle.Model.from_toml(text), start


def split_parameters(law: Values) -> tuple[Values, Values]:
    """Return the values of a law that the oracle fixes, and those that it fits.

    It fixes parameters that have a default in a model file, such as an event's episode, a drift or a radius.
    """
    known = default_parameters(law["kind"]) | {"spread"}
    named = {name: value for name, value in law.items() if name != "kind"}
    return {k: v for k, v in named.items() if k in known}, {k: v for k, v in named.items() if k not in known}


@cache
def default_parameters(kind: str) -> frozenset[str]:
    """Return the parameters of a kind that have a default in a model file."""
    (found,) = [effect for effect in trundle.effects() if effect["kind"] == kind]
    return frozenset(p["name"] for p in found["parameters"] if p["default"] is not None)
