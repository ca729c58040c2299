"""`trundle compare`: a comparison from its file to its document."""

from __future__ import annotations

import hashlib
import multiprocessing
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from trundle.cli.progress import Progress
from trundle.comparison.config import Settings, read
from trundle.comparison.document import write_document
from trundle.comparison.episode import attempt, player
from trundle.comparison.journal import Journal, key
from trundle.comparison.results import Trial, write_costs, write_results
from trundle.comparison.world import begin
from trundle.proof.pool import in_parallel
from trundle.recording import TrundleError

__all__ = ["compare"]


@dataclass(frozen=True)
class Played:
    """What is to be played, and what has been.

    Attributes
    ----------
    settings : Settings
    digests : dict
        SHA-256 of each policy's file.
    journal : Journal
    """

    settings: Settings
    digests: dict[str, str]
    journal: Journal

    def key(self, trial: Trial) -> str:
        """Return a trial's key in the journal."""
        worlds, agent, run, seed = trial
        parts = self.settings.worlds[worlds], self.settings.agents[agent]
        return key(*parts, run, seed, self.digests)


def compare(
    config: Path,
    work: Path,
    out: Path,
    *,
    count: int | None = None,
    jobs: int = 1,
    fresh: bool = False,
    redraw: bool = False,
    quiet: bool = False,
) -> str:
    """Play what has not been played of a comparison, and write its results and its document.

    Parameters
    ----------
    config : Path
        The comparison's file.
    work : Path
        Folder of the episodes that have been played.
    out : Path
        Folder of the document, of the results and of `images/`.
    count : int, optional
        How many worlds of each group at most, from the first on.
    jobs : int
        Processes.
    fresh, redraw : bool
        Forget what has been played; or only write the document.
    quiet : bool
        Show no progress.

    Returns
    -------
    str
        The document.

    Raises
    ------
    TrundleError
        If the file cannot be used, or an episode cannot be played.
    """
    settings = shortened(read(config), count)
    folder = out / settings.name
    if not redraw:
        journal = work / f"{settings.name}.jsonl"
        if fresh:
            journal.unlink(missing_ok=True)
        digests = digests_of(settings)
        rehearse(config, settings)
        played = Played(settings, digests, Journal(journal))
        carry_out(played, jobs, quiet)
        keep(played, folder)
    return write_document(out, settings, config)


def shortened(settings: Settings, count: int | None) -> Settings:
    """Return a comparison on fewer worlds."""
    if count is None:
        return settings
    fewer = {name: replace(w, count=min(w.count, count)) for name, w in settings.worlds.items()}
    return replace(settings, worlds=fewer)


def digests_of(settings: Settings) -> dict[str, str]:
    """Return the SHA-256 of each policy's file that plays."""
    playing = {name for worlds in settings.worlds.values() for name in worlds.agents}
    files = [file for name in settings.agents if name in playing for file in settings.agents[name].files]
    return {file: hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in files}


def rehearse(config: Path, settings: Settings) -> None:
    """Let every agent decide once in each group of worlds: what is wrong is told before hours of work."""
    for name, worlds in settings.worlds.items():
        for agent in worlds.agents:
            try:
                for run in settings.agents[agent].runs:
                    env, observation = begin(worlds, worlds.first, settings.agents[agent].options)
                    playing = player(settings.agents[agent], run, env)
                    action, _ = playing.predict(observation, episode_start=True)
                    env.step(action)
            except TrundleError as error:
                raise TrundleError(f"{config}: {agent} in [worlds.{name}]: {error}") from error


def trials(settings: Settings) -> Iterator[Trial]:
    """Yield every episode: all first worlds, then all second ones, so that a part is a comparison too."""
    for number in range(max(worlds.count for worlds in settings.worlds.values())):
        for name, worlds in settings.worlds.items():
            for agent in worlds.agents if number < worlds.count else ():
                for run in settings.agents[agent].runs:
                    yield name, agent, run, worlds.first + number


def carry_out(played: Played, jobs: int, quiet: bool) -> None:
    """Play what is not in the journal."""
    settings, journal = played.settings, played.journal
    whole = list(trials(settings))
    missing = [trial for trial in whole if played.key(trial) not in journal]
    calls = [(settings.worlds[w], settings.agents[a], run, seed) for w, a, run, seed in missing]
    failed: list[str] = []
    with Progress(f"{len(whole) - len(missing)} episodes kept, playing", len(missing), quiet=quiet) as shown:
        try:
            for number, found in in_parallel(attempt, calls, jobs):
                worlds, agent, run, seed = missing[number]
                if isinstance(found, str):
                    failed.append(f"{agent} in {worlds}, seed {seed}, run {run}: {found}")
                    print(failed[-1], file=sys.stderr, flush=True)
                else:
                    journal.add(played.key(missing[number]), *found)
                shown.step(f"{worlds} {seed}: {agent}")
        finally:
            for child in multiprocessing.active_children():
                child.terminate()
    if failed:
        raise TrundleError(f"{len(failed)} episodes cannot be played, the others are kept: {failed[0]}")


def keep(played: Played, folder: Path) -> None:
    """Write the results and the costs, in order."""
    settings = played.settings
    order = [
        (name, agent, run, seed)
        for name, worlds in settings.worlds.items()
        for agent in worlds.agents
        for run in settings.agents[agent].runs
        for seed in worlds.seeds
    ]
    found = [(trial, *played.journal[played.key(trial)]) for trial in order]
    write_results(
        folder / "results.jsonl", settings, played.digests, [(trial, row) for trial, row, _ in found]
    )
    write_costs(folder / "costs.json", [(trial, timing) for trial, _, timing in found])
