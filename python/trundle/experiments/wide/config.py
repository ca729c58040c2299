"""Read the file of a wide benchmark: numbers of cases, ranges of seeds, and thresholds of materiality."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from trundle.experiments.blind.config import resolve_families
from trundle.experiments.wide.families import CATALOGUE, OUT_OF_CATALOGUE
from trundle.recording import TrundleError
from trundle.settings import build_settings, parse_format

__all__ = ["FORMAT", "Counts", "Settings", "read"]

FORMAT = "trundle-wide/1"


@dataclass(frozen=True)
class Counts:
    """Numbers of cases: without an effect, with one to four, and out of the catalogue."""

    clean: int = 0
    singles: int = 0
    pairs: int = 0
    triples: int = 0
    fours: int = 0
    outsides: int = 0

    def groups(self) -> dict[tuple[int, bool], int]:
        """Return the counts by number of families and whether they are out of the catalogue."""
        several = {(2, False): self.pairs, (3, False): self.triples, (4, False): self.fours}
        return {(0, False): self.clean, (1, False): self.singles, (1, True): self.outsides, **several}


@dataclass(frozen=True)
class Range(Counts):
    """A range of seeds, split into shares of cases; or a subset of one: the first cases of each kind."""

    first: int | None = None
    of: str | None = None
    shares: int = 1

    def counts(self) -> Counts:
        """Return the counts alone."""
        return Counts(**{one.name: getattr(self, one.name) for one in fields(Counts)})


@dataclass(frozen=True)
class File:
    """Contents of a file; see `Settings`."""

    ranges: dict[str, Range]
    effects: list[str]
    outside: list[str]
    matters: float = 3.0
    each_matters: float = 2.0
    attempts: int = 40
    limit: float = 900.0


@dataclass(frozen=True)
class Settings:
    """What the recordings and diagnoses of a range depend on.

    Attributes
    ----------
    range : str
        Name of the range.
    parent : str
        Name of the range of which it is a subset, or its own.
    first : int
        First seed.
    counts : Counts
        Of the whole range.
    subset : Counts, optional
        Of the subset, if the range is one.
    shares : int
        Number of shares of the range. Each is drawn, sealed and diagnosed separately.
    share : int, optional
        Number of the share; None for the whole range.
    effects, outside : tuple of str
        Families to hide.
    matters : float
        Factor by which the true law must reduce the refitted nominal model's held-out misfit.
    each_matters : float
        The same for each of several effects, with the others in the model.
    attempts : int
        Number of draws before a case is dropped.
    limit : float
        Processor time of one diagnosis, s.
    """

    range: str
    parent: str
    first: int
    counts: Counts
    subset: Counts | None
    shares: int
    share: int | None
    effects: tuple[str, ...]
    outside: tuple[str, ...]
    matters: float
    each_matters: float
    attempts: int
    limit: float

    def parts(self) -> list[Settings]:
        """Return the settings of every share."""
        return [self] if self.shares == 1 else [replace(self, share=k) for k in range(self.shares)]

    def plain(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {name: list(v) if isinstance(v, tuple) else v for name, v in asdict(self).items()}


def read(path: Path, which: str) -> Settings:
    """Read a file for one of its ranges.

    Raises
    ------
    TrundleError
        If a key, a family or the range is unknown.
    """
    found = build_settings(path, File, parse_format(path, FORMAT))
    chosen = get_range(path, found, which)
    parent = get_range(path, found, chosen.of) if chosen.of else chosen
    if chosen.shares < 1:
        raise TrundleError(f"{path}: [ranges.{which}] shares = {chosen.shares} must be at least 1")
    if parent.first is None:
        raise TrundleError(f"{path}: [ranges.{chosen.of or which}] missing key `first`, the first seed")
    return Settings(
        range=which,
        parent=chosen.of or which,
        first=parent.first,
        counts=parent.counts(),
        subset=chosen.counts() if chosen.of else None,
        shares=chosen.shares,
        share=None,
        effects=resolve_families(path, tuple(found.effects), CATALOGUE),
        outside=resolve_families(path, tuple(found.outside), OUT_OF_CATALOGUE),
        matters=found.matters,
        each_matters=found.each_matters,
        attempts=found.attempts,
        limit=found.limit,
    )


def get_range(path: Path, found: File, which: str) -> Range:
    """Return a range of a file."""
    if which not in found.ranges:
        raise TrundleError(
            f"{path}: [ranges] has no '{which}'; it has {', '.join(found.ranges) or 'nothing'}"
        )
    return found.ranges[which]
