"""Draw a case of the benchmark of mechanisms until its effects are material, and record it."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trundle.experiments.blind.mechanism.families import CATALOGUE
from trundle.experiments.blind.mechanism.family import Family, HiddenEffect, Statistics, Values
from trundle.experiments.blind.mechanism.measurement import record
from trundle.experiments.blind.mechanism.oracle import effort_misfits
from trundle.experiments.blind.mechanism.outside import OUT_OF_CATALOGUE
from trundle.experiments.blind.mechanism.scene import SOURCES, Scene, draw_scene
from trundle.experiments.blind.mechanism.simulation import Motion, simulate
from trundle.experiments.blind.mechanism.wheels import robots_of
from trundle.experiments.blind.sealed import folder_digest
from trundle.recording import TrundleError

__all__ = ["FAMILIES", "allowed_sources", "draw"]

SCENE_STREAM, EFFECT_STREAM = 21, 22
FAMILIES = {**CATALOGUE, **OUT_OF_CATALOGUE}
SPRING_AND_BIAS = ("joint_spring", "effort_bias")
"""Both together at one joint equal a spring with another position at rest."""


def allowed_sources(names: Sequence[str]) -> tuple[str, ...]:
    """Return the sources of effort with which families can be hidden together."""
    return tuple(one for one in SOURCES if all(one in FAMILIES[name].sources for name in names))


def draw(planned: Values, options: Values, folder: Path) -> dict[str, Any]:
    """Draw a case, write its recording, and return the truth and all attempts.

    The true model's misfit is approximated by that of the nominal model on a recording of the same scene
    without the effects, with the same noise. Each of several effects is judged by a recording with it alone.
    Effects must show in the training and in the held-out episodes.
    """
    names, seed, engine = tuple(planned["names"]), planned["seed"], planned["engine"]
    families = [FAMILIES[name] for name in names]
    robots = robots_of(options.get("robots", ("own",)))
    common = {"case": planned["case"], "names": list(names), "seed": seed, "engine": engine}
    tried: list[Values] = []
    fixed = next((one.fixed for one in families if one.fixed), None)
    for attempt in range(options["attempts"]):
        rng = np.random.default_rng([seed, attempt, SCENE_STREAM])
        scene = draw_scene(rng, robots, allowed_sources(names), fixed)
        rng = np.random.default_rng([seed, attempt, EFFECT_STREAM])
        made = try_scene(rng, scene, families, engine, seed, options)
        tried.append({"reason": made["reason"], **classes(scene)})
        if made["reason"] is None:
            record(scene, made["hidden"], made["motions"], made["seen"].effort, seed, folder)
            truth = {
                "outside": any(one.out_of_catalogue for one in families),
                "truth": [one.truth(scene) for one in made["hidden"]],
                "oracle": made["oracle"],
                "robot": scene.robot.name,
                "instrument": {**classes(scene), **scene.instrument, "rate": scene.rate},
            }
            return {**common, **truth, "attempts": tried, "digest": folder_digest(folder)}
    return {**common, "attempts": tried, "digest": None}


def classes(scene: Scene) -> Values:
    """Return the classes of a scene."""
    return {"robot": scene.robot.name, "source": scene.source, "rate_class": f"{scene.rate} Hz"}


def try_scene(
    rng: np.random.Generator,
    scene: Scene,
    families: Sequence[Family],
    engine: str,
    seed: int,
    options: Values,
) -> Values:
    """Hide effects in a scene; return `reason`, `hidden`, `motions`, `seen` and `oracle`.

    The reason for rejection is None if the effects are material.
    """
    bare = simulate(engine, scene, [])
    if bare is None:
        return {"reason": "unstable"}
    seen = statistics(bare)
    hidden = draw_effects(rng, scene, families, seen)
    if hidden is None:
        return {"reason": "no place"}
    motions = simulate(engine, scene, hidden) if hidden else bare
    if motions is None:
        return {"reason": "unstable with the effects"}
    made: Values = {"reason": None, "hidden": hidden, "motions": motions, "seen": seen, "oracle": {}}
    if not hidden:
        return made
    try:
        after = misfits(scene, [], bare, seen, seed)
        before = misfits(scene, hidden, motions, seen, seed)
        alone = []
        if factor(before, after) >= options["matters"] and len(hidden) > 1:
            for one in hidden:
                motion = simulate(engine, scene, [one])
                found = after if motion is None else misfits(scene, [one], motion, seen, seed)
                alone.append(factor(found, after))
    except TrundleError as error:
        return {"reason": f"not measurable: {error}".split("/")[0][:80]}
    made["oracle"] = {
        "before": before[1],
        "after": after[1],
        "training": [before[0], after[0]],
        "alone": alone,
    }
    if factor(before, after) < options["matters"]:
        made["reason"] = "immaterial"
    elif any(one < options["each_matters"] for one in alone):
        made["reason"] = "one is immaterial"
    return made


def statistics(motions: Sequence[Motion]) -> Statistics:
    """Return the scales of motions."""
    effort, v = (np.concatenate([getattr(one, name) for one in motions]) for name in ("effort", "v"))
    return Statistics(
        np.sqrt(np.mean(effort**2, axis=0)),
        np.abs(effort).max(axis=0),
        np.sqrt(np.mean(v**2, axis=0)),
        np.concatenate([one.q for one in motions]),
    )


def draw_effects(
    rng: np.random.Generator, scene: Scene, families: Sequence[Family], seen: Statistics
) -> list[HiddenEffect] | None:
    """Draw joints and values; None if a family has no place."""
    found, split, biased = [], set(), set()
    for family in families:
        joint = int(rng.integers(scene.n))
        if family.name in SPRING_AND_BIAS:
            if joint in biased:
                return None
            biased.add(joint)
        if family.transmission is not None or family.level is not None:
            if joint in split:
                return None
            split.add(joint)
        values = family.draw(rng, scene, seen, joint)
        if values is None:
            return None
        found.append(HiddenEffect(family, {"joint": joint, **values}))
    return found


def factor(before: tuple[float, float], after: tuple[float, float]) -> float:
    """Return by how much the misfit rises, in training or held-out episodes, whichever is less."""
    return min(one / other for one, other in zip(before, after, strict=True))


def misfits(
    scene: Scene, hidden: Sequence[HiddenEffect], motions: Sequence[Motion], seen: Statistics, seed: int
) -> tuple[float, float]:
    """Return the misfits of the nominal model on a temporary recording, in training and held-out episodes."""
    with tempfile.TemporaryDirectory(prefix="trundle-oracle-") as temporary:
        folder = Path(temporary) / "recording"
        record(scene, hidden, motions, seen.effort, seed, folder)
        return effort_misfits(folder)
