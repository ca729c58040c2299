"""Draw cases until the hidden effects are material, and record them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

import trundle
from trundle.experiments.blind.config import Settings
from trundle.experiments.blind.families import FAMILIES
from trundle.experiments.blind.family import HiddenEffect
from trundle.experiments.blind.geometry import visited_cells
from trundle.experiments.blind.instruments import make_recording
from trundle.experiments.blind.oracle import nominal_misfit, oracle_misfit
from trundle.experiments.blind.scene import Scene, draw_scene
from trundle.experiments.blind.score import INDISTINGUISHABLE_PAIR
from trundle.experiments.blind.world import Motion, simulate

__all__ = ["DrawnCase", "PlannedCase", "draw_case", "plan_cases", "plan_limits"]


INDISTINGUISHABLE_PAIRS = (INDISTINGUISHABLE_PAIR, {"second_wheel", "wheel_event"})
"""Pairs of effects that are never hidden together.

The data cannot distinguish the first pair. The second would hide two wheels of which one changes; two wheels
equal one wheel and a rotational damping only if neither changes.
"""


@dataclass(frozen=True)
class PlannedCase:
    """A case to draw: an uninformative name, its families, its seed, and the scale of the effect."""

    case: str
    names: tuple[str, ...]
    seed: int
    size: float = 1.0


@dataclass(frozen=True)
class DrawnCase:
    """A drawn case; `recording` is None if no draw was material."""

    recording: trundle.Recording | None
    answer: dict[str, Any]


def plan_cases(settings: Settings) -> list[PlannedCase]:
    """Return all cases in random order."""
    rng = np.random.default_rng([settings.first, 4])
    kinds: list[tuple[str, ...]] = [()] * settings.clean
    kinds += [(name,) for name in settings.effects for _ in range(settings.singles)]
    kinds += [(name,) for name in settings.foreign for _ in range(settings.foreigns)]
    pairs = [(a, b) for a, b in combinations(settings.effects, 2) if {a, b} not in INDISTINGUISHABLE_PAIRS]
    kinds += [pairs[int(rng.integers(len(pairs)))] for _ in range(settings.pairs)]
    order = rng.permutation(len(kinds))
    return [
        PlannedCase(f"case_{k:04}", kinds[i], settings.first + k, settings.size) for k, i in enumerate(order)
    ]


def plan_limits(settings: Settings) -> list[PlannedCase]:
    """Return the cases of the detection limits. Every scale has the same draws."""
    base = settings.first + 100_000
    cases = [
        (name, k, size)
        for name in settings.effects
        for k in range(settings.limited)
        for size in settings.sizes
    ]
    order = np.random.default_rng([base, 4]).permutation(len(cases))
    found = []
    for k, i in enumerate(order):
        name, number, size = cases[i]
        seed = base + 1000 * settings.effects.index(name) + number
        found.append(PlannedCase(f"case_{k:04}", (name,), seed, size))
    return found


def draw_case(planned: PlannedCase, settings: Settings) -> DrawnCase:
    """Draw a case until its effects are material."""
    for attempt in range(settings.attempts):
        scene = draw_scene(planned.seed, attempt, settings.episodes, alike=settings.alike)
        bare = [simulate(scene, [], k) for k in range(settings.episodes)]
        hidden = draw_effects(planned, scene, bare, attempt)
        if hidden is None:
            continue
        made, oracle = evaluate_oracle(scene, hidden, bare, planned.case)
        if not hidden or is_material(oracle, settings):
            return finish_case(planned, scene, hidden, made, {**oracle, "redraws": attempt})
    return DrawnCase(None, {"names": list(planned.names), "seed": planned.seed, "redraws": settings.attempts})


def draw_effects(
    planned: PlannedCase, scene: Scene, bare: Sequence[Motion], attempt: int
) -> list[HiddenEffect] | None:
    """Return the hidden effects with their values; None if an effect does not fit this scene."""
    paths = [one.pose for one in bare]
    hidden = []
    for k, name in enumerate(planned.names):
        rng = np.random.default_rng([planned.seed, attempt, 3, k])
        values = FAMILIES[name].draw(rng, scene, paths)
        if not values:
            return None
        hidden.append(HiddenEffect(FAMILIES[name], values))
    return hidden


def evaluate_oracle(
    scene: Scene, hidden: Sequence[HiddenEffect], bare: Sequence[Motion], name: str
) -> tuple[trundle.Recording, dict[str, Any]]:
    """Return the recording, and the held-out misfits of the nominal model and of the true models."""
    if not hidden:
        return make_recording(scene, [], bare, name), {}
    made = make_recording(scene, hidden, name=name)
    before, after = nominal_misfit(made, scene), oracle_misfit(made, scene, hidden)
    floor = nominal_misfit(make_recording(scene, [], bare), scene) if after is None else None
    singles = [oracle_misfit(made, scene, [one]) for one in hidden] if len(hidden) > 1 else []
    return made, {"before": before, "after": after, "floor": floor, "singles": singles}


def is_material(oracle: dict[str, Any], settings: Settings) -> bool:
    """Return whether the hidden effects of a case are material.

    If the catalogue has no law for an effect, the reference is the misfit of the nominal model on the same
    scene without the effect.
    """
    after = oracle["floor"] if oracle["after"] is None else oracle["after"]
    alone = [single for single in oracle["singles"] if single is not None]
    if not math.isfinite(oracle["before"]) or oracle["before"] < settings.matters * after:
        return False
    return all(single >= settings.each_matters * after for single in alone)


def finish_case(
    planned: PlannedCase,
    scene: Scene,
    hidden: list[HiddenEffect],
    made: trundle.Recording,
    oracle: dict[str, Any],
) -> DrawnCase:
    """Return the case, with the effects scaled to the planned size."""
    final = [one.scaled(planned.size) for one in hidden] if planned.size != 1.0 else hidden
    if final is not hidden:
        made = make_recording(scene, final, name=planned.case)
        oracle = {**oracle, "before": nominal_misfit(made, scene), "after": oracle_misfit(made, scene, final)}
    truth = [
        {"effect": one.family.name, **one.family.truth(scene, one.values), "values": one.values}
        for one in final
    ]
    answer = {
        "names": list(planned.names),
        "foreign": any(one.family.out_of_catalogue for one in final),
        "seed": planned.seed,
        "size": planned.size,
        "truth": truth,
        "oracle": oracle,
        "gyration": scene.shape.gyration,
        "mass": scene.mass,
        "mass_told": scene.mass_given,
        "feet_told": scene.feet_given,
        "shape": scene.shape.kind,
    }
    if "floor_patch" in planned.names:
        answer["visited"] = visited_cells(
            scene, [simulate(scene, final, k).pose for k in range(len(scene.pushes))]
        )
    return DrawnCase(made, answer)
