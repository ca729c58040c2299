"""Shares with intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

__all__ = ["Share", "calibration", "share"]

Z = 1.959964
"""Of a two-sided interval of 95 %."""


@dataclass(frozen=True)
class Share:
    """So many of so many, with Wilson's interval of 95 %."""

    hits: int
    total: int

    @property
    def value(self) -> float:
        """The share; NaN of nothing."""
        return self.hits / self.total if self.total else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's score interval (1927); all of it if there is nothing."""
        if not self.total:
            return 0.0, 1.0
        n, p = self.total, self.value
        middle = (p + Z * Z / (2 * n)) / (1 + Z * Z / n)
        half = Z / (1 + Z * Z / n) * math.sqrt(p * (1 - p) / n + Z * Z / (4 * n * n))
        return max(0.0, middle - half), min(1.0, middle + half)

    def text(self) -> str:
        """Return `96.0 % [80 to 99], 24 of 25`."""
        if not self.total:
            return "no case"
        low, high = (100 * end for end in self.interval)
        return f"{100 * self.value:.1f} % [{low:.1f} to {high:.1f}], {self.hits} of {self.total}"


def share(outcomes: Iterable[bool]) -> Share:
    """Count outcomes."""
    found = list(outcomes)
    return Share(sum(found), len(found))


def calibration(
    answers: Sequence[tuple[float, bool]], edges: Sequence[float] = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)
) -> list[tuple[float, Share]]:
    """Return for each bin of probability that is not empty the mean that was said, and the share right."""
    rows = []
    for low, high in pairwise(edges):
        last = high == edges[-1]
        inside = [(p, right) for p, right in answers if low <= p < high or (last and p == high)]
        if inside:
            rows.append((sum(p for p, _ in inside) / len(inside), share(right for _, right in inside)))
    return rows
