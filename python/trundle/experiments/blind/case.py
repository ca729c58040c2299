"""Draw cases until the hidden effects are material, and record them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import trundle
from trundle.experiments.blind.family import Family, HiddenEffect, Values
from trundle.experiments.blind.oracle import oracle_misfits, rejection_reason
from trundle.experiments.blind.scene import Scene
from trundle.experiments.blind.sealed import folder_digest
from trundle.experiments.sampling import Floats

__all__ = ["Generator", "PlannedCase", "draw_case", "draw_effects"]

Motions = Sequence[Any]
"""Simulated episodes, in a form of the generator."""


@dataclass(frozen=True)
class PlannedCase:
    """A case to draw: an uninformative name, hidden families, a seed, an engine, the size of the effect."""

    case: str
    names: tuple[str, ...]
    seed: int
    engine: str = "mujoco"
    size: float = 1.0


@dataclass(frozen=True)
class Generator:
    """Functions that make recordings.

    Attributes
    ----------
    draw_scene : callable
        Returns the scene of an attempt, from the planned case and the options.
    families : dict
        Families of hidden effects by name.
    stream : int
        Stream of the random numbers of effects.
    paths : callable
        Returns the poses of each episode from contact on, or wrenches if the family reads them.
    is_allowed : callable
        Returns whether an effect can be hidden in a scene.
    simulate : callable
        Returns the motions of all episodes.
    is_usable : callable
        Returns whether the object moves as it should without the effects.
    record : callable
        Measures motions.
    describe : callable
        Returns what the truth holds in addition to the common values.
    """

    draw_scene: Callable[[PlannedCase, int, Values], Scene]
    families: Mapping[str, Family]
    stream: int
    paths: Callable[[Family, Motions], list[Floats]]
    is_allowed: Callable[[str, Scene], bool]
    simulate: Callable[[Scene, Sequence[HiddenEffect]], Motions]
    is_usable: Callable[[Motions], bool]
    record: Callable[[Scene, Sequence[HiddenEffect], Motions, str], trundle.Recording]
    describe: Callable[[PlannedCase, Scene, Sequence[HiddenEffect], Motions], Values]


def draw_effects(
    make: Generator, names: Sequence[str], seed: int, attempt: int, scene: Scene, bare: Motions
) -> list[HiddenEffect] | None:
    """Return families with their values; None if one does not fit this scene.

    Places are drawn from the motion without the effects.
    """
    if not all(make.is_allowed(name, scene) for name in names):
        return None
    hidden = []
    for k, family in enumerate(make.families[name] for name in names):
        rng = np.random.default_rng([seed, attempt, make.stream, k])
        values = family.draw(rng, scene, make.paths(family, bare))
        if not values:
            return None
        hidden.append(HiddenEffect(family, values))
    return hidden


def draw_case(make: Generator, case: Values, options: Values, folder: Path) -> dict[str, Any]:
    """Draw a case until it is material, write its recording, and return the truth and all attempts.

    The digest of the recording is None if no draw was material.
    """
    planned = PlannedCase(**{**case, "names": tuple(case["names"])})
    matters, each_matters = options["matters"], options["each_matters"]
    common = {
        "case": planned.case,
        "names": list(planned.names),
        "seed": planned.seed,
        "engine": planned.engine,
    }
    tried: list[Values] = []
    for attempt in range(options["attempts"]):
        scene = make.draw_scene(planned, attempt, options)
        bare = make.simulate(scene, [])
        hidden = draw_effects(make, planned.names, planned.seed, attempt, scene, bare)
        if hidden is None or not make.is_usable(bare):
            tried.append(attempt_record(scene, "no place" if hidden is None else "hardly moves"))
            continue
        seen, oracle, reason = make.simulate(scene, hidden) if hidden else bare, {}, None
        if hidden:
            oracle = oracle_misfits(recorder(make, seen, bare), scene, hidden, matters)
            reason = rejection_reason(oracle, matters, each_matters)
        tried.append(attempt_record(scene, reason))
        if reason is not None:
            continue
        if hidden and planned.size != 1.0:
            hidden = [one.scaled(planned.size) for one in hidden]
            seen = make.simulate(scene, hidden)
            oracle = oracle_misfits(recorder(make, seen, bare), scene, hidden, matters)
        make.record(scene, hidden, seen, planned.case).write(folder, table="parquet")
        truth = {**case_truth(scene, hidden, oracle), **make.describe(planned, scene, hidden, seen)}
        return {**common, **truth, "attempts": tried, "digest": folder_digest(folder)}
    return {**common, "attempts": tried, "digest": None}


def recorder(make: Generator, seen: Motions, bare: Motions) -> Callable[..., trundle.Recording]:
    """Return a function that measures the motions with the hidden effects, or those without any."""
    return lambda scene, hidden: make.record(scene, hidden, seen if hidden else bare, "oracle")


def attempt_record(scene: Scene, reason: str | None) -> Values:
    """Return the record of an attempt: the class of its instrument, and the reason for its rejection."""
    instrument = scene.instrument
    return {
        "reason": reason,
        "rate": instrument.rate_class,
        "noise": instrument.noise_class,
        "frame": instrument.frame,
        "contact": instrument.contact,
    }


def case_truth(scene: Scene, hidden: Sequence[HiddenEffect], oracle: Values) -> Values:
    """Return the truth that all generators have."""
    return {
        "outside": any(one.family.out_of_catalogue for one in hidden),
        "truth": [{"effect": one.family.name, **in_table_time(scene, one.truth(scene))} for one in hidden],
        "oracle": oracle,
        "gyration": scene.shape.gyration,
        "mass": scene.mass,
        "mass_told": scene.mass_given,
        "feet_told": scene.feet_given,
        "shape": scene.shape.kind,
    }


def in_table_time(scene: Scene, truth: Values) -> Values:
    """Return a truth with event times in the time of the table."""
    event = (truth["where"] or {}).get("event")
    if event is None or not scene.clock:
        return truth
    late = scene.clock[int(event["episode"].removeprefix("episode_"))]
    return {**truth, "where": {**truth["where"], "event": {**event, "time": event["time"] + late}}}
