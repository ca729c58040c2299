"""Read the file of a blind benchmark: numbers of cases, ranges of seeds, and thresholds of materiality."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from trundle.experiments.blind.families import CATALOGUE, FAMILIES, OUT_OF_CATALOGUE
from trundle.recording import TrundleError
from trundle.settings import build_settings, parse_format

__all__ = ["Settings", "read"]

FORMAT = "trundle-proof/1"
OPTIONAL_DEFAULTS = {"alike": False, "size": 1.0}
"""Keys that the first benchmarks did not have, with the values that those used."""


@dataclass(frozen=True)
class SeedRanges:
    """Ranges of seeds.

    Attributes
    ----------
    ranges : dict of str to int
        First seed by name.
    """

    ranges: dict[str, int]


@dataclass(frozen=True)
class Settings:
    """What the recordings of a proof depend on.

    Attributes
    ----------
    range : str
        Which range of seeds.
    first : int
        Its first seed.
    effects, foreign : tuple of str
        Families that are hidden.
    singles, foreigns : int
        Cases of each.
    pairs, clean : int
        Cases in all.
    matters : float
        By which factor the true law must improve the refitted nominal model's held-out misfit.
    each_matters : float
        The same for each effect of a pair, where only the other is in the model.
    attempts : int
        Draws after which a case is given up.
    episodes : int
    alike : bool
        Whether all pushes begin at one pose, by one grasp, and do not turn the object: recordings that leave
        ties.
    size : float
        Share of the size drawn that is hidden, once the size drawn is known to matter.
    sizes : tuple of float
        For detection limits: shares of the size that was drawn.
    limited : int
        For detection limits: cases of each effect.
    """

    range: str
    first: int
    effects: tuple[str, ...]
    foreign: tuple[str, ...]
    singles: int
    foreigns: int
    pairs: int
    clean: int
    matters: float = 3.0
    each_matters: float = 2.0
    attempts: int = 30
    episodes: int = 8
    alike: bool = False
    size: float = 1.0
    sizes: tuple[float, ...] = (1.0, 0.5, 0.25, 0.125)
    limited: int = 0

    def plain(self) -> dict[str, Any]:
        """Return the settings as plain values.

        Optional keys with their default are omitted, so that older seals stay valid.
        """
        kept = {
            name: v
            for name, v in asdict(self).items()
            if name not in OPTIONAL_DEFAULTS or v != OPTIONAL_DEFAULTS[name]
        }
        return {name: list(v) if isinstance(v, tuple) else v for name, v in kept.items()}

    @classmethod
    def from_plain(cls, values: dict[str, Any]) -> Settings:
        """Return the settings from the values that `plain` returns."""
        found: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
        return cls(**found)


def read(path: Path, which: str) -> Settings:
    """Read a benchmark's file for one of its ranges of seeds.

    Raises
    ------
    TrundleError
        If a key or a family is unknown or missing, or a value has a wrong type.
    """
    found = parse_format(path, FORMAT)
    ranges = build_settings(path, SeedRanges, {"ranges": found.pop("ranges", {})}).ranges
    if which not in ranges:
        raise TrundleError(f"{path}: [ranges] has no '{which}'; it has {', '.join(ranges) or 'nothing'}")
    for key in ("range", "first"):
        if key in found:
            raise TrundleError(f"{path}: unknown key `{key}`: define it in the table [ranges]")
    told = {"effects": ["all"], "foreign": ["all"], **found, "range": which, "first": ranges[which]}
    settings = build_settings(path, Settings, told)
    return replace(
        settings,
        effects=resolve_families(path, settings.effects, CATALOGUE),
        foreign=resolve_families(path, settings.foreign, OUT_OF_CATALOGUE, FAMILIES),
    )


def resolve_families(
    path: Path, names: tuple[str, ...], known: dict[str, Any], more: dict[str, Any] | None = None
) -> tuple[str, ...]:
    """Return names of families, all known ones for "all".

    Names of `accepted` are also valid: a family that was out of catalogue when a benchmark was defined may be
    in the catalogue today.
    """
    for name in names:
        if name != "all" and name not in (more or known):
            raise TrundleError(f"{path}: unknown family '{name}'; choose from {', '.join(known)}")
    return tuple(known) if names == ("all",) else names
