"""Run closed-loop episodes from a settings file to a page.

The history of an episode is written last, so an episode with a history is finished. An unfinished episode is
run again.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import trundle
from trundle.atomic import PARTIAL_SUFFIX, read_json, write_text
from trundle.experiments.results import Row
from trundle.experiments.runs import config, sentences
from trundle.experiments.runs.episode import play
from trundle.experiments.runs.history import parse_history, parse_update
from trundle.experiments.runs.page import render
from trundle.progress import Progress
from trundle.recording import TrundleError

__all__ = ["run_closed_loop"]


def run_closed_loop(
    path: Path, out: Path, *, quiet: bool = False, report: Callable[[str], None] | None = None
) -> Path:
    """Run the unfinished episodes of a settings file, write the page of all, and return its path.

    The folder `out` gets `settings.json`, `page.html`, and for each episode `episode_NN/history.json` and
    `episode_NN/recording/`. `report` is called with a line about the outcome of each episode.

    Raises
    ------
    TrundleError
        If the file is invalid, or the folder holds something else.
    """
    settings = config.read(path)
    open_folder(out, settings.plain())
    episodes = []
    for number in range(settings.episodes):
        episode = parse_history(episode_history(settings, out / f"episode_{number:02}", number, quiet))
        episodes.append(episode)
        if report:
            report(f"episode {number}: {sentences.headline(episode)} {sentences.wheel_sentence(episode)}")
    write_text(out / "page.html", render(settings, path.name, episodes))
    return out / "page.html"


def open_folder(out: Path, settings: Row) -> None:
    """Create the folder of a run, or check that it holds a run with these settings."""
    marker = out / "settings.json"
    if marker.exists() and read_json(marker) != settings:
        raise TrundleError(
            f"{out}: holds a run with other settings or of another version: choose another --out, "
            "or remove the folder"
        )
    if not marker.exists():
        if out.exists() and any(not entry.name.endswith(PARTIAL_SUFFIX) for entry in out.iterdir()):
            raise TrundleError(f"{out}: the folder is not empty and holds no run: choose another --out")
        write_text(marker, json.dumps(settings, indent=1, sort_keys=True) + "\n")
    for partial in out.glob(f".page.html.*{PARTIAL_SUFFIX}"):
        partial.unlink()


def episode_history(settings: config.Settings, folder: Path, number: int, quiet: bool) -> Row:
    """Return the history of an episode; run the episode if it is not finished."""
    file = folder / "history.json"
    if not file.exists():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        write_text(file, json.dumps(run_episode(settings, folder, number, quiet)) + "\n")
    history: Row = read_json(file)
    return history


LINE_INTERVAL_S = 0.25
"""Minimum time between two lines of the estimate in the terminal, s of the episode."""


def run_episode(settings: config.Settings, folder: Path, number: int, quiet: bool) -> Row:
    """Run an episode, write its recording, and show a progress line, and permanent lines of the estimate."""
    env: Any
    env, agent = settings.begin(number)
    seed = settings.seed + number
    if settings.recording != "none":
        name = f"{settings.environment.split('/')[-1]}_{seed}"
        env = trundle.Record(env, folder / "recording", name=name, table=settings.recording)
    with Progress(f"episode {number}", quiet=quiet) as progress:
        due = 0.0

        def watch(row: Row) -> None:
            nonlocal due
            way = f"{row['t']:5.2f} s, {row['distance']:.2f} m to go"
            progress.show(way)
            update = row["update"]
            if update is None or quiet:
                return
            if row["t"] >= due or update["named"] or update["supposed"]:
                due = row["t"] + LINE_INTERVAL_S
                clear = "\r\033[K" if sys.stderr.isatty() else ""
                belief = sentences.belief_line(parse_update(update))
                print(f"{clear}{way}: {belief}", file=sys.stderr, flush=True)

        history = play(env, agent, seed, watch)
    env.close()
    return history
