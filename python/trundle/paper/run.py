"""One experiment from its file to its section of the document."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from trundle.paper import EXPERIMENTS, document
from trundle.paper.experiment import Options, Show, carry_out, seconds
from trundle.paper.results import Results
from trundle.recording import TrundleError

__all__ = ["run_one"]


def run_one(
    name: str, options: Options, out: Path, show: Show, *, fresh: bool = False, redraw: bool = False
) -> str:
    """Run an experiment and write its section.

    Parameters
    ----------
    name : str
        One of `EXPERIMENTS`.
    options : Options
        What is run.
    out : Path
        Folder of `paper.md`, `paper/` and `images/`.
    show : callable
        Told what is being done.
    fresh : bool
        Forget earlier results.
    redraw : bool
        Do no trial; write the section from the results that are there, whatever their settings.

    Returns
    -------
    str
        The section.
    """
    experiment = EXPERIMENTS[name]
    path = out / "paper" / f"{experiment.FILE}.jsonl"
    if redraw and not path.exists():
        raise TrundleError(f"{path}: there are no results to draw; leave out --redraw")
    results = (
        Results.whatever(path)
        if redraw
        else Results(path, checked(experiment.settings(options)), fresh=fresh)
    )
    rows = carry_out(experiment, results.settings, results, show, perform=not redraw)
    if not rows:
        raise TrundleError(f"{path}: holds no results; leave out --redraw")
    section = experiment.section(results.settings, rows)
    for picture, draw in section.pictures.items():
        target = out / "images" / picture
        target.parent.mkdir(parents=True, exist_ok=True)
        draw(target)
    text = (
        f"## {experiment.TITLE}\n\n{section.text.strip()}\n\n{footer(name, results.settings, seconds(rows))}"
    )
    document.replace(out / "paper.md", name, text, list(EXPERIMENTS))
    return text


def checked(settings: dict[str, Any]) -> dict[str, Any]:
    """Refuse a number of seeds that makes no table."""
    if settings["seeds"] < 1:
        raise TrundleError(f"seeds = {settings['seeds']}: at least one is needed")
    return settings


def footer(name: str, settings: dict[str, Any], took: float) -> str:
    """Return the line that says how the section came about."""
    how = " --quick" if settings.get("quick") else ""
    seeds, file = settings["seeds"], settings["file"]
    return (
        f"*`trundle paper {name}{how} --seeds {seeds}`, seeds 0 to {seeds - 1}; the trials took "
        f"{took / 60:.1f} minutes on 2 cores shared with other work. Settings: "
        f"`configs/experiments/{file}.toml`; results: [paper/{file}.jsonl](paper/{file}.jsonl). "
        "In brackets: 95 % bootstrap intervals of medians.*"
    )
