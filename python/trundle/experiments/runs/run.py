"""Run closed-loop episodes from a settings file to a page."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import trundle
from trundle.cli.progress import Progress
from trundle.experiments.runs import config, sentences
from trundle.experiments.runs.episode import Row, play
from trundle.experiments.runs.folder import Folder
from trundle.experiments.runs.history import parse_history, parse_update
from trundle.experiments.runs.page import render

__all__ = ["run_closed_loop"]


def run_closed_loop(
    path: Path, out: Path, *, quiet: bool = False, tell: Callable[[str], None] | None = None
) -> Path:
    """Run the unfinished episodes, and write the page of all.

    Parameters
    ----------
    path : Path
        Settings file.
    out : Path
        Folder of the run: `episode_NN/history.json`, `episode_NN/recording/`, `page.html`.
    quiet : bool
        Show no progress.
    tell : callable, optional
        Called with a line about the outcome of each episode.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    TrundleError
        If the file is invalid, or the folder holds something else.
    """
    settings = config.read(path)
    folder = Folder(out, settings.plain())
    episodes = []
    for number in range(settings.episodes):
        history = folder.history(number)
        if history is None:
            history = play_episode(settings, folder, number, quiet)
            folder.keep(number, history)
        episodes.append(parse_history(history))
        if tell:
            tell(f"episode {number}: {sentences.line(episodes[-1])}")
    return folder.show(render(settings, path.name, episodes))


def play_episode(settings: config.Settings, folder: Folder, number: int, quiet: bool) -> Row:
    """Run an episode and write its recording."""
    env: Any
    env, agent = settings.begin(number)
    if settings.recording != "none":
        recording = folder.episode(number) / "recording"
        name = f"{settings.environment.split('/')[-1]}_{settings.seed + number}"
        env = trundle.Record(env, recording, name=name, table=settings.recording)
        recording.parent.mkdir(exist_ok=True)
    with Progress(f"episode {number}", quiet=quiet) as progress:
        history = play(env, agent, settings.seed + number, ProgressReporter(progress, quiet))
    env.close()
    return history


class ProgressReporter:
    """Reports an episode: a progress line for each step, and a permanent line for each fit."""

    def __init__(self, progress: Progress, quiet: bool) -> None:
        self._progress, self._quiet = progress, quiet

    def __call__(self, row: Row) -> None:
        """Report a step."""
        way = f"{row['t']:5.2f} s, {row['distance']:.2f} m to go"
        self._progress.show(way)
        if row["update"] is not None and not self._quiet:
            clear = "\r\033[K" if sys.stderr.isatty() else ""
            print(
                f"{clear}{way}: {sentences.belief_line(parse_update(row['update']))}",
                file=sys.stderr,
                flush=True,
            )
