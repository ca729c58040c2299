"""A case is drawn again until what is hidden in it counts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trundle.experiments.blind.family import Hidden
from trundle.experiments.blind.places import visited
from trundle.experiments.blind.sealed import folder_digest
from trundle.experiments.blind.seen import Seen
from trundle.experiments.wide.families import draw_hidden
from trundle.experiments.wide.measure import recorded, simulated
from trundle.experiments.wide.oracle import reason_to_reject, weigh
from trundle.experiments.wide.scene import WideScene, draw_wide_scene

__all__ = ["draw_case"]

LEAST_WAY = 0.05
"""Of the object in the median episode of a case that counts, m."""


def draw_case(
    case: str,
    names: list[str],
    engine: str,
    seed: int,
    matters: float,
    each_matters: float,
    attempts: int,
    folder: Path,
) -> dict[str, Any]:
    """Draw a case until it counts, write its recording, and return the truth and all attempts."""
    tried: list[dict[str, Any]] = []
    for attempt in range(attempts):
        scene = draw_wide_scene(seed, attempt, engine)
        bare = simulated(scene, [])
        hidden = draw_hidden(names, seed, attempt, scene, bare)
        if hidden is None or not moves(bare):
            tried.append(outcome(scene, "no place" if hidden is None else "hardly moves"))
            continue
        seen = simulated(scene, hidden) if hidden else bare
        made = recorded(scene, hidden, seen, case)
        oracle = weigh(scene, hidden, seen, bare, matters) if hidden else {}
        reason = reason_to_reject(oracle, matters, each_matters) if hidden else None
        tried.append(outcome(scene, reason))
        if reason is None:
            made.write(folder, table="parquet")
            return {
                **truth_of(case, names, scene, hidden, seen, oracle),
                "attempts": tried,
                "digest": folder_digest(folder),
            }
    return {"case": case, "names": names, "engine": engine, "seed": seed, "attempts": tried, "digest": None}


def moves(bare: Sequence[Seen]) -> bool:
    """Tell whether the object moves at all, and does not run off."""
    ways = [float(np.ptp(seen.pose[:, :2], axis=0).max()) for seen in bare]
    turns = [float(np.ptp(seen.pose[:, 2])) for seen in bare]
    return float(np.median(ways)) > LEAST_WAY and max(ways) < 20.0 and max(turns) < 60.0


def outcome(scene: WideScene, reason: str | None) -> dict[str, Any]:
    """Return what is reported of an attempt: the class of its instrument, and why it was rejected."""
    instrument: Any = scene.instrument
    return {
        "reason": reason,
        "rate": instrument.rate_class,
        "noise": instrument.noise_class,
        "frame": instrument.frame,
        "contact": instrument.contact,
    }


def truth_of(
    case: str,
    names: list[str],
    scene: WideScene,
    hidden: Sequence[Hidden],
    seen: Sequence[Seen],
    oracle: dict[str, Any],
) -> dict[str, Any]:
    """Return the sealed answer."""
    instrument: Any = scene.instrument
    found = {
        "case": case,
        "names": names,
        "outside": any(one.family.foreign for one in hidden),
        "engine": scene.engine,
        "seed": scene.seed,
        "instrument": instrument.plain(),
        "truth": [
            {
                "effect": one.family.name,
                **published(scene, one.family.truth(scene, one.values)),
                "values": one.values,
            }
            for one in hidden
        ],
        "oracle": oracle,
        "gyration": scene.shape.gyration,
        "mass": scene.mass,
        "mass_told": scene.mass_told,
        "feet_told": scene.feet_told,
        "wheel": vars(scene.wheel),
        "centroid": scene.shape.centroid.tolist(),
        "shape": scene.shape.kind,
        "episodes": len(scene.seconds),
        "seconds": list(scene.seconds),
        "held_out": scene.held_out,
    }
    if "floor_patch" in names:
        found["visited"] = visited(scene, [one.pose for one in seen])
    return found


def published(scene: WideScene, truth: dict[str, Any]) -> dict[str, Any]:
    """Return a truth with the times of the table."""
    where = truth.get("where") or {}
    if "event" not in where:
        return truth
    episode = int(where["event"]["episode"].removeprefix("episode_"))
    event = {**where["event"], "time": where["event"]["time"] + scene.clock[episode]}
    return {**truth, "where": {**where, "event": event}}
