"""Metadata of the pneumatic seal data set, in both versions of the format."""

from __future__ import annotations

from typing import Any

__all__ = ["JOINT", "RAIL"]

NOTES = {
    "origin": "github.com/EvaZillen/3D-printed-pneumatic-actuator, "
    "results_pneumatic-actuator/data/friction; thesis, Delft University of Technology",
    "licence": "CC0 1.0",
    "motion": "imposed and slow: inertia is negligible, so open-loop positions are not meaningful",
    "episodes": "pairs of strokes, forth and back",
}
RAIL: dict[str, Any] = {
    "format": "trundle-recording/1",
    # All pairs but the first begin in the middle of the motion.
    "at_rest": False,
    "object": {"dof": ["x"]},
    "wrench": {
        "frame": "object",
        "reference": "object",
        "sign": "on_object",
        "raw": False,
        "contact": "grasp",
        "source": "measured",
    },
    "notes": {
        **NOTES,
        "force": "load cell minus pressure times bore area: the force that overcomes friction",
        "note_pressure": "gauge pressure, Pa",
    },
}
JOINT: dict[str, Any] = {
    "format": "trundle-recording/2",
    "mechanism": {"axis": "slide", "joints": ["piston"], "imposed": True},
    "effort": {"source": "measured", "gain": 1.0},
    "start": {"at_rest": False},
    "notes": {
        **NOTES,
        "effort": "load cell, N: positive towards greater position",
        "known": "minus pressure times bore area, N",
        "load": "gauge pressure, Pa: friction may depend on it",
    },
}
