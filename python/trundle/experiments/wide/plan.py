"""Plan the cases: hidden effects, engine, seed and order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from trundle.experiments.wide.config import Settings
from trundle.experiments.wide.families import INDISTINGUISHABLE_PAIRS, get_family
from trundle.experiments.wide.scene import ENGINES

__all__ = ["PlannedCase", "plan_cases"]


@dataclass(frozen=True)
class PlannedCase:
    """A case to draw: an uninformative name, the hidden families, an engine and a seed."""

    case: str
    names: tuple[str, ...]
    engine: str
    seed: int


def plan_cases(settings: Settings) -> list[PlannedCase]:
    """Return all cases in random order.

    A subset of a range has the first cases of each kind. One of n shares has every n-th case.
    """
    left = settings.subset.groups() if settings.subset is not None else None
    chosen = []
    for one in plan_range(settings):
        group = (len(one.names), any(name in settings.outside for name in one.names))
        if left is not None:
            if not left[group]:
                continue
            left[group] -= 1
        chosen.append(one)
    return chosen if settings.share is None else chosen[settings.share :: settings.shares]


def plan_range(settings: Settings) -> list[PlannedCase]:
    """Return all cases of a range."""
    rng, counts = np.random.default_rng([settings.first, 15]), settings.counts
    kinds: list[tuple[str, ...]] = [()] * counts.clean
    kinds += shuffled_cycles(rng, settings.effects, counts.singles)
    kinds += shuffled_cycles(rng, settings.outside, counts.outsides)
    for size, count in ((2, counts.pairs), (3, counts.triples), (4, counts.fours)):
        kinds += [draw_set(rng, settings.effects, size) for _ in range(count)]
    engines = [ENGINES[k % len(ENGINES)] for k in range(len(kinds))]
    order = rng.permutation(len(kinds))
    found = []
    for k, i in enumerate(order):
        engine = "mujoco" if any(requires_mujoco(name) for name in kinds[i]) else engines[i]
        found.append(PlannedCase(f"case_{k:04}", kinds[i], engine, settings.first + k))
    return found


def requires_mujoco(name: str) -> bool:
    """Return whether only MuJoCo can simulate a family."""
    return bool(getattr(get_family(name), "engines", ENGINES) == ("mujoco",))


def shuffled_cycles(rng: np.random.Generator, names: Sequence[str], count: int) -> list[tuple[str, ...]]:
    """Return each name about equally often, in random order within a cycle."""
    found: list[tuple[str, ...]] = []
    while len(found) < count:
        found += [(names[i],) for i in rng.permutation(len(names))]
    return found[:count]


def draw_set(rng: np.random.Generator, names: Sequence[str], size: int) -> tuple[str, ...]:
    """Return a random set of distinguishable effects."""
    while True:
        chosen = tuple(names[i] for i in sorted(rng.choice(len(names), size, replace=False)))
        if not any(frozenset(pair) in INDISTINGUISHABLE_PAIRS for pair in combinations(chosen, 2)):
            return chosen
