"""The training of a trial as a unit of work; needs `trundle[rl]`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from trundle.experiments.results import Row
from trundle.experiments.training.config import Dynamics, build
from trundle.experiments.training.dynamics.run import train
from trundle.experiments.training.train import Training

__all__ = ["training_trial"]

RESULTS = ("return", "untouched", "success", "lost")
"""Values of a learning curve that are results of a trial."""


def training_trial(table: dict[str, Any], seed: int, device: str, folder: Path) -> Row:
    """Train a trial, and return its results in the tuning worlds.

    Parameters
    ----------
    table : dict
        The content of the training's file.
    seed : int
    device : str
        Device of PyTorch.
    folder : Path
        Folder of the policy and of checkpoints, from which an interrupted trial continues.

    Returns
    -------
    dict
        `score`, the higher the better, further results, and the `cost`.
    """
    began = time.process_time()
    settings = build(folder / "trial.toml", table)
    if isinstance(settings, Dynamics):
        last = train(folder / "trial.toml", table, seed, folder, quiet=True)["errors"][-1]
        found = {"score": -last["distance"], "distance": last["distance"], "turn": last["turn"]}
    else:
        last = Training(settings, seed, folder, device).run()["curve"][-1]
        found = {"score": last["return"]} | {key: last[key] for key in RESULTS}
    return {**found, "cost": {"cpu_seconds": time.process_time() - began}}
