"""Read the file of a blind benchmark: numbers of cases, ranges of seeds, and thresholds of materiality."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any, ClassVar

from trundle.experiments.blind import families
from trundle.experiments.blind.furniture.families import OUT_OF_CATALOGUE as FURNITURE_OUT_OF_CATALOGUE
from trundle.experiments.blind.mechanism import families as mechanism_families
from trundle.experiments.blind.mechanism.outside import OUT_OF_CATALOGUE as MECHANISM_OUT_OF_CATALOGUE
from trundle.experiments.blind.mechanism.wheels import ROBOT_SETS
from trundle.experiments.blind.wide.families import OUT_OF_CATALOGUE as WIDE_OUT_OF_CATALOGUE
from trundle.recording import TrundleError
from trundle.settings import build_settings, parse

__all__ = ["Counts", "Settings", "read"]

DIAGNOSIS_LIMIT_S = 3600.0
"""Processor time of a diagnosis of furniture."""


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
class Settings:
    """What the recordings and diagnoses of a range depend on.

    Attributes
    ----------
    generator : str
        "furniture", "wide" or "mechanism".
    range, parent : str
        Name of the range; name of the range of which it is a subset, or its own.
    first : int
        First seed.
    effects, outside : tuple of str
        Families to hide.
    counts : Counts
        Of the whole range.
    subset : Counts, optional
        Of the subset, if the range is one.
    shares, share : int
        Number of shares of the range, and number of the share; None for the whole range. Each share is drawn,
        sealed and diagnosed separately.
    matters : float
        Factor by which the true law must reduce the refitted nominal model's held-out misfit.
    each_matters : float
        The same for each of several effects, with the others in the model.
    attempts : int
        Number of draws before a case is dropped.
    limit : float
        Processor time of one diagnosis, s.
    episodes, alike : int, bool
        Of furniture: number of pushes, and whether all begin at one pose, by one grasp, without rotation.
    size : float
        Of furniture: share of the drawn size that is hidden, after the drawn size has proved material.
    robots : tuple of str
        Of mechanisms: "own" for the built-in robots, "wheels" for those of `mechanism.wheels`.
    sizes, limited : tuple of float, int
        For detection limits of furniture: shares of the drawn size, and cases of each effect.
    """

    generator: str
    range: str
    parent: str
    first: int
    effects: tuple[str, ...]
    outside: tuple[str, ...]
    counts: Counts
    subset: Counts | None = None
    shares: int = 1
    share: int | None = None
    matters: float = 3.0
    each_matters: float = 2.0
    attempts: int = 40
    limit: float = 900.0
    episodes: int = 8
    alike: bool = False
    size: float = 1.0
    sizes: tuple[float, ...] = (1.0, 0.5, 0.25, 0.125)
    limited: int = 0
    robots: tuple[str, ...] = ("own",)

    def parts(self) -> list[Settings]:
        """Return the settings of every share."""
        return [self] if self.shares == 1 else [replace(self, share=k) for k in range(self.shares)]

    def plain(self) -> dict[str, Any]:
        """Return it as plain values; without those of furniture for another generator."""
        found = {name: list(v) if isinstance(v, tuple) else v for name, v in asdict(self).items()}
        if self.robots == ("own",):
            del found["robots"]
        if self.generator == "furniture":
            return found
        kept = {name: v for name, v in found.items() if name not in FURNITURE_ONLY}
        return kept if self.generator == "wide" else {"generator": self.generator, **kept}

    def drawing(self) -> dict[str, Any]:
        """Return the values on which the drawing of a single case depends."""
        names = ("matters", "each_matters", "attempts", "episodes", "alike")
        chosen = {} if self.robots == ("own",) else {"robots": list(self.robots)}
        return {name: getattr(self, name) for name in names} | chosen


FURNITURE_ONLY = ("generator", "episodes", "alike", "size", "sizes", "limited")


@dataclass(frozen=True)
class FurnitureFile:
    """Contents of a file `trundle-proof/1`; `singles` and `foreigns` are cases of each family."""

    singles: int
    foreigns: int
    pairs: int
    clean: int
    ranges: dict[str, int]
    effects: tuple[str, ...] = ("all",)
    foreign: tuple[str, ...] = ("all",)
    matters: float = 3.0
    each_matters: float = 2.0
    attempts: int = 30
    episodes: int = 8
    alike: bool = False
    size: float = 1.0
    sizes: tuple[float, ...] = (1.0, 0.5, 0.25, 0.125)
    limited: int = 0

    def settings(self, path: Path, which: str) -> Settings:
        """Return the settings of a range."""
        effects = resolve(path, self.effects, families.CATALOGUE)
        known, accepted = FURNITURE_OUT_OF_CATALOGUE, {**families.CATALOGUE, **FURNITURE_OUT_OF_CATALOGUE}
        # A family that was out of catalogue when a benchmark was defined may be in the catalogue today.
        outside = resolve(path, self.foreign, known, accepted)
        singles, outsides = self.singles * len(effects), self.foreigns * len(outside)
        names = ("matters", "each_matters", "attempts", "episodes", "alike", "size", "sizes", "limited")
        return Settings(
            "furniture",
            which,
            which,
            self.ranges[which],
            effects,
            outside,
            Counts(self.clean, singles, self.pairs, outsides=outsides),
            limit=DIAGNOSIS_LIMIT_S,
            **{name: getattr(self, name) for name in names},
        )


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
class WideFile:
    """Contents of a file `trundle-wide/1`."""

    generator: ClassVar[str] = "wide"
    catalogue: ClassVar[Iterable[str]] = families.CATALOGUE
    out_of_catalogue: ClassVar[Iterable[str]] = WIDE_OUT_OF_CATALOGUE

    ranges: dict[str, Range]
    effects: tuple[str, ...]
    outside: tuple[str, ...]
    matters: float = 3.0
    each_matters: float = 2.0
    attempts: int = 40
    limit: float = 900.0

    def settings(self, path: Path, which: str) -> Settings:
        """Return the settings of a range."""
        chosen = self.ranges[which]
        name = chosen.of or which
        if name not in self.ranges:
            raise TrundleError(f"{path}: [ranges.{which}] of = '{name}': no such range")
        parent = self.ranges[name]
        if chosen.shares < 1:
            raise TrundleError(f"{path}: [ranges.{which}] shares = {chosen.shares} must be at least 1")
        if parent.first is None:
            raise TrundleError(f"{path}: [ranges.{name}] missing key `first`, the first seed")
        return Settings(
            self.generator,
            which,
            name,
            parent.first,
            resolve(path, self.effects, self.catalogue),
            resolve(path, self.outside, self.out_of_catalogue),
            parent.counts(),
            chosen.counts() if chosen.of else None,
            chosen.shares,
            matters=self.matters,
            each_matters=self.each_matters,
            attempts=self.attempts,
            limit=self.limit,
        )


@dataclass(frozen=True)
class MechanismFile(WideFile):
    """Contents of a file `trundle-mechanism/1`."""

    generator: ClassVar[str] = "mechanism"
    catalogue: ClassVar[Iterable[str]] = mechanism_families.CATALOGUE
    out_of_catalogue: ClassVar[Iterable[str]] = MECHANISM_OUT_OF_CATALOGUE

    robots: tuple[str, ...] = ("own",)

    def settings(self, path: Path, which: str) -> Settings:
        """Return the settings of a range."""
        unknown = [one for one in self.robots if one not in ROBOT_SETS]
        if unknown or not self.robots:
            raise TrundleError(f"{path}: robots = {list(self.robots)}: choose from {', '.join(ROBOT_SETS)}")
        return replace(super().settings(path, which), robots=self.robots)


FILES: dict[str, type[FurnitureFile] | type[WideFile]] = {
    "trundle-proof/1": FurnitureFile,
    "trundle-wide/1": WideFile,
    "trundle-mechanism/1": MechanismFile,
}
"""By the value of `format`."""


def read(path: Path, which: str) -> Settings:
    """Read a benchmark's file for one of its ranges of seeds.

    Raises
    ------
    TrundleError
        If a key, a family or the range is unknown or missing, or a value has a wrong type.
    """
    found = parse(path)
    kind = FILES.get(str(found.pop("format", None)))
    if kind is None:
        raise TrundleError(f"{path}: must begin with format = one of {', '.join(FILES)}")
    file = build_settings(path, kind, found)
    if which not in file.ranges:
        raise TrundleError(f"{path}: [ranges] has no '{which}'; it has {', '.join(file.ranges) or 'nothing'}")
    return file.settings(path, which)


def resolve(
    path: Path, names: tuple[str, ...], known: Iterable[str], accepted: Mapping[str, Any] | None = None
) -> tuple[str, ...]:
    """Return names of families, those of the first benchmarks for "all". `accepted` are valid too."""
    for name in names:
        if name != "all" and name not in (accepted or known):
            raise TrundleError(f"{path}: unknown family '{name}'; choose from {', '.join(known)}")
    if names != ("all",):
        return names
    return tuple(name for name in known if name not in families.LATER_EFFECTS)
