"""One more push of the same hidden object: the push that a diagnosis requests, or a random control."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import trundle
from trundle.experiments.blind.family import HiddenEffect
from trundle.experiments.blind.furniture.families import FAMILIES
from trundle.experiments.blind.furniture.scene import EPISODE_DURATION_S, draw_scene
from trundle.experiments.blind.furniture.simulation import Motion, episode_table, simulate
from trundle.experiments.blind.push import Grasp, Push, WrenchPush, draw_grasp, draw_push, low_excitation
from trundle.experiments.blind.scene import Scene
from trundle.experiments.results import Row

__all__ = ["DESIGNED", "extend_recording", "push_kinds", "requested_experiment", "restore_object"]

DESIGNED = "designed"
"""The push that the diagnosis requests."""
RANDOM_SIMILAR = "as the others"
"""Control: a random push drawn like those of the recording."""
RANDOM_UNRESTRICTED = "any grasp and heading"
"""Control for recordings of low excitation: a random push without their restrictions."""


def push_kinds(alike: bool) -> tuple[str, ...]:
    """Return the kinds of pushes: the requested one, and controls of recordings of low or high excitation."""
    return (DESIGNED, RANDOM_SIMILAR, RANDOM_UNRESTRICTED) if alike else (DESIGNED, RANDOM_SIMILAR)


def requested_experiment(answer: Row) -> Row | None:
    """Return the experiment that an answer requests.

    Experiments that more likely than not decide come first. Among these, experiments for a tie come first,
    then the most probable decision.

    Raises
    ------
    TrundleError
        If the results do not contain experiments.
    """
    if answer["verdict"] != "explained":
        return None
    if "experiments" not in answer:
        raise trundle.TrundleError("results of an earlier release have no experiments: rerun with --fresh")
    experiments: list[Row] = [one for one in answer["experiments"] if one["pushes"]]
    return max(experiments, key=lambda one: experiment_rank(one, answer["tied"]), default=None)


def experiment_rank(experiment: Row, tied: Sequence[Sequence[str]]) -> tuple[bool, bool, float]:
    """Return the sort key of an experiment; one that is unlikely to decide ranks last."""
    sure = float(experiment["sure"])
    return sure > 0.5, separates_tie(experiment["models"], tied), sure


def separates_tie(models: Sequence[str], tied: Sequence[Sequence[str]]) -> bool:
    """Return whether two models differ in effects that are tied."""
    return any(all(set(model.split(" + ")) & set(group) for model in models) for group in tied)


def restore_object(truth: Row, options: Row) -> tuple[Scene, list[HiddenEffect]]:
    """Return the scene of a case and its hidden effects with values for one more episode."""
    attempt = len(truth["attempts"]) - 1
    scene = draw_scene(truth["seed"], attempt, options["episodes"], alike=options["alike"])
    rng = np.random.default_rng([truth["seed"], attempt, 5])
    pairs = zip(truth["names"], truth["values"], strict=True)
    return scene, [HiddenEffect(FAMILIES[name], values).extended(rng) for name, values in pairs]


def extend_recording(
    recording: trundle.Recording, scene: Scene, hidden: Sequence[HiddenEffect], kind: str, experiment: Row
) -> tuple[trundle.Recording, Row]:
    """Return a recording with one more training episode with its own noise, and the effort of the push."""
    number = len(scene.pushes)
    push = next_push(scene, kind, experiment)
    longer = replace(scene, pushes=(*scene.pushes, push), seconds=(*scene.seconds, EPISODE_DURATION_S))
    true = simulate(longer, hidden, number)
    tables = {**recording.episodes, f"episode_{number:02}": episode_table(longer, hidden, number, true)}
    return trundle.Recording(recording.metadata, tables), push_effort(true)


def push_effort(true: Motion) -> Row:
    """Return the largest force (N), the largest displacement (m) and the largest rotation (rad) of a push."""
    moved = true.pose - true.pose[0]
    return {
        "force": float(np.hypot(*true.wrench[:, :2].T).max()),
        "distance": float(np.hypot(*moved[:, :2].T).max()),
        "turn": float(np.abs(moved[:, 2]).max()),
    }


def next_push(scene: Scene, kind: str, experiment: Row) -> Push | WrenchPush:
    """Return a push. The designed one depends on the answer alone, the others on the seed."""
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
    """Return a push of `trundle design` as commanded wrench."""
    x, y, heading = push["start"]
    return WrenchPush(
        start=(x, y, heading),
        grasp=Grasp(push["grasp"][0], push["grasp"][1], push["direction"]),
        knots=np.asarray(push["knots"], dtype=float),
    )
