"""Run an experiment from its file to its section of the document."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from trundle.experiments import versions
from trundle.experiments.backends import Backend
from trundle.experiments.paper import EXPERIMENTS, document
from trundle.experiments.paper.experiment import Options
from trundle.experiments.results import Row, read_trials, write_trials
from trundle.experiments.runner import Runner, Unit
from trundle.recording import TrundleError

__all__ = ["run_one"]


def run_one(
    name: str,
    options: Options,
    work: Path,
    out: Path,
    *,
    backend: Backend,
    fresh: bool = False,
    redraw: bool = False,
    quiet: bool = False,
) -> str:
    """Run an experiment and write its results and its section.

    Parameters
    ----------
    name : str
        One of `EXPERIMENTS`.
    options : Options
    work : Path
        Folder of finished trials; an interrupted experiment continues from it.
    out : Path
        Folder of `paper.md`, `paper/` and `images/`.
    backend : Backend
        Where trials run.
    fresh : bool
        Discard earlier trials.
    redraw : bool
        Run no trial; write the section from the results in `out`, whatever their settings.
    quiet : bool
        Show no progress.

    Returns
    -------
    str
        The section.
    """
    experiment = EXPERIMENTS[name]
    path = out / "paper" / f"{experiment.FILE}.jsonl"
    if not redraw:
        settings = check_settings(experiment.settings(options))
        if fresh:
            shutil.rmtree(work / name, ignore_errors=True)
        runner = Runner(work / name, versions.of_package(), backend, quiet)
        write_trials(path, settings, run_trials(name, settings, runner))
    settings, rows = read_trials(path)
    section = experiment.section(settings, rows)
    for picture, draw in section.pictures.items():
        target = out / "images" / picture
        target.parent.mkdir(parents=True, exist_ok=True)
        draw(target)
    took = sum(float(row["seconds"]) for row in rows)
    text = f"## {experiment.TITLE}\n\n{section.text.strip()}\n\n{footer(name, settings, took)}"
    document.replace_section(out / "paper.md", name, text, list(EXPERIMENTS))
    return text


def run_trials(name: str, settings: dict[str, Any], runner: Runner) -> Iterable[tuple[Row, Row, float]]:
    """Run the trials without a result; return each one's name, results and duration, s."""
    names = EXPERIMENTS[name].trials(settings)
    shared = {"name": name, "settings": settings}
    units = [Unit(trial_label(trial), run_trial, {**shared, "trial": trial}) for trial in names]
    results = runner.run(f"paper {name}", units)
    return [(trial, one["found"], one["cost"]) for trial, one in zip(names, results, strict=True)]


def run_trial(name: str, settings: dict[str, Any], trial: Row) -> Row:
    """Run one trial."""
    began = time.perf_counter()
    found = EXPERIMENTS[name].perform(settings, trial)
    return {"found": found, "cost": time.perf_counter() - began}


def trial_label(trial: Row) -> str:
    """Return the name of a trial as text."""
    return ", ".join(f"{key} {value}" for key, value in trial.items())


def check_settings(settings: dict[str, Any]) -> dict[str, Any]:
    """Raise an error if the number of seeds is below one."""
    if settings["seeds"] < 1:
        raise TrundleError(f"seeds = {settings['seeds']}: give at least one")
    return settings


def footer(name: str, settings: dict[str, Any], took: float) -> str:
    """Return the line with the command, the duration and the files of a section."""
    how = " --quick" if settings.get("quick") else ""
    seeds, file = settings["seeds"], settings["file"]
    return (
        f"*`trundle paper {name}{how} --seeds {seeds}`, seeds 0 to {seeds - 1}; the trials took "
        f"{took / 60:.1f} minutes on 2 cores shared with other work. Settings: "
        f"`configs/experiments/{file}.toml`; results: [paper/{file}.jsonl](paper/{file}.jsonl). "
        "In brackets: 95 % bootstrap intervals of medians.*"
    )
