"""Train dynamics models from their file; needs `trundle[rl]`."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from trundle._native import TrundleError
from trundle.atomic import read_json, write_text
from trundle.experiments import versions
from trundle.experiments.results import Row, rounded
from trundle.experiments.runner import Runner, Unit
from trundle.experiments.training.config import Dynamics, build
from trundle.experiments.training.dynamics.card import model_card
from trundle.experiments.training.dynamics.collect import Episodes, collect
from trundle.experiments.training.dynamics.errors import OPEN_LOOP_S, prediction_errors
from trundle.experiments.training.dynamics.fit import Data, Predictor, fit, scales_of
from trundle.experiments.training.dynamics.model import About, DynamicsModel, load
from trundle.experiments.training.settings import SEED_STRIDE
from trundle.experiments.training.worlds import action_period

__all__ = ["HISTORIES_S", "errors_of", "train"]

HISTORIES_S = (0.0, 1.0, 3.0)
"""Durations of the motion before the predictions whose errors are reported, s."""


def train(path: Path, table: Mapping[str, Any], seed: int, folder: Path, *, quiet: bool) -> Row:
    """Train the networks that have no result, and write `dynamics/NAME-SEED.npz` with its model card.

    The same settings and seed give the same model, however often the training is interrupted.

    Parameters
    ----------
    path : Path
        The training's file, for messages and for the default name.
    table : mapping
        Its content.
    seed : int
    folder : Path
        Folder of `dynamics/`, `timing/` and `work/`.
    quiet : bool
        Show no progress.

    Returns
    -------
    dict
        The content of `dynamics/NAME-SEED.json`: metadata, `parameters`, `errors` of the ensemble and
        `curves` of its networks.

    Raises
    ------
    TrundleError
        If the folder holds a model of this name with other settings.
    """
    settings = build_dynamics(path, table)
    name = f"{settings.name}-{seed}"
    file = folder / "dynamics" / f"{name}.npz"
    if file.exists() and file.with_suffix(".json").exists():
        result: Row = read_json(file.with_suffix(".json"))
        if result["digest"] != settings.digest:
            raise TrundleError(
                f"{file} has other settings: choose another --out, or remove {name}.npz and {name}.json"
            )
        return result
    work = folder / "work" / name
    units = []
    for number in range(settings.networks):
        arguments = {"table": {"name": settings.name, **table}, "seed": seed, "number": number}
        made = work / f"{number}.npz"
        units.append(Unit(f"network {number}", fit_unit, arguments, {"made": made}, made))
    found = Runner(work / "units", versions.of_package(), quiet=quiet).run(name, units)
    parts = [load(unit.folders["made"]) for unit in units]
    model = DynamicsModel(parts[0].about, parts[0].scales, [part.networks[0] for part in parts])
    model.save(file)
    errors = errors_of(model, evaluation_episodes(settings))
    about = {key: value for key, value in vars(model.about).items() if key != "period"}
    result = rounded(
        {**about, "parameters": model.parameters, "errors": errors, "curves": [one["curve"] for one in found]}
    )
    seconds = round(sum(one["cost"]["cpu_seconds"] for one in found), 1)
    timing = {"cpu_seconds": seconds, "torch": torch.__version__, "device": "cpu"}
    write_text(folder / "timing" / f"{name}.json", json.dumps(timing, indent=1) + "\n")
    write_text(file.with_suffix(".md"), model_card(settings, model, errors, torch.__version__))
    write_text(file.with_suffix(".json"), json.dumps(result, indent=1) + "\n")
    return result


def build_dynamics(path: Path, table: Mapping[str, Any]) -> Dynamics:
    """Return the settings of a file of a dynamics model."""
    settings = build(path, table)
    if not isinstance(settings, Dynamics):
        raise TrundleError(f'{path}: algorithm = "{settings.algorithm}": must be "Dynamics"')
    return settings


def fit_unit(table: dict[str, Any], seed: int, number: int, made: Path) -> Row:
    """Train one network as a unit of work, and write it to the file `made`.

    Parameters
    ----------
    table : dict
        The content of the training's file.
    seed, number : int
        Seed of the training, and number of the network.
    made : Path
    """
    torch.set_num_threads(1)
    settings, began = build_dynamics(made, table), time.process_time()
    data = training_data(settings, seed)
    scales, period = scales_of(data), action_period(settings)
    steps = int(data.valid.sum())
    about = About(
        settings.name,
        settings.digest,
        seed,
        steps,
        settings.n_updates,
        settings.env,
        settings.env_kwargs,
        period,
    )
    episodes, curve = evaluation_episodes(settings), []

    def show(update: int, predictor: Predictor) -> None:
        model = DynamicsModel(about, scales, [predictor.network()])
        curve.append({"update": update, "errors": errors_of(model, episodes)})

    network = fit(settings, data, scales, period, seed * SEED_STRIDE + number, show)
    DynamicsModel(about, scales, [network]).save(made)
    return {
        "curve": curve,
        "digest": hashlib.sha256(made.read_bytes()).hexdigest(),
        "cost": {"cpu_seconds": time.process_time() - began},
    }


def training_data(settings: Dynamics, seed: int) -> Data:
    """Return the motion of at least `n_timesteps` steps."""
    count = -(-settings.n_timesteps // (settings.n_envs * settings.n_steps))
    firsts = [seed * SEED_STRIDE + batch * settings.n_envs for batch in range(count)]
    return Data.of(joined([episodes_of(settings, first, settings.n_envs) for first in firsts]))


def evaluation_episodes(settings: Dynamics) -> Episodes:
    """Return the episodes of evaluations."""
    return episodes_of(settings, settings.evaluation.first, settings.evaluation.episodes)


def episodes_of(settings: Dynamics, first: int, count: int) -> Episodes:
    """Return episodes with seeds from `first` on."""
    return collect(settings.env, settings.env_kwargs, first, count, settings.n_steps, settings.random_share)


def joined(batches: Sequence[Episodes]) -> Episodes:
    """Return the episodes of all batches."""
    return Episodes(*(np.concatenate(parts, axis=1) for parts in zip(*batches, strict=True)))


def errors_of(model: DynamicsModel, episodes: Episodes) -> list[Row]:
    """Return the prediction errors after each of `HISTORIES_S` that leaves time for a prediction."""
    longest = len(episodes.valid) * model.about.period - OPEN_LOOP_S
    return [
        {"history": after, **prediction_errors(model, episodes, after)}
        for after in HISTORIES_S
        if after <= longest
    ]
