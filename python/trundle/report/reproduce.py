"""Data of the section "How to reproduce this report": command, version, seed and SHA-256 of the inputs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report.quantity import ABSENT, format_quantity

__all__ = ["reproduce"]


def reproduce(series: Mapping[str, Any]) -> dict[str, Any]:
    """Return the command, its version and seed, the inputs, and the assumed noise."""
    seed = series.get("seed")
    return {
        "command": str(series.get("command") or ""),
        "version": str(series.get("version") or ABSENT),
        "seed": str(seed) if isinstance(seed, int | str) else ABSENT,
        "fingerprints": [
            {
                "what": str(entry.get("what") or "input"),
                "sha256": str(entry["sha256"]),
                "check": str(entry.get("check") or ""),
            }
            for entry in series.get("input") or ()
            if isinstance(entry, Mapping) and entry.get("sha256")
        ],
        "noise": _noise(series.get("noise") or {}),
    }


def _noise(noise: Mapping[str, Any]) -> str:
    pose = noise.get("pose") or (None, None, None)
    origin = "stated by the recording" if noise.get("stated") else "estimated from the recording"
    position = " and ".join(dict.fromkeys((format_quantity("m", pose[0]), format_quantity("m", pose[1]))))
    heading, force = format_quantity("rad", pose[2]), format_quantity("N", noise.get("force"))
    torque = format_quantity("N·m", noise.get("torque"))
    return (
        f"standard deviations: position {position}, heading {heading}, force {force}, torque {torque} "
        f"({origin})"
    )
