"""Simulation-based calibration: whether intervals cover as often as they say."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from trundle import _native
from trundle._native import TrundleError
from trundle.atomic import atomic_file, write_text
from trundle.experiments.backends import Backend, Local

__all__ = ["Calibration", "calibrate"]

PathLike: TypeAlias = "str | os.PathLike[str]"

ROUNDS_PER_BATCH = 4
"""Rounds between two writings of the results."""


@dataclass(frozen=True)
class Calibration:
    """What a calibration found.

    Attributes
    ----------
    table : dict
        ``name``, ``method`` and, of each parameter, ``rounds``, ``cover_50`` and ``cover_90`` (share of
        rounds whose central interval covers the truth, and the ends of its 95 % interval),
        ``uniform_p`` (χ² test of uniform ranks), ``histogram`` (of the ranks, in tenths), ``mean_rank``.
    rounds : list of dict
        Truth, mean, standard deviation and rank of each round.
    """

    table: dict[str, Any]
    rounds: list[dict[str, Any]]

    def figure(self, path: PathLike) -> Path:
        """Draw the ranks' histogram of each parameter, with the band of even ranks, as PNG or SVG."""
        from matplotlib.figure import Figure

        lines = self.table["parameters"]
        n, bins = len(self.rounds), len(lines[0]["histogram"])
        columns = min(3, len(lines))
        figure = Figure(figsize=(3.2 * columns, 2.3 * -(-len(lines) // columns)), layout="constrained")
        spread = 1.96 * np.sqrt(n * (bins - 1)) / bins
        for place, line in enumerate(lines):
            axes = figure.add_subplot(-(-len(lines) // columns), columns, place + 1)
            axes.axhspan(n / bins - spread, n / bins + spread, color="0.88")
            axes.bar((np.arange(bins) + 0.5) / bins, line["histogram"], 0.9 / bins, color="#3b6ea5")
            covered = f"90 % covers {line['cover_90'][0]:.0%}"
            axes.set_title(f"{line['name']}\n{covered}, p = {line['uniform_p']:.2g}", fontsize=8)
            axes.tick_params(labelsize=7)
        figure.supxlabel(f"rank of the truth among the draws, {self.table['method']}, {n} rounds", fontsize=8)
        target = Path(path)
        with atomic_file(target) as part:
            figure.savefig(part, format=target.suffix[1:] or None, dpi=150)
        return target


def calibrate(
    config: PathLike,
    *,
    replicates: int = 200,
    method: str | None = None,
    seed: int = 0,
    out: PathLike | None = None,
    backend: Backend | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> Calibration:
    """Draw parameters of the prior, simulate, infer, rank the truth among the draws (Talts et al. 2018).

    Parameters
    ----------
    config : path
        A calibration file, as ``configs/experiments/calibrate.toml``.
    replicates : int
        Rounds.
    method : {"nuts", "laplace", "metropolis"}, optional
        In place of the file's.
    seed : int
        Round k of a seed is the same whatever other rounds there are.
    out : path, optional
        A JSON lines file that gets the rounds as they are done. If it is there, of the same file, method and
        seed, only missing rounds are run.
    backend : trundle.experiments.backends.Backend, optional
        Where rounds run; by default in this process, on all its cores.
    progress : callable, optional
        Called with the stage of the work and the share of the whole that is done, 0 to 1; neither goes back.

    Raises
    ------
    TrundleError
        If the file cannot be used, or ``out`` holds another calibration.
    """
    if replicates < 1:
        raise TrundleError(f"replicates = {replicates}: at least one round is needed")
    text = Path(config).read_text(encoding="utf-8")
    head = json.dumps({"config": text, "method": method, "seed": seed})
    rounds = read_rounds(out, head)
    missing = [k for k in range(replicates) if k not in rounds]
    batches = [
        missing[first : first + ROUNDS_PER_BATCH] for first in range(0, len(missing), ROUNDS_PER_BATCH)
    ]
    calls = [(text, batch, method, seed) for batch in batches]
    for number, found in (backend or Local()).map(run_rounds, calls):
        rounds |= dict(zip(batches[number], found, strict=True))
        if out is not None:
            write_rounds(Path(out), [head, *(rounds[k] for k in sorted(rounds))])
        if progress is not None:
            progress("calibrate", len(rounds) / max(replicates, len(rounds)))
    lines = [rounds[k] for k in range(replicates)]
    table = json.loads(_native._calibration_table(text, lines, method=method))
    return Calibration(table, [json.loads(line) for line in lines])


def run_rounds(text: str, batch: list[int], method: str | None, seed: int) -> list[str]:
    """Run some rounds; return a line of JSON for each."""
    return _native._calibrate(text, batch, method=method, seed=seed, progress=None)


def read_rounds(out: PathLike | None, head: str) -> dict[int, str]:
    """Return the rounds that a results file holds, by number."""
    if out is None or not Path(out).exists():
        return {}
    first, *lines = Path(out).read_text(encoding="utf-8").splitlines() or [""]
    if first != head:
        raise TrundleError(f"{out}: holds another calibration (file, method or seed); give another --out")
    return {int(json.loads(line)["index"]): line for line in lines}


def write_rounds(path: Path, lines: list[str]) -> None:
    """Write the file so that it is whole at any time."""
    write_text(path, "\n".join(lines) + "\n")
