"""A run from its file to its page: what is finished is kept, the rest is played."""

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
    """Play the episodes that have not been finished, and write the page of all.

    Parameters
    ----------
    path : Path
        What is to be run.
    out : Path
        Folder of the run: `episode_NN/history.json`, `episode_NN/recording/`, `page.html`.
    quiet : bool
        Show no progress.
    tell : callable, optional
        Told in a line how each episode ended.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    TrundleError
        If the file cannot be used, or the folder holds something else.
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
    """Play an episode and write its recording."""
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
    """Tells how an episode goes: a line that changes where a person watches, one that stays for each fit."""

    def __init__(self, progress: Progress, quiet: bool) -> None:
        self._progress, self._quiet = progress, quiet

    def __call__(self, row: Row) -> None:
        """Tell of a step."""
        way = f"{row['t']:5.2f} s, {row['distance']:.2f} m to go"
        self._progress.show(way)
        if row["update"] is not None and not self._quiet:
            clear = "\r\033[K" if sys.stderr.isatty() else ""
            print(
                f"{clear}{way}: {sentences.belief_line(parse_update(row['update']))}",
                file=sys.stderr,
                flush=True,
            )
