"""One more push of the same hidden object: the one that a diagnosis asks for, or one drawn at random."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import trundle
from trundle.experiments.blind.config import Settings
from trundle.experiments.blind.families import FAMILIES
from trundle.experiments.blind.family import HiddenEffect
from trundle.experiments.blind.instruments import episode_table
from trundle.experiments.blind.push import Grasp, Push, WrenchPush, draw_grasp, draw_push, low_excitation
from trundle.experiments.blind.scene import Scene, draw_scene
from trundle.experiments.blind.world import Motion, simulate
from trundle.experiments.results import Row

__all__ = ["DESIGNED", "extend_recording", "push_kinds", "requested_experiment", "restore_object"]

DESIGNED = "designed"
"""The push that the diagnosis asks for."""
RANDOM_SIMILAR = "as the others"
"""A control: a random push, drawn as those of the recording."""
RANDOM_UNRESTRICTED = "any grasp and heading"
"""A control where the others are alike: a random push that is not."""


def push_kinds(settings: Settings) -> tuple[str, ...]:
    """Return what is pushed: what is asked for, and the controls."""
    return (DESIGNED, RANDOM_SIMILAR, RANDOM_UNRESTRICTED) if settings.alike else (DESIGNED, RANDOM_SIMILAR)


def requested_experiment(answer: Row) -> Row | None:
    """Return the experiment that an answer asks for.

    Those that rather tell than not go first, of these such that are of a tie, of these the surest.

    Raises
    ------
    TrundleError
        If the answer was kept without its experiments.
    """
    if answer["verdict"] != "explained":
        return None
    if "experiments" not in answer:
        raise trundle.TrundleError("results of an earlier release do not hold the pushes; give --fresh")
    experiments: list[Row] = [one for one in answer["experiments"] if one["pushes"]]
    return max(experiments, key=lambda one: experiment_rank(one, answer["tied"]), default=None)


def experiment_rank(experiment: Row, tied: Sequence[Sequence[str]]) -> tuple[bool, bool, float]:
    """Return by what experiments are compared: a push that hardly tells goes after all others."""
    sure = float(experiment["sure"])
    return sure > 0.5, separates_tie(experiment["models"], tied), sure


def separates_tie(models: Sequence[str], tied: Sequence[Sequence[str]]) -> bool:
    """Tell whether two models differ in effects that are tied."""
    return any(all(set(model.split(" + ")) & set(group) for model in models) for group in tied)


def restore_object(truth: Row, settings: Settings) -> tuple[Scene, list[HiddenEffect]]:
    """Return the scene of a case, and what is hidden in it with values for one more episode."""
    attempt = truth["oracle"]["redraws"]
    scene = draw_scene(truth["seed"], attempt, settings.episodes, alike=settings.alike)
    rng = np.random.default_rng([truth["seed"], attempt, 5])
    hidden = []
    for one in truth["truth"]:
        family = FAMILIES[one["effect"]]
        hidden.append(HiddenEffect(family, family.extended(one["values"], rng)))
    return scene, hidden


def extend_recording(
    recording: trundle.Recording, scene: Scene, hidden: Sequence[HiddenEffect], kind: str, experiment: Row
) -> tuple[trundle.Recording, Row]:
    """Return a recording with one more training episode, whose noise is its own, and what that took."""
    number = len(scene.pushes)
    longer = replace(scene, pushes=(*scene.pushes, next_push(scene, kind, experiment)))
    true = simulate(longer, hidden, number)
    tables = {**recording.episodes, f"episode_{number:02}": episode_table(longer, hidden, number, true)}
    return trundle.Recording(recording.metadata, tables), push_effort(true)


def push_effort(true: Motion) -> Row:
    """Return what a push took: the largest force (N), and how far the object went (m) and turned (rad)."""
    moved = true.pose - true.pose[0]
    return {
        "force": float(np.hypot(*true.wrench[:, :2].T).max()),
        "distance": float(np.hypot(*moved[:, :2].T).max()),
        "turn": float(np.abs(moved[:, 2]).max()),
    }


def next_push(scene: Scene, kind: str, experiment: Row) -> Push | WrenchPush:
    """Return the push of a kind. The designed one depends on the answer alone, the others on the seed."""
    if kind == DESIGNED:
        return wrench_push(experiment["pushes"][0])
    rng = np.random.default_rng([scene.seed, 6])
    drawn = draw_push(rng, draw_grasp(rng, scene.shape))
    if kind == RANDOM_UNRESTRICTED:
        return drawn
    first = scene.pushes[0]
    turns = any(np.any(push.amplitude[2]) for push in scene.pushes if isinstance(push, Push))
    return drawn if turns else low_excitation(drawn, first)


def wrench_push(push: dict[str, Any]) -> WrenchPush:
    """Return a push of `trundle design` as the gripper makes it."""
    x, y, heading = push["start"]
    return WrenchPush(
        start=(x, y, heading),
        grasp=Grasp(push["grasp"][0], push["grasp"][1], push["direction"]),
        knots=np.asarray(push["knots"], dtype=float),
    )
