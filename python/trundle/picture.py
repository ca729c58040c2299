"""Picture files of recordings, and outlines of objects."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle.recording import Recording, TrundleError

__all__ = ["draw", "outlines", "place_outline"]

SUFFIXES = (".png", ".svg", ".pdf")

Floats = NDArray[np.float64]


def draw(recording: Recording, path: Path) -> None:
    """Draw a recording and save it.

    Parameters
    ----------
    recording : Recording
        What to draw.
    path : Path
        Output file with the suffix .png, .svg or .pdf.

    Raises
    ------
    TrundleError
        If the suffix is another one, or the recording cannot be prepared.
    """
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise TrundleError(f"{path}: unknown suffix; use one of {', '.join(SUFFIXES)}")
    from trundle import plots
    from trundle.plots.style import save

    save(plots.recording(recording), path)


def outlines(described: Mapping[str, Any]) -> list[Floats]:
    """Return the shapes of the object as closed outlines (n, 2), m, object frame; empty on a rail."""
    fixtures = described.get("fixture") or [{"polygon": described.get("footprint") or []}]
    return [closed_outline(fixture) for fixture in fixtures if fixture.get("polygon") or fixture.get("disc")]


def closed_outline(fixture: Mapping[str, Any]) -> Floats:
    """Return one polygon or disc as a closed outline (n, 2), m, object frame."""
    if fixture.get("polygon"):
        return np.asarray([*fixture["polygon"], fixture["polygon"][0]], dtype=float)
    x, y, radius = fixture["disc"]
    angle = np.linspace(0.0, 2.0 * np.pi, 49)
    return np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)])


def place_outline(outline: Floats, at: Floats) -> Floats:
    """Return an outline (n, 2) of the object frame in the world, for the object at `at` (x, y, theta)."""
    cos, sin = np.cos(at[2]), np.sin(at[2])
    placed: Floats = outline @ np.array([[cos, sin], [-sin, cos]]) + at[:2]
    return placed
