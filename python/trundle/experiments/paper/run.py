"""Run an experiment from its file to its section of the document."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterable
from pathlib import Path

from trundle.experiments import figure_style, versions
from trundle.experiments.backends import Backend
from trundle.experiments.markdown import prose
from trundle.experiments.paper import EXPERIMENTS, document
from trundle.experiments.paper.experiment import Settings, parse_settings, read
from trundle.experiments.results import Row, read_trials, write_trials
from trundle.experiments.runner import Runner, Unit
from trundle.settings import typed

__all__ = ["run_one"]


def run_one(
    name: str,
    configs: Path,
    work: Path,
    out: Path,
    *,
    backend: Backend,
    seeds: int | None = None,
    quick: bool = False,
    fresh: bool = False,
    redraw: bool = False,
    quiet: bool = False,
) -> str:
    """Run an experiment and write its results and its section.

    Parameters
    ----------
    name : str
        One of `EXPERIMENTS`.
    configs : Path
        Folder of `experiments/` and `objects/`.
    work : Path
        Folder of finished trials; an interrupted experiment continues from it.
    out : Path
        Folder of `paper.md`, `paper/` and `images/`.
    backend : Backend
        Where trials run.
    seeds, quick
        See `trundle.experiments.paper.experiment.read`.
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
    file = experiment.__name__.rpartition(".")[2]
    path = out / "paper" / f"{file}.jsonl"
    if not redraw:
        settings = read(experiment.Settings, file, configs, quick=quick, seeds=seeds)
        if fresh:
            shutil.rmtree(work / name, ignore_errors=True)
        runner = Runner(work / name, versions.of_package(), backend, quiet)
        write_trials(path, settings.plain(), run_trials(name, settings, runner))
    stored, rows = read_trials(path)
    settings = parse_settings(path, experiment.Settings, stored)
    text = prose("paper", file, s=settings, **experiment.values(settings, rows))
    text = f"{text}\n\n{footer(name, file, settings, rows)}"
    figure_style.save(experiment.draw(settings, rows), out / "images" / f"paper_{file}.png")
    document.replace_section(out / "paper.md", name, text, list(EXPERIMENTS))
    return text


def run_trials(name: str, settings: Settings, runner: Runner) -> Iterable[tuple[Row, Row, float]]:
    """Run the trials without a result; return each one's name, results and duration, s."""
    names = EXPERIMENTS[name].trials(settings)
    shared = {"name": name, "settings": settings.plain()}
    units = [
        Unit(
            ", ".join(f"{key} {value}" for key, value in trial.items()), run_trial, {**shared, "trial": trial}
        )
        for trial in names
    ]
    results = runner.run(f"paper {name}", units)
    return [(trial, one["found"], one["cost"]) for trial, one in zip(names, results, strict=True)]


def run_trial(name: str, settings: Row, trial: Row) -> Row:
    """Run one trial as a unit of work."""
    began, experiment = time.perf_counter(), EXPERIMENTS[name]
    found = experiment.perform(typed(experiment.Settings, settings), trial)
    return {"found": found, "cost": time.perf_counter() - began}


def footer(name: str, file: str, settings: Settings, rows: Iterable[Row]) -> str:
    """Return the line with the command, the duration and the files of a section."""
    how, seeds = " --quick" if settings.quick else "", settings.seeds
    minutes = sum(float(row["seconds"]) for row in rows) / 60
    return (
        f"*`trundle paper {name}{how} --seeds {seeds}`, seeds 0 to {seeds - 1}; the trials took "
        f"{minutes:.1f} minutes on 2 cores shared with other work. Settings: "
        f"`configs/experiments/{file}.toml`; results: [paper/{file}.jsonl](paper/{file}.jsonl). "
        "In brackets: 95 % bootstrap intervals of medians.*"
    )
