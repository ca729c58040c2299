"""The scene of a run: its recordings, the goal, the obstacles, and the wheel that the agent estimates."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from trundle.experiments.runs import history
from trundle.experiments.runs.sentences import headline
from trundle.recording import TrundleError, read
from trundle.viewing.recorded import parse_shape, pose_panels, recorded_episodes, wrench_panels
from trundle.viewing.scene import Arrow, Curve, Episode, Motion, Panel, Scene, Wheel

__all__ = ["HISTORY_FILE", "closed_loop_scene"]

HISTORY_FILE = "history.json"
"""File of each finished episode of a run."""


def closed_loop_scene(folder: Path) -> Scene:
    """Return the scene of the folder that `trundle run` writes.

    Raises
    ------
    TrundleError
        If no episode is finished, or a file is damaged.
    """
    files = sorted(folder.glob(f"episode_*/{HISTORY_FILE}"))
    if not files:
        raise TrundleError(f"{folder}: no episode is finished; continue it with `trundle run`")
    lines = [f"# {folder.resolve().name}"]
    episodes = []
    for file in files:
        stored = read_history(file)
        played = history.parse_history(stored)
        episodes.append(closed_loop_episode(file.parent, stored, played))
        lines.append(f"{file.parent.name}: {headline(played)}")
    return Scene(folder.resolve().name, "\n\n".join(lines), episodes)


def read_history(file: Path) -> Mapping[str, Any]:
    """Read the history of an episode."""
    try:
        stored: Mapping[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:
        raise TrundleError(f"{file}: is damaged ({error}): delete it, and repeat `trundle run`") from error
    return stored


def closed_loop_episode(folder: Path, stored: Mapping[str, Any], played: history.Episode) -> Episode:
    """Return an episode with the readings of its recording; without one, with those at the agent's steps."""
    if (folder / "recording").is_dir():
        (episode,) = recorded_episodes(read(folder / "recording"))
    else:
        episode = observed_episode(stored, played)
    wheels = [] if played.wheel is None else [Wheel(played.wheel.at, played.wheel.angle)]
    points = {each.name: each.at for each in played.hidden if each.at is not None}
    distance = Curve("to the goal", "recorded", played.t[1:], played.distance[1:])
    return replace(
        episode,
        name=folder.name,
        shape=replace(episode.shape, wheels=wheels, points=points),
        panels=[
            *episode.panels,
            Panel("distance", "Distance to the goal, m", [distance]),
            *belief_panels(played),
        ],
        estimates=[
            (each.time, Wheel(each.wheel.at, each.wheel.angle))
            for each in played.updates
            if each.wheel is not None
        ],
        obstacles=[np.vstack([polygon, polygon[:1]]) for polygon in played.obstacles],
        goal=played.goal,
    )


def observed_episode(stored: Mapping[str, Any], played: history.Episode) -> Episode:
    """Return an episode from the observations of the agent, one per action."""
    motion = Motion(played.t, played.pose)
    pushed = Arrow(played.t[1:], played.grasp[1:], played.wrench[1:])
    return Episode(
        name="",
        held_out=False,
        contact=float("nan"),
        table={"t": played.t},
        shape=parse_shape(stored["object"]),
        motion=motion,
        arrows={"measured": pushed},
        panels=[*pose_panels(motion), *wrench_panels(pushed)],
    )


def belief_panels(played: history.Episode) -> list[Panel]:
    """Return the plot of the error of the estimated wheel's position."""
    errors = [(each.time, played.wheel_error(each)) for each in played.updates]
    known = np.array([(time, error) for time, error in errors if error is not None]).reshape(-1, 2)
    curve = Curve("estimated wheel", "after", known[:, 0], known[:, 1])
    return [Panel("wheel_error", "Error of the wheel's position, m", [curve])] if len(known) else []
