"""Whether what is hidden matters: the nominal model refitted, and refitted with the true laws added."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import tomli_w

import trundle
from trundle.experiments.blind.family import HiddenEffect, Values
from trundle.experiments.blind.scene import Scene

__all__ = ["known_laws", "misfit", "nominal_misfit", "oracle_misfit"]


def misfit(figures: Mapping[str, Any], gyration: float) -> float:
    """Return the error one second ahead, m: of the position, and of the heading times `gyration`."""
    position, heading = figures["window_position_rmse"], figures["window_heading_rmse"]
    if position is None or heading is None:
        return math.inf
    return math.hypot(position, gyration * heading)


@cache
def known_laws() -> frozenset[str]:
    """Return the kinds of the catalogue."""
    return frozenset(str(effect["kind"]) for effect in trundle.effects())


def nominal_misfit(recording: trundle.Recording, scene: Scene) -> float:
    """Return the held-out misfit of the simulation under test, refitted."""
    return fit_misfit(recording, scene, [])


def oracle_misfit(recording: trundle.Recording, scene: Scene, hidden: Sequence[HiddenEffect]) -> float | None:
    """Return the held-out misfit with the true laws added and refitted; None where one has no law yet."""
    laws = [one.family.laws(scene, one.values) for one in hidden]
    if any(not found or any(law["kind"] not in known_laws() for law in found) for found in laws):
        return None
    return fit_misfit(recording, scene, [law for found in laws for law in found])


def fit_misfit(recording: trundle.Recording, scene: Scene, laws: Sequence[Values]) -> float:
    """Return the held-out misfit of one wheel and these laws.

    Infinite where nothing can be fitted. The oracle begins at the truth and stays near it. Without the laws
    the best values lie elsewhere, so that there the search begins elsewhere as well.
    """
    model, start = build_model(scene, laws)
    try:
        found = trundle.fit(recording, model, start=start, starts=0 if laws else 1)
    except trundle.TrundleError:
        return math.inf  # no fit at all: such a case is drawn again
    return misfit(found.summary["held_out"], scene.shape.gyration)


def build_model(scene: Scene, laws: Sequence[Values]) -> tuple[trundle.Model, dict[str, float]]:
    """Return the model with its values free, and their true values by name."""
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
    """Return the values of a law that the oracle knows, and those that it fits.

    It knows what a fit takes as given unless asked: an event's episode, a drift, a thing's radius.
    """
    known = default_parameters(law["kind"]) | {"spread"}
    named = {name: value for name, value in law.items() if name != "kind"}
    return {k: v for k, v in named.items() if k in known}, {k: v for k, v in named.items() if k not in known}


@cache
def default_parameters(kind: str) -> frozenset[str]:
    """Return the parameters of a kind that have a value where a model file leaves them out."""
    (found,) = [effect for effect in trundle.effects() if effect["kind"] == kind]
    return frozenset(p["name"] for p in found["parameters"] if p["default"] is not None)
