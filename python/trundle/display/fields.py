"""Cards of data classes: one line for each field."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from trundle.display.card import Card, Displayed, clip
from trundle.display.formatting import format_number

__all__ = ["DisplayedFields", "describe_value"]

MAX_TEXT = 70
"""Most characters of a value."""


class DisplayedFields(Displayed):
    """A data class whose representation names its fields, arrays by their shapes.

    Fields with ``repr=False`` are left out.
    """

    def _card(self) -> Card:
        names = [field.name for field in fields(self) if field.repr]  # type: ignore[arg-type]
        facts = [(name, describe_value(getattr(self, name))) for name in names]
        kind = type(self)
        return Card(f"{kind.__module__.rpartition('.')[0]}.{kind.__name__}", facts)


def describe_value(value: Any) -> str:
    """Return a short text for a value: the shape of an array, the keys of a mapping of arrays."""
    if isinstance(value, np.ndarray):
        return f"array {value.shape}"
    if isinstance(value, float):
        return format_number(value)
    if isinstance(value, Mapping):
        parts = [f"{key}: {describe_value(item)}" for key, item in value.items()]
        return clip(", ".join(parts) or "none", MAX_TEXT)
    if isinstance(value, list | tuple) and value:
        return clip(f"{len(value)}: {', '.join(map(describe_value, value))}", MAX_TEXT)
    return clip("none" if value is None or value in ([], ()) else str(value), MAX_TEXT)
