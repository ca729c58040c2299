"""Simulate scenarios that are defined in memory."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from trundle.recording import Recording
from trundle.simulation import simulate

__all__ = ["record"]


def record(scenario: Mapping[str, Any], body: Mapping[str, Any], seed: int) -> Recording:
    """Simulate a scenario (without `format` and `object`) on a body.

    Parameters
    ----------
    scenario : mapping
        The tables of a scenario file.
    body : mapping
        The table `[body]` of an object file.
    seed : int
        Random seed.
    """
    with tempfile.TemporaryDirectory(prefix="trundle-paper-") as name:
        folder = Path(name)
        described = {"format": "trundle-object/1", "name": "object", "body": dict(body)}
        (folder / "object.toml").write_text(tomli_w.dumps(described), encoding="utf-8")
        content = {"format": "trundle-scenario/1", "object": "object.toml", **scenario}
        (folder / "scenario.toml").write_text(tomli_w.dumps(content), encoding="utf-8")
        return simulate(folder / "scenario.toml", seed=seed)
