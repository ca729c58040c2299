"""Draw cases until the hidden effects are material, and record them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trundle.experiments.blind.family import HiddenEffect
from trundle.experiments.blind.geometry import visited_cells
from trundle.experiments.blind.readings import Readings
from trundle.experiments.blind.sealed import folder_digest
from trundle.experiments.wide.families import draw_effects
from trundle.experiments.wide.measurement import make_recording, simulate_case
from trundle.experiments.wide.oracle import oracle_misfits, rejection_reason
from trundle.experiments.wide.scene import WideScene, draw_wide_scene

__all__ = ["draw_case"]

MIN_MEDIAN_DISPLACEMENT_M = 0.05
"""Smallest displacement of the object in the median episode."""


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
    """Draw a case until it is material, write its recording, and return the truth and all attempts."""
    tried: list[dict[str, Any]] = []
    for attempt in range(attempts):
        scene = draw_wide_scene(seed, attempt, engine)
        bare = simulate_case(scene, [])
        hidden = draw_effects(names, seed, attempt, scene, bare)
        if hidden is None or not moves_enough(bare):
            tried.append(attempt_record(scene, "no place" if hidden is None else "hardly moves"))
            continue
        seen = simulate_case(scene, hidden) if hidden else bare
        made = make_recording(scene, hidden, seen, case)
        oracle = oracle_misfits(scene, hidden, seen, bare, matters) if hidden else {}
        reason = rejection_reason(oracle, matters, each_matters) if hidden else None
        tried.append(attempt_record(scene, reason))
        if reason is None:
            made.write(folder, table="parquet")
            return {
                **case_truth(case, names, scene, hidden, seen, oracle),
                "attempts": tried,
                "digest": folder_digest(folder),
            }
    return {"case": case, "names": names, "engine": engine, "seed": seed, "attempts": tried, "digest": None}


def moves_enough(bare: Sequence[Readings]) -> bool:
    """Return whether the object moves enough and stays within the workspace."""
    ways = [float(np.ptp(seen.pose[:, :2], axis=0).max()) for seen in bare]
    turns = [float(np.ptp(seen.pose[:, 2])) for seen in bare]
    return float(np.median(ways)) > MIN_MEDIAN_DISPLACEMENT_M and max(ways) < 20.0 and max(turns) < 60.0


def attempt_record(scene: WideScene, reason: str | None) -> dict[str, Any]:
    """Return the record of an attempt: the class of its instrument, and the reason for its rejection."""
    instrument: Any = scene.instrument
    return {
        "reason": reason,
        "rate": instrument.rate_class,
        "noise": instrument.noise_class,
        "frame": instrument.frame,
        "contact": instrument.contact,
    }


def case_truth(
    case: str,
    names: list[str],
    scene: WideScene,
    hidden: Sequence[HiddenEffect],
    seen: Sequence[Readings],
    oracle: dict[str, Any],
) -> dict[str, Any]:
    """Return the truth of a case."""
    instrument: Any = scene.instrument
    found = {
        "case": case,
        "names": names,
        "outside": any(one.family.out_of_catalogue for one in hidden),
        "engine": scene.engine,
        "seed": scene.seed,
        "instrument": instrument.plain(),
        "truth": [
            {
                "effect": one.family.name,
                **with_table_times(scene, one.family.truth(scene, one.values)),
                "values": one.values,
            }
            for one in hidden
        ],
        "oracle": oracle,
        "gyration": scene.shape.gyration,
        "mass": scene.mass,
        "mass_told": scene.mass_given,
        "feet_told": scene.feet_given,
        "wheel": vars(scene.wheel),
        "centroid": scene.shape.centroid.tolist(),
        "shape": scene.shape.kind,
        "episodes": len(scene.seconds),
        "seconds": list(scene.seconds),
        "held_out": scene.held_out,
    }
    if "floor_patch" in names:
        found["visited"] = visited_cells(scene, [one.pose for one in seen])
    return found


def with_table_times(scene: WideScene, truth: dict[str, Any]) -> dict[str, Any]:
    """Return a truth with event times in the time of the table."""
    where = truth.get("where") or {}
    if "event" not in where:
        return truth
    episode = int(where["event"]["episode"].removeprefix("episode_"))
    event = {**where["event"], "time": where["event"]["time"] + scene.clock[episode]}
    return {**truth, "where": {**where, "event": event}}
