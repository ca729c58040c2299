"""Diagnose a recording of joints, with the columns that MuJoCo computes along its motion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tomllib

from trundle import _native as compiled_module
from trundle.mechanism import Mechanism, Payload

__all__ = ["joint_answer", "load"]

_native: Any = compiled_module


def load(folder: Path) -> tuple[dict[str, Any], dict[str, Mechanism], dict[str, Any]]:
    """Return the settings of a recording, its mechanism by episode, and its smoothed motion."""
    settings = tomllib.loads((folder / "recording.toml").read_text(encoding="utf-8"))
    motion = _native._joint_motion(str(folder))
    mechanisms = {}
    for name in motion["episodes"]:
        given = settings.get("episode", {}).get(name, {}).get("payload")
        payload = Payload(given["body"], given["mass"], tuple(given["com"])) if given else None
        mechanisms[name] = Mechanism.load(folder / "robot.xml", motion["joints"], payload=payload)
    return settings, mechanisms, motion


def joint_answer(folder: Path, without: Sequence[str] = ()) -> dict[str, Any]:
    """Diagnose a recording; return the content of `diagnosis.json`."""
    _, mechanisms, motion = load(folder)
    first = next(iter(mechanisms.values()))
    bodies = list(first.bodies)
    dynamics: dict[str, Any] = {
        "bodies": bodies,
        "masses": [first.masses[body] for body in bodies],
        "armature": first.armature.tolist(),
        "damping": first.damping.tolist(),
        "frictionloss": first.frictionloss.tolist(),
        "gravity": [0.0, 0.0, -9.81],
        "is_hinge": [int(first.compiled.joint(joint).type[0]) == 3 for joint in motion["joints"]],
        "episodes": {},
    }
    for name, one in motion["episodes"].items():
        mechanism = mechanisms[name]
        found = mechanism.regressors(one["q"], one["v"], one["a"])
        own = np.einsum("tii->ti", found.mass_matrix) - mechanism.armature
        passive = found.friction + mechanism.armature * one["a"] + mechanism.damping * one["v"]
        dynamics["episodes"][name] = {
            "effort": np.ascontiguousarray(found.effort - passive),
            "own_inertia": np.ascontiguousarray(own),
            "mass": np.ascontiguousarray(np.stack([found.mass[body] for body in bodies], 2)),
            "gravity": found.gravity,
            "payload": np.ascontiguousarray(np.stack([found.payload[body] for body in bodies], 2)),
            "position": found.position,
        }
    answer: dict[str, Any] = _native._diagnose_joints(str(folder), dynamics, without=list(without)).answer
    return answer
