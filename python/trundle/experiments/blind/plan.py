"""Plan the cases: hidden effects, engine, seed and order."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np

from trundle.experiments.blind.case import PlannedCase
from trundle.experiments.blind.families import INDISTINGUISHABLE_PAIRS
from trundle.experiments.blind.mechanism.generator import allowed_sources
from trundle.experiments.blind.mechanism.simulation import ENGINES as MECHANISM_ENGINES
from trundle.experiments.blind.scene import ENGINES
from trundle.experiments.blind.settings import Settings
from trundle.experiments.blind.wide.families import FAMILIES

__all__ = ["plan_cases", "plan_limits"]

Names = tuple[str, ...]

RANDOM_STREAMS = {"furniture": 4, "wide": 15, "mechanism": 17}
"""Streams of the random numbers, by generator."""
LIMITS_FIRST_SEED = 100_000
"""Offset of the seeds of detection limits from the first seed of the range."""


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
    rng = np.random.default_rng([settings.first, RANDOM_STREAMS[settings.generator]])
    kinds: list[Names] = [()] * settings.counts.clean
    kinds += furniture_sets(rng, settings) if settings.generator == "furniture" else mixed_sets(rng, settings)
    found = []
    for k, i in enumerate(rng.permutation(len(kinds))):
        engine = engine_of(settings.generator, kinds[i], int(i))
        found.append(PlannedCase(f"case_{k:04}", kinds[i], settings.first + k, engine, settings.size))
    return found


def engine_of(generator: str, names: Names, number: int) -> str:
    """Return the engine of a case: alternately each, if it simulates all families."""
    if generator == "furniture":
        return "mujoco"
    if generator == "mechanism":
        return list(MECHANISM_ENGINES)[number % len(MECHANISM_ENGINES)]
    wanted = ENGINES[number % len(ENGINES)]
    return wanted if all(wanted in FAMILIES[name].engines for name in names) else "mujoco"


def furniture_sets(rng: np.random.Generator, settings: Settings) -> list[Names]:
    """Return equal numbers of cases of each family, and random pairs."""
    counts, sets = settings.counts, []
    for names, count in ((settings.effects, counts.singles), (settings.outside, counts.outsides)):
        sets += [(name,) for name in names for _ in range(count // len(names))]
    pairs = [pair for pair in combinations(settings.effects, 2) if is_distinguishable(pair)]
    return sets + [pairs[int(rng.integers(len(pairs)))] for _ in range(counts.pairs)]


def mixed_sets(rng: np.random.Generator, settings: Settings) -> list[Names]:
    """Return shuffled cycles of single families, and random sets of effects."""
    counts = settings.counts
    sets = shuffled_cycles(rng, settings.effects, counts.singles)
    sets += shuffled_cycles(rng, settings.outside, counts.outsides)
    for size, count in ((2, counts.pairs), (3, counts.triples), (4, counts.fours)):
        sets += [draw_set(rng, settings, size) for _ in range(count)]
    return sets


def shuffled_cycles(rng: np.random.Generator, names: Sequence[str], count: int) -> list[Names]:
    """Return each name about equally often, in random order within a cycle."""
    found: list[Names] = []
    while len(found) < count:
        found += [(names[i],) for i in rng.permutation(len(names))]
    return found[:count]


def draw_set(rng: np.random.Generator, settings: Settings, size: int) -> Names:
    """Return a random set of effects that may be hidden together."""
    names = settings.effects
    possible = allowed_sources if settings.generator == "mechanism" else is_distinguishable
    while True:
        chosen = tuple(names[i] for i in sorted(rng.choice(len(names), size, replace=False)))
        if possible(chosen):
            return chosen


def is_distinguishable(names: Names) -> bool:
    """Return whether effects may be hidden together."""
    return not any(frozenset(pair) in INDISTINGUISHABLE_PAIRS for pair in combinations(names, 2))


def plan_limits(settings: Settings) -> list[PlannedCase]:
    """Return the cases of the detection limits. Every size has the same draws."""
    base = settings.first + LIMITS_FIRST_SEED
    cases = list(product(settings.effects, range(settings.limited), settings.sizes))
    order = np.random.default_rng([base, RANDOM_STREAMS["furniture"]]).permutation(len(cases))
    found = []
    for k, (name, number, size) in enumerate(cases[i] for i in order):
        seed = base + 1000 * settings.effects.index(name) + number
        found.append(PlannedCase(f"case_{k:04}", (name,), seed, size=size))
    return found
