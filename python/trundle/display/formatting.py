"""Numbers and names in representations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

__all__ = ["format_change", "format_number", "join_names"]

MAX_NAMES = 4
"""Maximum number of names in a list."""


def format_number(value: float | Any, digits: int = 4) -> str:
    """Format a number; a dash for None and NaN."""
    return "–" if value is None or math.isnan(value) else f"{value:.{digits}g}"


def join_names(names: Sequence[str]) -> str:
    """Return names separated by commas; of a long list the first ones and the last one."""
    if len(names) <= MAX_NAMES:
        return ", ".join(names)
    return f"{', '.join(names[: MAX_NAMES - 2])}, …, {names[-1]}"


def format_change(before: float | Any, after: float | Any, unit: str, digits: int = 3) -> str:
    """Format a metric before and after."""
    return f"{format_number(before, digits)} → {format_number(after, digits)} {unit}"
