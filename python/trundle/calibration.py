"""Simulation-based calibration of posterior intervals (Talts et al. 2018)."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from trundle import _native
from trundle._native import TrundleError
from trundle._optional import require
from trundle._types import CalibrationRound, CalibrationTable
from trundle.atomic import atomic_file, write_text
from trundle.display import Card, Displayed, Table
from trundle.experiments.backends import Backend, Local
from trundle.progress import ProgressOption, report_progress

__all__ = ["Calibration", "calibrate"]


def __dir__() -> list[str]:
    return __all__


PathLike: TypeAlias = "str | os.PathLike[str]"

ROUNDS_PER_BATCH = 4
"""Number of rounds per job; the results are written after each job."""


@dataclass(frozen=True, repr=False)
class Calibration(Displayed):
    """Result of a calibration.

    Attributes
    ----------
    table : dict
        ``name``, ``method`` and ``parameters``: for each parameter ``rounds``, ``cover_50`` and ``cover_90``
        (share of rounds whose central interval covers the truth, with its 95 % interval), ``uniform_p``
        (χ² test of uniform ranks), ``histogram`` (of the ranks, ten bins), ``mean_rank``.
    rounds : list of dict
        Truth, mean, standard deviation and rank in each round.

    Examples
    --------
    >>> found = trundle.calibration.calibrate("configs/experiments/calibrate.toml", replicates=1)
    >>> len(found.rounds)
    1
    """

    table: CalibrationTable
    rounds: list[CalibrationRound]

    def _card(self) -> Card:
        rows = [
            (
                one["name"],
                f"{one['cover_50'][0]:.1%}",
                f"{one['cover_90'][0]:.1%}",
                f"{one['uniform_p']:.2g}",
            )
            for one in self.table["parameters"]
        ]
        title = (
            f"trundle.Calibration {self.table['name']!r}: {self.table['method']}, {len(self.rounds)} rounds"
        )
        heads = ("parameter", "50 % covers", "90 % covers", "p of uniform ranks")
        return Card(title, (), Table(heads, rows))

    def figure(self, path: PathLike) -> Path:
        """Draw histograms of the ranks, with the 95 % band of uniform ranks, to a PNG or SVG file."""
        matplotlib = require("matplotlib.figure", "plots", "plots")
        lines = self.table["parameters"]
        n, bins = len(self.rounds), len(lines[0]["histogram"])
        columns = min(3, len(lines))
        figure = matplotlib.Figure(
            figsize=(3.2 * columns, 2.3 * -(-len(lines) // columns)), layout="constrained"
        )
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
    progress: ProgressOption = None,
) -> Calibration:
    """Run a simulation-based calibration (Talts et al. 2018).

    Each round draws parameters from the prior, simulates a recording, samples the posterior and ranks the
    true values among the draws.

    Parameters
    ----------
    config : path
        Calibration settings, such as ``configs/experiments/calibrate.toml``.
    replicates : int
        Number of rounds.
    method : {"nuts", "laplace", "metropolis"}, optional
        Sampler; by default that of the settings.
    seed : int
        Random seed. Round k depends on the seed only, not on other rounds.
    out : path, optional
        JSON lines file to which finished rounds are written. An existing file with the same settings, method
        and seed is continued.
    backend : trundle.experiments.backends.Backend, optional
        Where rounds run; by default in this process, on all cores.
    progress : bool or callable, optional
        True shows a progress bar; the default shows one in notebooks only. A function is called with the
        stage of the work and the finished share of all work, 0 to 1, which never decreases.

    Returns
    -------
    Calibration

    Raises
    ------
    TrundleError
        If the settings are invalid, or ``out`` contains another calibration.

    Examples
    --------
    >>> settings = "configs/experiments/calibrate.toml"
    >>> calibration = trundle.calibration.calibrate(settings, replicates=1)
    >>> len(calibration.rounds)
    1
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
    with report_progress(progress, "calibrate") as report:
        for number, found in (backend or Local()).map(run_rounds, calls):
            rounds |= dict(zip(batches[number], found, strict=True))
            if out is not None:
                write_rounds(Path(out), [head, *(json.dumps(rounds[k]) for k in sorted(rounds))])
            if report is not None:
                report("calibrate", len(rounds) / max(replicates, len(rounds)))
    lines = [rounds[k] for k in range(replicates)]
    return Calibration(_native._calibration_table(text, lines, method=method), lines)


def run_rounds(text: str, batch: list[int], method: str | None, seed: int) -> list[CalibrationRound]:
    """Run a batch of rounds."""
    return _native._calibrate(text, batch, method=method, seed=seed, progress=None)


def read_rounds(out: PathLike | None, head: str) -> dict[int, CalibrationRound]:
    """Read the rounds in a results file, by number; an absent file has none."""
    if out is None or not Path(out).exists():
        return {}
    first, *lines = Path(out).read_text(encoding="utf-8").splitlines() or [""]
    if first != head:
        raise TrundleError(
            f"{out}: contains another calibration (settings, method or seed); give another --out"
        )
    rounds = [json.loads(line) for line in lines]
    return {int(one["index"]): one for one in rounds}


def write_rounds(path: Path, lines: list[str]) -> None:
    """Write a results file atomically."""
    write_text(path, "\n".join(lines) + "\n")
