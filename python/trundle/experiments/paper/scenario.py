"""Simulate scenarios that are defined in memory."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from trundle.experiments.sampling import Floats
from trundle.model import Model
from trundle.prediction import predict
from trundle.recording import Recording
from trundle.simulation import simulate

__all__ = ["open_loop", "record"]


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


def open_loop(recording: Recording, model: Model) -> dict[str, tuple[Floats, Floats]]:
    """Return for each episode the observed poses and those simulated in open loop, (n, 3) each, m, m, rad."""
    predictions = predict(recording, model)
    return {name: (one.observed, one.predicted) for name, one in predictions.items()}
